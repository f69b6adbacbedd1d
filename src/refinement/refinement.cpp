// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/refinement.h"

#include "common/even_draw.h"
#include "common/parallel.h"
#include "refinement/plane_equations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pcl_ssfr {

namespace {

/// What a step of a refinement starts from.
struct Step {
  Eigen::Isometry3d T_target_source;
  Eigen::Vector3d centre;
  PatchIndex::Tolerance tolerance;
  double scale;      ///< of the robust weight [m]
  bool find_matches; ///< else the surface has hardly moved since they were found, and they are kept
};

/// Call \p add_source(first, count, sum) for blocks of the indices 0 ... source_count - 1, \p add_target likewise, and
/// add all sums to \p equations. The blocks do not depend on the number of threads, so neither do the bits.
template <typename AddSource, typename AddTarget>
void
addInBlocks(Eigen::Index source_count,
            Eigen::Index target_count,
            int threads,
            PlaneEquations& equations,
            const AddSource& add_source,
            const AddTarget& add_target)
{
  constexpr Eigen::Index kBlock = PlaceBlock::kSize;
  const auto blocksOf = [&](Eigen::Index count) { return (count + kBlock - 1) / kBlock; };
  const Eigen::Index of_source = blocksOf(source_count);
  const Eigen::Index blocks = of_source + blocksOf(target_count);
  std::vector<PlaneEquations> sums(static_cast<std::size_t>(blocks));
  forEachInParallel(blocks, 4, threads, [&](Eigen::Index k) {
    PlaneEquations sum; // not in its place: neighbours would share lines of the caches
    const Eigen::Index first = (k < of_source ? k : k - of_source) * kBlock;
    if (k < of_source)
      add_source(first, std::min(kBlock, source_count - first), sum);
    else
      add_target(first, std::min(kBlock, target_count - first), sum);
    sums[static_cast<std::size_t>(k)] = sum;
  });
  for (const PlaneEquations& sum : sums)
    equations += sum;
}

/// Call \p visit(i, p, n, meeting) for those of \p count places from column \p first on that meet a plane: p and n are
/// place i and its normal after the motion; \p found holds the plane of every place.
template <typename Columns, typename Visit>
void
forEachMeeting(const Columns& points,
               const Columns& normals,
               const Eigen::Isometry3d& T_moved,
               Eigen::Index first,
               Eigen::Index count,
               const PatchIndex& planes,
               const Step& step,
               std::vector<int>& found,
               const Visit& visit)
{
  PlaceBlock places;
  places.move(points.col(first).data(), normals.col(first).data(), count, T_moved);
  int* const found_here = &found[static_cast<std::size_t>(first)];
  if (step.find_matches)
    places.find(planes, step.tolerance, found_here);
  const auto farthest = static_cast<double>(step.tolerance.distance);
  for (std::size_t k = 0; k < places.count; ++k) {
    if (found_here[k] < 0)
      continue;
    const Eigen::Vector3d p = places.place(k);
    const PatchIndex::Meeting at = planes.meet(found_here[k], p);
    if (step.find_matches || std::abs(at.distance) < farthest)
      visit(first + static_cast<Eigen::Index>(k), p, places.normal(k), at);
  }
}

/// Add what the vertical says of the tilt, in the unit of the matches: their mean weight over the square of their
/// distances is what one of them says of its distance.
void
addVertical(const KnownVertical& vertical,
            const Eigen::Matrix3d& R_target_source,
            double least_rms,
            PlaneEquations& equations)
{
  const double mean_weight = equations.weight / static_cast<double>(equations.matches);
  const double square = std::max(equations.squares / equations.weight, least_rms * least_rms);
  const double information = mean_weight * square / (vertical.deviation * vertical.deviation);
  const Eigen::Vector3d up = R_target_source * vertical.up_source;
  equations.hessian.topLeftCorner<3, 3>() += information * (Eigen::Matrix3d::Identity() - up * up.transpose());
  equations.gradient.head<3>() -= information * up.cross(vertical.up_target);
}

/// The loop that both refinements share; \p accumulate(step, equations) adds the matches. \p conclude(step) gives the
/// statistics of the matches as they are at the pose where it ends.
template <typename Accumulate, typename Conclude>
Refinement
refine(const Eigen::Isometry3d& T_start,
       const Eigen::Vector3d& centre,
       const RefinementOptions& options,
       const Accumulate& accumulate,
       const Conclude& conclude)
{
  Refinement result;
  result.T_target_source = T_start;
  result.centre = centre;
  const double first = options.match.distance;
  const double last = std::min(options.final_distance, first);
  const int shrinking = std::max(1, options.steps / 2);
  PatchIndex::Tolerance tolerance = options.match;
  // Root mean square motion of the matched surface along its normals since the matches were found [m].
  double moved = std::numeric_limits<double>::infinity();
  for (int step = 0; step < options.steps; ++step) {
    const double f = first > last ? std::min(1.0, static_cast<double>(step) / shrinking) : 1;
    tolerance.distance = static_cast<float>(first * std::pow(last / first, f));
    const Step state = {result.T_target_source,
                        centre,
                        tolerance,
                        0.5 * static_cast<double>(tolerance.distance),
                        moved > options.least_rms};
    if (state.find_matches)
      moved = 0;
    PlaneEquations equations;
    accumulate(state, equations);
    result.steps = step + 1;
    result.hessian = equations.fullHessian();
    result.matches = equations.matches;
    result.rms = equations.rms();
    if (equations.matches < 3)
      break;
    if (options.vertical)
      addVertical(*options.vertical, result.T_target_source.linear(), options.least_rms, equations);
    const Eigen::Matrix<double, 6, 1> motion = equations.solve();
    const Eigen::Isometry3d delta = Eigen::Translation3d(centre) * expSe3(motion) * Eigen::Translation3d(-centre);
    result.T_target_source = delta * result.T_target_source;
    moved += std::sqrt(std::max(0.0, motion.dot(result.hessian * motion)) / equations.weight);
    const bool has_settled =
        f >= 1 && motion.head<3>().norm() < options.min_step && motion.tail<3>().norm() < options.min_step;
    if (has_settled || options.deadline.hasPassed())
      break;
  }
  result.T_target_source.linear() = Eigen::Quaterniond(result.T_target_source.linear()).normalized().toRotationMatrix();
  result.statistics =
      conclude(Step{result.T_target_source, centre, tolerance, 0.5 * static_cast<double>(tolerance.distance), false});
  return result;
}

EquationStatistics
noStatistics(const Step& /*step*/)
{
  return {};
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
    return refine(
        T_target_source, Eigen::Vector3d::Zero(), options, [](const auto&...) {}, noStatistics);
  const Eigen::Vector3d centre = T_target_source * Eigen::Vector3d(source.samples.points.rowwise().mean());
  std::vector<int> found(static_cast<std::size_t>(source.size()), -1);
  const auto accumulate = [&](const Step& step, PlaneEquations& equations) {
    const Eigen::Isometry3d& T = step.T_target_source;
    const auto addPatches = [&](Eigen::Index first, Eigen::Index count, PlaneEquations& sum) {
      PlaneMatches matches;
      MatchSpread along, across;
      const auto add =
          [&](Eigen::Index i, const Eigen::Vector3d& p, const Eigen::Vector3d& normal, const PatchIndex::Meeting& at) {
            const Eigen::Vector3d major = T.linear() * source.majors.col(i);
            along.set(matches.count, source.samples.extents[i] / kHalfWidth * major);
            across.set(matches.count, source.half_minors[i] / kHalfWidth * normal.cross(major));
            matches.add(p - centre, at.normal, at.distance, std::sqrt(source.samples.weights[i]) / at.variance);
          };
      forEachMeeting(source.samples.points, source.samples.normals, T, first, count, target, step, found, add);
      addMatches(matches, step.scale, sum);
      addSpread(matches, along, sum);
      addSpread(matches, across, sum);
    };
    addInBlocks(source.size(), 0, 1, equations, addPatches, [](const auto&...) {});
  };
  return refine(T_target_source, centre, options, accumulate, noStatistics);
}

SurfacePoints
drawSurfacePoints(const ThinnedCloud& cloud, const PlanarPatches& patches, int drawn_of_group, int group, int most)
{
  auto size = static_cast<std::uint64_t>(group);
  const auto share = [&](std::uint64_t count) {
    return std::min(count, static_cast<std::uint64_t>(drawn_of_group) * ((count + size - 1) / size));
  };
  const auto total = [&] {
    std::uint64_t sum = 0;
    for (const std::uint32_t count : patches.counts)
      sum += share(count);
    return sum;
  };
  const std::uint64_t largest =
      patches.counts.empty() ? 0 : *std::max_element(patches.counts.begin(), patches.counts.end());
  while (most > 0 && size < largest && total() > static_cast<std::uint64_t>(most))
    size *= 2;
  SurfacePoints surface;
  for (Eigen::Index i = 0; i < patches.size(); ++i)
    surface.facing.push_back(patches.samples.facing.size() == 0 || patches.samples.facing[i] >= kMinFacing ? 1 : 0);
  surface.points.resize(3, static_cast<Eigen::Index>(total()));
  surface.normals.resize(3, surface.points.cols());
  surface.patches.reserve(static_cast<std::size_t>(surface.points.cols()));
  Eigen::Index next = 0;
  for (std::size_t i = 0; i < patches.counts.size(); ++i) {
    const std::uint64_t count = patches.counts[i];
    const std::uint64_t drawn = share(count);
    for (std::uint64_t k = 0; k < drawn; ++k, ++next) {
      const std::uint64_t point = patches.first_point[i] + evenlyDrawn(k, drawn, count);
      surface.points.col(next) = cloud.points.col(static_cast<Eigen::Index>(point));
      surface.normals.col(next) = patches.samples.normals.col(static_cast<Eigen::Index>(i)).cast<float>();
      surface.patches.push_back(static_cast<std::int32_t>(i));
    }
  }
  return surface;
}

namespace {

/// Points of both scans on the planes of the other one, found once and kept while the surface hardly moves.
class MutualMatches {
public:
  MutualMatches(const ScanSurface& source, const ScanSurface& target)
      : source_(source.points), source_planes_(source.planes), target_(target.points), target_planes_(target.planes),
        found_of_source_(static_cast<std::size_t>(source_.points.cols()), -1),
        found_of_target_(static_cast<std::size_t>(target_.points.cols()), -1)
  {}

  void
  addEquations(const Step& step, int threads, PlaneEquations& equations)
  {
    const Eigen::Isometry3d& T = step.T_target_source;
    const Eigen::Isometry3d T_source_target = T.inverse();
    const auto addSource = [&](Eigen::Index first, Eigen::Index count, PlaneEquations& sum) {
      PlaneMatches matches;
      const auto add = [&](Eigen::Index, const auto& p, const auto&, const PatchIndex::Meeting& at) {
        matches.add(p - step.centre, at.normal, at.distance, 1 / at.variance);
      };
      forEachMeeting(source_.points, source_.normals, T, first, count, target_planes_, step, found_of_source_, add);
      addMatches(matches, step.scale, sum);
    };
    // The other way round it is the plane that moves: its distance to a fixed point shrinks along its normal.
    const auto addTarget = [&](Eigen::Index first, Eigen::Index count, PlaneEquations& sum) {
      PlaneMatches matches;
      const auto add = [&](Eigen::Index i, const auto&, const auto&, const PatchIndex::Meeting& at) {
        const Eigen::Vector3d q = target_.points.col(i).cast<double>();
        matches.add(q - step.centre, T.linear() * at.normal, -at.distance, 1 / at.variance);
      };
      forEachMeeting(
          target_.points, target_.normals, T_source_target, first, count, source_planes_, step, found_of_target_, add);
      addMatches(matches, step.scale, sum);
    };
    addInBlocks(source_.points.cols(), target_.points.cols(), threads, equations, addSource, addTarget);
  }

  /// The plane distance of a match that follows from the noise of those found.
  double
  distanceByNoise(const Step& step, const NoiseRule& rule) const
  {
    WeightedDistances found;
    forEachMatch(step, [&](std::size_t, std::size_t, const auto&, const auto&, double distance, double weight) {
      found.distances.push_back(distance);
      found.weights.push_back(weight);
    });
    return matchDistanceByNoise(found, rule);
  }

  /// Of the matches at the pose where the refinement ends; patches that do not face their sensors keep the share
  /// \p unseen_curvature of their curvature.
  EquationStatisticsSum
  statistics(const Step& step, double unseen_curvature) const
  {
    EquationStatisticsSum sum(source_.facing.size(), target_.facing.size(), step.scale);
    forEachMatch(step,
                 [&](std::size_t s,
                     std::size_t t,
                     const Eigen::Vector3d& p,
                     const Eigen::Vector3d& normal,
                     double distance,
                     double weight) {
                   const double share = source_.facing[s] && target_.facing[t] ? 1 : unseen_curvature;
                   sum.add(s, t, p - step.centre, normal, distance, weight, share);
                 });
    return sum;
  }

private:
  /// Call \p visit(source patch, target patch, place, normal, distance, weight) for every match found; see
  /// PlaneMatches.
  template <typename Visit>
  void
  forEachMatch(const Step& step, const Visit& visit) const
  {
    const Eigen::Isometry3d& T = step.T_target_source;
    const Eigen::Isometry3d T_source_target = T.inverse();
    const auto farthest = static_cast<double>(step.tolerance.distance);
    for (std::size_t i = 0; i < found_of_source_.size(); ++i) {
      if (found_of_source_[i] < 0)
        continue;
      const Eigen::Vector3d p = T * Eigen::Vector3d(source_.points.col(static_cast<Eigen::Index>(i)).cast<double>());
      const PatchIndex::Meeting at = target_planes_.meet(found_of_source_[i], p);
      if (std::abs(at.distance) < farthest)
        visit(static_cast<std::size_t>(source_.patches[i]),
              static_cast<std::size_t>(found_of_source_[i]),
              p,
              at.normal,
              at.distance,
              1 / at.variance);
    }
    for (std::size_t i = 0; i < found_of_target_.size(); ++i) {
      if (found_of_target_[i] < 0)
        continue;
      const Eigen::Vector3d q = target_.points.col(static_cast<Eigen::Index>(i)).cast<double>();
      const PatchIndex::Meeting at = source_planes_.meet(found_of_target_[i], T_source_target * q);
      if (std::abs(at.distance) < farthest)
        visit(static_cast<std::size_t>(found_of_target_[i]),
              static_cast<std::size_t>(target_.patches[i]),
              q,
              Eigen::Vector3d(T.linear() * at.normal),
              -at.distance,
              1 / at.variance);
    }
  }

  const SurfacePoints& source_;
  const PatchIndex& source_planes_;
  const SurfacePoints& target_;
  const PatchIndex& target_planes_;
  std::vector<int> found_of_source_; ///< plane of the target for each point of the source; -1: none
  std::vector<int> found_of_target_; ///< and the other way round
};

} // namespace

Refinement
refineMutual(const ScanSurface& source,
             const ScanSurface& target,
             const Eigen::Isometry3d& T_target_source,
             const RefinementOptions& options)
{
  if (source.points.points.cols() == 0 || target.points.points.cols() == 0)
    return refine(
        T_target_source, Eigen::Vector3d::Zero(), options, [](const auto&...) {}, noStatistics);
  const Eigen::Vector3d centre =
      T_target_source * Eigen::Vector3d(source.points.points.cast<double>().rowwise().mean());
  MutualMatches matches(source, target);
  return refine(
      T_target_source,
      centre,
      options,
      [&](const Step& step, PlaneEquations& equations) { matches.addEquations(step, options.threads, equations); },
      [&](const Step& step) { return matches.statistics(step, options.unseen_curvature).statistics(); });
}

namespace {

/// A step at a pose that stays where it is, with new matches within a distance.
Step
stepAt(const Eigen::Isometry3d& T_target_source,
       const Eigen::Vector3d& centre,
       const PatchIndex::Tolerance& tolerance,
       double distance)
{
  Step step = {T_target_source, centre, tolerance, 0.5 * distance, true};
  step.tolerance.distance = static_cast<float>(distance);
  return step;
}

} // namespace

double
mutualMatchDistance(const ScanSurface& source,
                    const ScanSurface& target,
                    const Eigen::Isometry3d& T_target_source,
                    const RefinementOptions& options,
                    const NoiseRule& rule)
{
  if (2 * rule.deviations * rule.pose_deviation >= rule.most)
    return rule.most;
  MutualMatches matches(source, target);
  const Step wide = stepAt(T_target_source, Eigen::Vector3d::Zero(), options.match, rule.most);
  PlaneEquations ignored;
  matches.addEquations(wide, options.threads, ignored); // finds them
  return matches.distanceByNoise(wide, rule);
}

MutualFit
fitMutual(const ScanSurface& source,
          const ScanSurface& target,
          const Eigen::Isometry3d& T_target_source,
          const RefinementOptions& options,
          const NoiseRule& rule)
{
  MutualFit fit;
  Refinement& here = fit.refinement;
  here.T_target_source = T_target_source;
  fit.patches.resize(source.points.facing.size() + target.points.facing.size());
  if (source.points.points.cols() == 0 || target.points.points.cols() == 0)
    return fit;
  here.centre = T_target_source * Eigen::Vector3d(source.points.points.cast<double>().rowwise().mean());
  MutualMatches matches(source, target);
  const auto equationsOf = [&](const Step& step) {
    PlaneEquations equations;
    matches.addEquations(step, options.threads, equations);
    return equations;
  };
  const Step wide = stepAt(T_target_source, here.centre, options.match, rule.most);
  const PlaneEquations all = equationsOf(wide);
  fit.wide_weight = all.weight;
  fit.wide_rms = all.rms();
  fit.match_distance = matches.distanceByNoise(wide, rule);
  Step narrow = stepAt(T_target_source, here.centre, options.match, fit.match_distance);
  narrow.find_matches = false;
  const PlaneEquations equations = equationsOf(narrow);
  here.hessian = equations.fullHessian();
  here.rms = equations.rms();
  here.matches = equations.matches;
  fit.gradient = equations.gradient;
  const EquationStatisticsSum statistics = matches.statistics(narrow, options.unseen_curvature);
  here.statistics = statistics.statistics();
  fit.patches = statistics.patches();
  return fit;
}

} // namespace pcl_ssfr
