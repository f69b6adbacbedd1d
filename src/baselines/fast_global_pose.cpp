// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "fast_global_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::baselines {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kAnnealingFactor = 1.4;  ///< paper, section 3.2
constexpr int kStepsPerAnnealing = 4;     ///< paper, section 3.2
constexpr int kMinSteps = 64;             ///< as the authors' implementation
constexpr int kMaxStepsAtTheStart = 100;  ///< with mu at the squared diameter, unless the pose stands still before
constexpr double kStartStandstill = 1e-4; ///< step, in radians and in diameters
constexpr int kStepsAtTheEnd = 20;        ///< with mu at delta^2, unless the pose stands still before
constexpr double kStandstill = 1e-12;     ///< step, in radians and in diameters
constexpr double kLowerCost = 1e-9;       ///< relative; less is rounding
constexpr std::size_t kMinMatches = 3;

/// Matched points, centred and scaled so that the diameter is 1.
struct ScaledMatches {
  Points3 source;
  Points3 target;
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  double scale = 1; ///< metres per unit
};

double
boundingDiameter(const Points3& points)
{
  return 2 * std::sqrt((points.colwise() - points.rowwise().mean()).colwise().squaredNorm().maxCoeff());
}

ScaledMatches
scaleMatches(const Points3& source, const Points3& target, const std::vector<PointMatch>& matches, double diameter)
{
  ScaledMatches scaled;
  const auto count = static_cast<Eigen::Index>(matches.size());
  scaled.source.resize(3, count);
  scaled.target.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    scaled.source.col(i) = source.col(matches[static_cast<std::size_t>(i)].source);
    scaled.target.col(i) = target.col(matches[static_cast<std::size_t>(i)].target);
  }
  scaled.source_mean = scaled.source.rowwise().mean();
  scaled.target_mean = scaled.target.rowwise().mean();
  scaled.scale = diameter > 0 ? diameter : std::max(boundingDiameter(scaled.source), boundingDiameter(scaled.target));
  if (!(scaled.scale > 0))
    scaled.scale = 1;
  scaled.source = (scaled.source.colwise() - scaled.source_mean) / scaled.scale;
  scaled.target = (scaled.target.colwise() - scaled.target_mean) / scaled.scale;
  return scaled;
}

/// The pose between scaled points as one between the given ones.
Eigen::Isometry3d
unscaled(const Eigen::Isometry3d& T, const ScaledMatches& scaled)
{
  Eigen::Isometry3d result = T;
  result.translation() = scaled.scale * T.translation() + scaled.target_mean - T.linear() * scaled.source_mean;
  return result;
}

Eigen::Isometry3d
toScaled(const Eigen::Isometry3d& T, const ScaledMatches& scaled)
{
  Eigen::Isometry3d result = T;
  result.translation() = (T * scaled.source_mean - scaled.target_mean) / scaled.scale;
  return result;
}

/// Sum of mu r^2 / (mu + r^2).
double
robustCost(const ScaledMatches& scaled, const Eigen::Isometry3d& T, double mu)
{
  double cost = 0;
  for (Eigen::Index i = 0; i < scaled.source.cols(); ++i) {
    const double squared = (scaled.target.col(i) - T * scaled.source.col(i)).squaredNorm();
    cost += mu * squared / (mu + squared);
  }
  return cost;
}

/// One update of the line process (equation 6) and one Gauss-Newton step (equation 8); the length of the step.
double
improve(const ScaledMatches& scaled, double mu, Eigen::Isometry3d& T)
{
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  Eigen::Matrix<double, 3, 6> J; // of the residual: rotation, translation
  J.rightCols<3>() = -Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < scaled.source.cols(); ++i) {
    const Eigen::Vector3d x = T * scaled.source.col(i);
    const Eigen::Vector3d residual = scaled.target.col(i) - x;
    const double root = mu / (mu + residual.squaredNorm());
    const double line = root * root;
    J.leftCols<3>() << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0;
    A.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose(), line);
    b -= line * J.transpose() * residual;
  }
  // Matches on one line leave a rotation free: the least damping that keeps the system solvable.
  A.diagonal().array() += 1e-12 * std::max(A.diagonal().maxCoeff(), 1e-300);
  const Vector6 step = A.selfadjointView<Eigen::Lower>().ldlt().solve(b);
  if (!step.allFinite())
    return 0;
  const double angle = step.head<3>().norm();
  Eigen::Isometry3d increment = Eigen::Isometry3d::Identity();
  if (angle > 0)
    increment.linear() = Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix();
  increment.translation() = step.tail<3>();
  T = increment * T;
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return step.norm();
}

std::vector<PointMatch>
distinct(std::vector<PointMatch> matches)
{
  std::sort(matches.begin(), matches.end());
  matches.erase(std::unique(matches.begin(), matches.end()), matches.end());
  return matches;
}

void
countInliers(const Points3& source,
             const Points3& target,
             const std::vector<PointMatch>& matches,
             double threshold,
             FastGlobalPose& pose)
{
  const std::vector<PointMatch> unique = distinct(matches);
  pose.matches = unique.size();
  std::vector<Eigen::Vector3d> positions;
  for (const PointMatch& match : unique) {
    if ((target.col(match.target) - pose.T_target_source * source.col(match.source)).norm() <= threshold)
      positions.emplace_back(target.col(match.target));
  }
  pose.inliers = positions.size();
  if (positions.empty())
    return;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& position : positions)
    mean += position / static_cast<double>(positions.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& position : positions)
    covariance += (position - mean) * (position - mean).transpose() / static_cast<double>(positions.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  pose.inlier_spread = std::sqrt(std::max(solver.eigenvalues()[1], 0.0));
}

void
checkArguments(const Points3& source,
               const Points3& target,
               const std::vector<PointMatch>& matches,
               const FastGlobalPoseOptions& options)
{
  if (!(options.distance_threshold > 0))
    throw std::invalid_argument("distance_threshold = " + std::to_string(options.distance_threshold) +
                                ", must be > 0 [m]");
  for (const PointMatch& match : matches) {
    if (match.source < 0 || match.source >= source.cols() || match.target < 0 || match.target >= target.cols())
      throw std::invalid_argument("match " + std::to_string(match.source) + " - " + std::to_string(match.target) +
                                  " lies outside the points");
  }
}

} // namespace

std::vector<PointMatch>
tupleTest(const Points3& source,
          const Points3& target,
          const std::vector<PointMatch>& matches,
          const TupleTestOptions& options)
{
  std::vector<PointMatch> kept;
  if (matches.size() < kMinMatches)
    return kept;
  std::mt19937_64 engine(options.seed);
  const std::size_t trials = options.trials_per_match * matches.size();
  const auto draw = [&] { return matches[static_cast<std::size_t>(engine() % matches.size())]; };
  for (std::size_t trial = 0; trial < trials && kept.size() < 3 * options.max_tuples; ++trial) {
    const std::array<PointMatch, 3> tuple = {draw(), draw(), draw()};
    bool agrees = true;
    for (std::size_t k = 0; k < 3 && agrees; ++k) {
      const PointMatch& a = tuple[k];
      const PointMatch& b = tuple[(k + 1) % 3];
      const double source_side = (source.col(a.source) - source.col(b.source)).norm();
      const double target_side = (target.col(a.target) - target.col(b.target)).norm();
      // Strict, so that a triple that names a point twice never passes.
      agrees = options.similarity * target_side < source_side && options.similarity * source_side < target_side;
    }
    if (agrees)
      kept.insert(kept.end(), tuple.begin(), tuple.end());
  }
  return kept;
}

FastGlobalPose
optimizeFastGlobalPose(const Points3& source,
                       const Points3& target,
                       const std::vector<PointMatch>& matches,
                       const FastGlobalPoseOptions& options,
                       const Eigen::Isometry3d* guess)
{
  checkArguments(source, target, matches, options);
  FastGlobalPose result;
  result.matches = distinct(matches).size();
  if (matches.size() < kMinMatches)
    return result;

  const ScaledMatches scaled = scaleMatches(source, target, matches, options.diameter);
  const double delta = options.distance_threshold / scaled.scale;
  const double final_mu = delta * delta;
  double mu = std::max(1.0, final_mu);
  const int annealing_steps =
      kStepsPerAnnealing * static_cast<int>(std::ceil(std::log(mu / final_mu) / std::log(kAnnealingFactor)));
  const int steps = options.iterations > 0 ? options.iterations : std::max(kMinSteps, annealing_steps + kStepsAtTheEnd);

  // The paper's four steps do not always reach a large rotation: anneal only once the first, almost convex problem is
  // solved.
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (options.iterations == 0) {
    while (result.iterations < kMaxStepsAtTheStart && improve(scaled, mu, T) > kStartStandstill)
      ++result.iterations;
  }
  for (int i = 0; i < steps; ++i) {
    if (i > 0 && i % kStepsPerAnnealing == 0)
      mu = std::max(mu / kAnnealingFactor, final_mu);
    const double step = improve(scaled, mu, T);
    ++result.iterations;
    if (step < kStandstill && mu <= final_mu)
      break;
  }
  double cost = robustCost(scaled, T, final_mu);
  if (guess) {
    Eigen::Isometry3d T_guess = toScaled(*guess, scaled);
    for (int i = 0; i < kStepsAtTheEnd && !(improve(scaled, final_mu, T_guess) < kStandstill); ++i)
      ++result.iterations;
    const double guess_cost = robustCost(scaled, T_guess, final_mu);
    if (guess_cost < (1 - kLowerCost) * cost) {
      T = T_guess;
      cost = guess_cost;
      mu = final_mu;
    }
  }
  result.T_target_source = unscaled(T, scaled);
  result.mu = mu * scaled.scale * scaled.scale;
  result.cost = cost * scaled.scale * scaled.scale;
  countInliers(source, target, matches, options.distance_threshold, result);
  return result;
}

} // namespace pcl_ssfr::baselines
