// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/refinement.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pcl_ssfr {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kFreeMotion = 1e-6;  // eigenvalues below this share of the largest are motions left free
constexpr double kKeptMatches = 0.02; // of the final distance: motion of the pose that leaves the matches as they are
constexpr double kLeverArm = 5;       // [m] makes rotations and translations comparable in the eigenvalue test

/// Normal equations of the plane distances, about a fixed centre.
struct NormalEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  double weight = 0;
  double squares = 0;
  Eigen::Index matches = 0;

  /// A place \p p (relative to the centre) with distance \p r to a plane of normal \p n.
  void
  add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, double r, double w)
  {
    Vector6 j;
    j << p.cross(n), n;
    const Vector6 weighted = w * j;
    hessian.noalias() += weighted * j.transpose();
    gradient += r * weighted;
    weight += w;
    squares += w * r * r;
    ++matches;
  }

  /// The surface around a place reaches \p extent [m] (one standard deviation) to both sides: it binds the rotation.
  void
  addSpread(const Eigen::Vector3d& extent, const Eigen::Vector3d& n, double w)
  {
    const Eigen::Vector3d j = extent.cross(n);
    const Eigen::Vector3d weighted = w * j;
    hessian.topLeftCorner<3, 3>().noalias() += weighted * j.transpose();
    gradient.head<3>() += extent.dot(n) * weighted;
  }

  NormalEquations&
  operator+=(const NormalEquations& other)
  {
    hessian += other.hessian;
    gradient += other.gradient;
    weight += other.weight;
    squares += other.squares;
    matches += other.matches;
    return *this;
  }

  /// The step that solves the equations in the motions that they determine.
  Vector6
  solve() const
  {
    Vector6 units;
    units << Eigen::Vector3d::Constant(1 / kLeverArm), Eigen::Vector3d::Ones();
    const Matrix6 scaled = units.asDiagonal() * hessian * units.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Matrix6> solver(scaled);
    const Vector6 projected = solver.eigenvectors().transpose() * (units.asDiagonal() * gradient);
    Vector6 step = Vector6::Zero();
    for (int k = 0; k < 6; ++k)
      if (solver.eigenvalues()[k] > kFreeMotion * solver.eigenvalues()[5])
        step -= solver.eigenvectors().col(k) * (projected[k] / solver.eigenvalues()[k]);
    return units.asDiagonal() * step;
  }
};

/// Geman-McClure weight of distance \p r at scale \p s.
double
robustWeight(double r, double s)
{
  const double q = s * s / (s * s + r * r);
  return q * q;
}

/// Call \p add(i, sum) for i = 0 ... count - 1 and add all sums to \p equations. The chunks do not depend on the number
/// of threads, so neither do the bits.
template <typename Add>
void
addInChunks(Eigen::Index count, int threads, NormalEquations& equations, const Add& add)
{
  constexpr Eigen::Index kChunk = 1024;
  const Eigen::Index chunks = (count + kChunk - 1) / kChunk;
  std::vector<NormalEquations> sums(static_cast<std::size_t>(chunks));
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
  for (Eigen::Index k = 0; k < chunks; ++k) {
    NormalEquations sum; // not in its place: neighbours would share lines of the caches
    for (Eigen::Index i = k * kChunk; i < std::min(count, (k + 1) * kChunk); ++i)
      add(i, sum);
    sums[static_cast<std::size_t>(k)] = sum;
  }
  for (const NormalEquations& sum : sums)
    equations += sum;
}

/// What a step of a refinement starts from.
struct Step {
  Eigen::Isometry3d T_target_source;
  Eigen::Vector3d centre;
  PatchIndex::Tolerance tolerance;
  double scale;      ///< of the robust weight [m]
  bool find_matches; ///< else the pose has hardly moved since they were found, and they are kept

  /// The match of a place, found or \p known; -1: none.
  int
  match(const PatchIndex& index, const Eigen::Vector3d& p, const Eigen::Vector3d& n, int& known) const
  {
    if (find_matches)
      known = index.find(p.cast<float>(), n.cast<float>(), tolerance);
    return known;
  }
  /// Whether a match found in an earlier step is still near enough.
  bool
  isWithin(double distance) const
  {
    return find_matches || std::abs(distance) < static_cast<double>(tolerance.distance);
  }
};

/// The loop that both refinements share; \p accumulate(step, equations) adds the matches.
template <typename Accumulate>
Refinement
refine(const Eigen::Isometry3d& T_start,
       const Eigen::Vector3d& centre,
       const RefinementOptions& options,
       const Accumulate& accumulate)
{
  Refinement result;
  result.T_target_source = T_start;
  result.centre = centre;
  const double first = options.match.distance;
  const double last = std::min(options.final_distance, first);
  const int shrinking = std::max(1, options.steps / 2);
  double moved = std::numeric_limits<double>::infinity(); // since the matches were found [m]
  for (int step = 0; step < options.steps; ++step) {
    const double f = std::min(1.0, static_cast<double>(step) / shrinking);
    PatchIndex::Tolerance tolerance = options.match;
    tolerance.distance = static_cast<float>(first * std::pow(last / first, f));
    const Step state = {result.T_target_source,
                        centre,
                        tolerance,
                        0.5 * static_cast<double>(tolerance.distance),
                        moved > kKeptMatches * last};
    if (state.find_matches)
      moved = 0;
    NormalEquations equations;
    accumulate(state, equations);
    result.steps = step + 1;
    result.hessian = equations.hessian;
    result.weight = equations.weight;
    result.matches = equations.matches;
    result.rms = equations.weight > 0 ? std::sqrt(equations.squares / equations.weight) : 0;
    if (equations.matches < 3)
      break;
    const Vector6 motion = equations.solve();
    const Eigen::Isometry3d delta = Eigen::Translation3d(centre) * expSe3(motion) * Eigen::Translation3d(-centre);
    result.T_target_source = delta * result.T_target_source;
    moved += kLeverArm * motion.head<3>().norm() + motion.tail<3>().norm();
    if (f >= 1 && motion.head<3>().norm() < options.min_step && motion.tail<3>().norm() < options.min_step)
      break;
  }
  result.T_target_source.linear() = Eigen::Quaterniond(result.T_target_source.linear()).normalized().toRotationMatrix();
  return result;
}

} // namespace

Eigen::Isometry3d
expSe3(const Eigen::Matrix<double, 6, 1>& motion)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const double angle = motion.head<3>().norm();
  if (angle > 0)
    T.linear() = Eigen::AngleAxisd(angle, motion.head<3>() / angle).toRotationMatrix();
  T.translation() = motion.tail<3>();
  return T;
}

Refinement
refinePatches(const PlanarPatches& source,
              const PatchIndex& target,
              const Eigen::Isometry3d& T_target_source,
              const RefinementOptions& options)
{
  if (source.size() == 0)
    return refine(T_target_source, Eigen::Vector3d::Zero(), options, [](const auto&...) {});
  const Eigen::Vector3d centre = T_target_source * Eigen::Vector3d(source.samples.points.rowwise().mean());
  std::vector<int> matches(static_cast<std::size_t>(source.size()), -1);
  return refine(T_target_source, centre, options, [&](const Step& step, NormalEquations& equations) {
    const Eigen::Isometry3d& T = step.T_target_source;
    for (Eigen::Index i = 0; i < source.size(); ++i) {
      const Eigen::Vector3d p = T * source.samples.points.col(i);
      const Eigen::Vector3d normal = T.linear() * source.samples.normals.col(i);
      const int match = step.match(target, p, normal, matches[static_cast<std::size_t>(i)]);
      if (match < 0)
        continue;
      const Eigen::Vector3d n = target.normal(match).cast<double>();
      const double r = (p - target.centroid(match).cast<double>()).dot(n);
      if (!step.isWithin(r))
        continue;
      const double w =
          source.samples.weights[i] * robustWeight(r, step.scale) / target.distanceVariance(match, p.cast<float>());
      equations.add(p - centre, n, r, w);
      const Eigen::Vector3d major = T.linear() * source.majors.col(i);
      equations.addSpread(source.samples.extents[i] / kHalfWidth * major, n, w);
      equations.addSpread(source.half_minors[i] / kHalfWidth * normal.cross(major), n, w);
    }
  });
}

SurfacePoints
drawSurfacePoints(const ThinnedCloud& cloud, const PlanarPatches& patches, int per_patch)
{
  const auto share = [&](std::uint32_t count) { return std::min(count, static_cast<std::uint32_t>(per_patch)); };
  Eigen::Index total = 0;
  for (const std::uint32_t count : patches.counts)
    total += share(count);
  SurfacePoints surface;
  surface.points.resize(3, total);
  surface.normals.resize(3, total);
  Eigen::Index next = 0;
  for (std::size_t i = 0; i < patches.counts.size(); ++i) {
    const std::uint32_t count = patches.counts[i];
    const std::uint32_t drawn = share(count);
    for (std::uint32_t k = 0; k < drawn; ++k, ++next) {
      const std::uint32_t point = patches.first_point[i] + (2 * k + 1) * count / (2 * drawn);
      surface.points.col(next) = cloud.points.col(point);
      surface.normals.col(next) = patches.samples.normals.col(static_cast<Eigen::Index>(i)).cast<float>();
    }
  }
  return surface;
}

Refinement
refineMutual(const SurfacePoints& source,
             const PatchIndex& source_planes,
             const SurfacePoints& target,
             const PatchIndex& target_planes,
             const Eigen::Isometry3d& T_target_source,
             const RefinementOptions& options)
{
  if (source.points.cols() == 0 || target.points.cols() == 0)
    return refine(T_target_source, Eigen::Vector3d::Zero(), options, [](const auto&...) {});
  const Eigen::Vector3d centre = T_target_source * Eigen::Vector3d(source.points.cast<double>().rowwise().mean());
  std::vector<int> source_matches(static_cast<std::size_t>(source.points.cols()), -1);
  std::vector<int> target_matches(static_cast<std::size_t>(target.points.cols()), -1);
  return refine(T_target_source, centre, options, [&](const Step& step, NormalEquations& equations) {
    const Eigen::Isometry3d& T = step.T_target_source;
    addInChunks(source.points.cols(), options.threads, equations, [&](Eigen::Index i, NormalEquations& sum) {
      const Eigen::Vector3d p = T * source.points.col(i).cast<double>();
      const Eigen::Vector3d normal = T.linear() * source.normals.col(i).cast<double>();
      const int match = step.match(target_planes, p, normal, source_matches[static_cast<std::size_t>(i)]);
      if (match < 0)
        return;
      const Eigen::Vector3d n = target_planes.normal(match).cast<double>();
      const double r = (p - target_planes.centroid(match).cast<double>()).dot(n);
      if (step.isWithin(r))
        sum.add(p - centre, n, r, robustWeight(r, step.scale) / target_planes.distanceVariance(match, p.cast<float>()));
    });
    // The other way round it is the plane that moves: its distance to a fixed point shrinks along its
    // normal.
    const Eigen::Isometry3d T_source_target = T.inverse();
    addInChunks(target.points.cols(), options.threads, equations, [&](Eigen::Index i, NormalEquations& sum) {
      const Eigen::Vector3d q = target.points.col(i).cast<double>();
      const Eigen::Vector3d p = T_source_target * q;
      const Eigen::Vector3d normal = T_source_target.linear() * target.normals.col(i).cast<double>();
      const int match = step.match(source_planes, p, normal, target_matches[static_cast<std::size_t>(i)]);
      if (match < 0)
        return;
      const Eigen::Vector3d n = T.linear() * source_planes.normal(match).cast<double>();
      const double r = (T * source_planes.centroid(match).cast<double>() - q).dot(n);
      if (step.isWithin(r))
        sum.add(q - centre, n, r, robustWeight(r, step.scale) / source_planes.distanceVariance(match, p.cast<float>()));
    });
  });
}

} // namespace pcl_ssfr
