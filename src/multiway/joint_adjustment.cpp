// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/joint_adjustment.h"

#include "common/parallel.h"
#include "refinement/plane_equations.h"
#include "refinement/refinement.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

namespace pcl_ssfr {

namespace {

using Matrix6 = SurfaceEquations::Matrix6;
using Vector6 = SurfaceEquations::Vector6;
using Sparse = Eigen::SparseMatrix<double>;

/// Maps a small motion about one place to that of the same body about another, in the same axes.
Matrix6
carried(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
  return aboutOrigin(to - from).transpose();
}

/// Maps a small motion about a place, both in the map, to that about the origin of a frame at \p T_map_frame, in its
/// axes.
Matrix6
motionInto(const Eigen::Isometry3d& T_map_frame, const Eigen::Vector3d& place)
{
  Matrix6 axes = Matrix6::Zero();
  axes.topLeftCorner<3, 3>() = axes.bottomRightCorner<3, 3>() = T_map_frame.linear().transpose();
  return axes * carried(place, T_map_frame.translation());
}

/// Where the sensors are in the map. The unknowns are motions about these, so no result depends on how far they are
/// from the origin.
std::vector<Eigen::Vector3d>
sensorsOf(const std::vector<Eigen::Isometry3d>& poses, const std::vector<Eigen::Vector3d>& places)
{
  std::vector<Eigen::Vector3d> sensors;
  sensors.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    sensors.emplace_back(poses[i] * places[i]);
  return sensors;
}

/// The equations of a pair in motions of its source relative to its target about the target's sensor.
struct MapEquations {
  Matrix6 hessian, curvature;
  Matrix6 step; ///< stepMatrix()
  Vector6 gradient;
  Matrix6 carry; ///< a motion about the source's sensor as one about the target's
  double weight = 0, squares = 0;
};

/// A symmetric matrix of which each pair of scans adds the block of their relative motion: scans that are fixed have
/// none.
class Network {
public:
  Network(std::size_t scans, const std::vector<int>& fixed) : column_(scans, 0)
  {
    for (const int i : fixed)
      column_[static_cast<std::size_t>(i)] = -1;
    for (int& column : column_)
      if (column == 0) {
        column = 6 * size_;
        ++size_;
      }
  }
  int
  unknowns() const
  {
    return 6 * size_;
  }
  /// First column of a scan; -1: it is fixed.
  int
  column(std::size_t scan) const
  {
    return column_[scan];
  }
  void
  add(int source, int target, const Matrix6& block, const Matrix6& carry)
  {
    const int s = column_[static_cast<std::size_t>(source)];
    const int t = column_[static_cast<std::size_t>(target)];
    const Matrix6 mixed = -block * carry;
    addBlock(s, s, -carry.transpose() * mixed);
    addBlock(t, t, block);
    addBlock(s, t, mixed.transpose());
    addBlock(t, s, mixed);
  }
  Sparse
  matrix() const
  {
    Sparse m(unknowns(), unknowns());
    m.setFromTriplets(entries_.begin(), entries_.end());
    return m;
  }

private:
  void
  addBlock(int row, int column, const Matrix6& block)
  {
    if (row < 0 || column < 0)
      return;
    for (int c = 0; c < 6; ++c)
      for (int r = 0; r < 6; ++r)
        entries_.emplace_back(row + r, column + c, block(r, c));
  }

  std::vector<int> column_;
  int size_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
};

/// What the patches of one scan add to the covariance of the gradient of the network: a block for each two of the scans
/// that they meet, and itself.
struct ScanScatter {
  std::vector<std::size_t> scans; ///< itself first
  Eigen::MatrixXd blocks;         ///< six rows and columns of each
};

ScanScatter
scatterOf(std::size_t scan,
          const std::vector<std::size_t>& pairs_of_it,
          const std::vector<Eigen::Isometry3d>& poses,
          const std::vector<Eigen::Vector3d>& sensors,
          const std::vector<std::pair<int, int>>& pairs,
          const PatchGradientsFunction& patches)
{
  ScanScatter result;
  result.scans.push_back(scan);
  struct Met {
    PatchGradients relative; // of the motion of the source relative to the target
    Matrix6 own, other;      // those of this scan and of the other one from it
  };
  std::vector<Met> met;
  for (const std::size_t k : pairs_of_it) {
    const bool is_source = pairs[k].first == static_cast<int>(scan);
    const auto target = static_cast<std::size_t>(pairs[k].second);
    const auto source = static_cast<std::size_t>(pairs[k].first);
    const Matrix6 of_target = -motionInto(poses[target], sensors[target]).transpose();
    const Matrix6 of_source = -carried(sensors[source], sensors[target]).transpose() * of_target;
    met.push_back({patches(k, poses[target].inverse() * poses[source], is_source),
                   is_source ? of_source : of_target,
                   is_source ? of_target : of_source});
    result.scans.push_back(is_source ? target : source);
  }
  const auto size = static_cast<Eigen::Index>(6 * result.scans.size());
  result.blocks = Eigen::MatrixXd::Zero(size, size);
  Eigen::Index count = 0;
  for (const Met& m : met)
    count = std::max(count, m.relative.gradients.cols());
  std::vector<Eigen::Index> rows; // first ones of the scans that the patch meets
  std::vector<Vector6> gradients, offsets;
  for (Eigen::Index p = 0; p < count; ++p) {
    rows.assign(1, 0);
    gradients.assign(1, Vector6::Zero());
    offsets.assign(1, Vector6::Zero());
    for (std::size_t m = 0; m < met.size(); ++m) {
      const PatchGradients& relative = met[m].relative;
      if (p >= relative.offsets.cols() || relative.offsets.col(p).isZero(0))
        continue;
      rows.push_back(static_cast<Eigen::Index>(6 * (m + 1)));
      gradients.emplace_back(met[m].other * relative.gradients.col(p));
      offsets.emplace_back(met[m].other * relative.offsets.col(p));
      gradients.front() += met[m].own * relative.gradients.col(p);
      offsets.front() += met[m].own * relative.offsets.col(p);
    }
    for (std::size_t r = 0; r < rows.size() && rows.size() > 1; ++r)
      for (std::size_t c = 0; c <= r; ++c)
        result.blocks.block<6, 6>(rows[r], rows[c]).noalias() +=
            gradients[r] * gradients[c].transpose() + offsets[r] * offsets[c].transpose();
  }
  return result;
}

/// The covariance of the gradient of the network, in its unknowns.
Sparse
networkScatter(const std::vector<Eigen::Isometry3d>& poses,
               const std::vector<Eigen::Vector3d>& sensors,
               const std::vector<std::pair<int, int>>& pairs,
               const Network& network,
               const PatchGradientsFunction& patches,
               int threads)
{
  constexpr std::size_t kAtOnce = 16; // scans whose blocks are in memory
  std::vector<std::vector<std::size_t>> pairs_of(poses.size());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (const int i : {pairs[k].first, pairs[k].second})
      pairs_of[static_cast<std::size_t>(i)].push_back(k);
  std::map<std::pair<int, int>, Matrix6> sums; // of the lower half, by first row and column
  for (std::size_t first = 0; first < poses.size(); first += kAtOnce) {
    std::vector<ScanScatter> found(std::min(kAtOnce, poses.size() - first));
    forEachInParallel(static_cast<std::int64_t>(found.size()), 1, threads, [&](std::int64_t index) {
      const auto i = static_cast<std::size_t>(index);
      found[i] = scatterOf(first + i, pairs_of[first + i], poses, sensors, pairs, patches);
    });
    for (const ScanScatter& scan : found)
      for (std::size_t r = 0; r < scan.scans.size(); ++r)
        for (std::size_t c = 0; c <= r; ++c) {
          const int row = network.column(scan.scans[r]), column = network.column(scan.scans[c]);
          if (row < 0 || column < 0)
            continue;
          const Matrix6 block =
              scan.blocks.block<6, 6>(static_cast<Eigen::Index>(6 * r), static_cast<Eigen::Index>(6 * c));
          const auto place = sums.emplace(std::minmax(row, column, std::greater<>()), Matrix6::Zero()).first;
          place->second += row >= column ? block : Matrix6(block.transpose());
        }
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(72 * sums.size());
  for (const auto& [place, block] : sums)
    for (int c = 0; c < 6; ++c)
      for (int r = 0; r < 6; ++r) {
        entries.emplace_back(place.first + r, place.second + c, block(r, c));
        if (place.first != place.second)
          entries.emplace_back(place.second + c, place.first + r, block(r, c));
      }
  Sparse m(network.unknowns(), network.unknowns());
  m.setFromTriplets(entries.begin(), entries.end());
  return m;
}

void
damp(Sparse& m, double share)
{
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    m.coeffRef(i, i) += share * m.coeff(i, i) + 1e-9;
}

/// The equations of all pairs at the poses.
std::vector<MapEquations>
linearise(const std::vector<Eigen::Isometry3d>& poses,
          const std::vector<Eigen::Vector3d>& places,
          const std::vector<std::pair<int, int>>& pairs,
          const EquationsFunction& equations,
          int threads)
{
  const std::vector<Eigen::Vector3d> sensors = sensorsOf(poses, places);
  std::vector<MapEquations> found(pairs.size());
  forEachInParallel(static_cast<std::int64_t>(pairs.size()), 1, threads, [&](std::int64_t index) {
    const auto k = static_cast<std::size_t>(index);
    const auto source = static_cast<std::size_t>(pairs[k].first);
    const auto target = static_cast<std::size_t>(pairs[k].second);
    const SurfaceEquations e = equations(k, poses[target].inverse() * poses[source]);
    const Matrix6 a = motionInto(poses[target], sensors[target]);
    const auto inMap = [&](const Matrix6& m) { return Matrix6(a.transpose() * m * a); };
    const Matrix6 hessian = inMap(e.hessian);
    found[k] = {hessian,
                inMap(e.curvature),
                stepMatrix(hessian, inMap(e.full_curvature)),
                a.transpose() * e.gradient,
                carried(sensors[source], sensors[target]),
                e.weight,
                e.squares};
  });
  return found;
}

/// Root mean square of the plane distances [m].
double
rmsOf(const std::vector<MapEquations>& found)
{
  double weight = 0, squares = 0;
  for (const MapEquations& e : found) {
    weight += e.weight;
    squares += e.squares;
  }
  return weight > 0 ? std::sqrt(squares / weight) : 0.0;
}

/// Whether the matrix was positive definite: LDLT takes others as well, with steps that mean nothing.
bool
isFactored(const Eigen::SimplicialLDLT<Sparse>& solver)
{
  return solver.info() == Eigen::Success && (solver.vectorD().array() > 0).all();
}

/// A step towards where the gradient is zero, six numbers for each scan that is not fixed; empty: there is none.
Eigen::VectorXd
solveStep(const std::vector<MapEquations>& found,
          const std::vector<std::pair<int, int>>& pairs,
          Network network,
          double damping)
{
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(network.unknowns());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    network.add(pairs[k].first, pairs[k].second, found[k].step, found[k].carry);
    const int s = network.column(static_cast<std::size_t>(pairs[k].first));
    const int t = network.column(static_cast<std::size_t>(pairs[k].second));
    if (s >= 0)
      gradient.segment<6>(s) += found[k].carry.transpose() * found[k].gradient;
    if (t >= 0)
      gradient.segment<6>(t) -= found[k].gradient;
  }
  Sparse matrix = network.matrix();
  damp(matrix, damping);
  const Eigen::SimplicialLDLT<Sparse> solver(matrix);
  if (!isFactored(solver))
    return {};
  const Eigen::VectorXd step = -solver.solve(gradient);
  return step.allFinite() ? step : Eigen::VectorXd();
}

/// Move the scans by a step. Returns the largest motion, of rotations [rad] or of places [m].
double
move(std::vector<Eigen::Isometry3d>& poses,
     const Eigen::VectorXd& step,
     const Network& network,
     const std::vector<Eigen::Vector3d>& places)
{
  double moved = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int column = network.column(i);
    if (column < 0)
      continue;
    const Eigen::Vector3d sensor = poses[i] * places[i];
    poses[i] =
        Eigen::Translation3d(sensor) * expSe3(step.segment<6>(column)) * Eigen::Translation3d(-sensor) * poses[i];
    poses[i].linear() = Eigen::Quaterniond(poses[i].linear()).normalized().toRotationMatrix();
    moved = std::max({moved, step.segment<3>(column).norm(), step.segment<3>(column + 3).norm()});
  }
  return moved;
}

/// Covariance of each scan's pose about its own place, A^-1 B A^-1 of the network; zero of fixed ones. A is made of the
/// curvatures; where these have no minimum, of the hessians, which are larger: deviations are too small then.
std::vector<Matrix6>
covariancesOf(const std::vector<Eigen::Isometry3d>& poses,
              const std::vector<std::pair<int, int>>& pairs,
              const std::vector<MapEquations>& found,
              const Network& network,
              const std::vector<Eigen::Vector3d>& places,
              const PatchGradientsFunction& patches,
              const AdjustmentConfig& config,
              int threads)
{
  std::vector<Matrix6> covariances(poses.size(), Matrix6::Zero());
  if (network.unknowns() == 0)
    return covariances;
  Eigen::SimplicialLDLT<Sparse> solver;
  for (const Matrix6 MapEquations::*matrix : {&MapEquations::curvature, &MapEquations::hessian}) {
    Network sum = network;
    for (std::size_t k = 0; k < pairs.size(); ++k)
      sum.add(pairs[k].first, pairs[k].second, found[k].*matrix, found[k].carry);
    Sparse a = sum.matrix();
    damp(a, config.damping);
    solver.compute(a);
    if (isFactored(solver))
      break;
  }
  if (!isFactored(solver))
    return std::vector<Matrix6>(poses.size(), Matrix6::Constant(std::numeric_limits<double>::quiet_NaN()));
  const Sparse b = networkScatter(poses, sensorsOf(poses, places), pairs, network, patches, threads);
  forEachInParallel(static_cast<std::int64_t>(poses.size()), 1, threads, [&](std::int64_t index) {
    const auto i = static_cast<std::size_t>(index);
    const int column = network.column(i);
    if (column < 0)
      return;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(network.unknowns(), 6);
    unit.middleRows<6>(column).setIdentity();
    const Eigen::MatrixXd x = solver.solve(unit);
    covariances[i] = x.transpose() * (b * x);
  });
  return covariances;
}

} // namespace

double
dampingOf(const AdjustmentConfig& config, std::size_t scans)
{
  constexpr double kRounding = 1e-13; // of a sum of hundreds of terms: less damping would be lost in it
  const double of_row = std::max(kRounding, config.damping_of_row / std::pow(static_cast<double>(scans), 4));
  return std::min(config.damping, of_row);
}

JointAdjustment
adjustJointly(std::vector<Eigen::Isometry3d> poses,
              const std::vector<std::pair<int, int>>& pairs,
              const std::vector<int>& fixed,
              const std::vector<Eigen::Vector3d>& places,
              const EquationsFunction& equations,
              const PatchGradientsFunction& patches,
              const AdjustmentConfig& config,
              int threads)
{
  JointAdjustment result;
  const Network network(poses.size(), fixed);
  std::vector<MapEquations> found = linearise(poses, places, pairs, equations, threads);
  for (int round = 0; round < config.rounds && network.unknowns() > 0; ++round) {
    const Eigen::VectorXd step = solveStep(found, pairs, network, config.damping);
    if (step.size() == 0)
      break;
    const double moved = move(poses, step, network, places);
    found = linearise(poses, places, pairs, equations, threads);
    if (moved < config.last_step)
      break;
  }
  result.rms = rmsOf(found);
  if (patches)
    result.covariances = covariancesOf(poses, pairs, found, network, places, patches, config, threads);
  result.poses = std::move(poses);
  return result;
}

double
rmsOfPairs(const std::vector<Eigen::Isometry3d>& poses,
           const std::vector<std::pair<int, int>>& pairs,
           const std::vector<Eigen::Vector3d>& places,
           const EquationsFunction& equations,
           int threads)
{
  return rmsOf(linearise(poses, places, pairs, equations, threads));
}

} // namespace pcl_ssfr
