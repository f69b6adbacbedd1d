// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/density_filter.h"

#include "common/parallel.h"
#include "common/vector_clones.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

namespace pcl_ssfr {

namespace {

constexpr std::size_t kLeafSize = kBatchSize;
static_assert(kLeafSize % kSumGroup == 0);

/** \brief exp(-t) for t in [0, 4], within 1e-12 of its value: without a call and without a branch, for loops that
 * become vectors. The series of the sixteenth part, to the sixteenth power.
 */
[[gnu::always_inline]] inline double
expOfMinus(double t)
{
  const double u = -t / 16; // [-0.25, 0]
  double series = 1 + u * (1.0 / 10);
  series = 1 + u * (1.0 / 9) * series;
  series = 1 + u / 8 * series;
  series = 1 + u * (1.0 / 7) * series;
  series = 1 + u * (1.0 / 6) * series;
  series = 1 + u * (1.0 / 5) * series;
  series = 1 + u / 4 * series;
  series = 1 + u * (1.0 / 3) * series;
  series = 1 + u / 2 * series;
  series = 1 + u * series;
  series *= series;
  series *= series;
  series *= series;
  return series * series;
}

/// Sum of weight * exp(-4 d^2 / r^2) over \p n points within the radius, at most kLeafSize.
PCL_SSFR_VECTOR_CLONES double
sumGaussians(const double* x,
             const double* y,
             const double* z,
             const double* weights,
             std::size_t n,
             const Eigen::Vector3d& query,
             double squared_radius)
{
  std::array<double, kLeafSize> terms{};
  const double qx = query.x(), qy = query.y(), qz = query.z();
  const double factor = 4 / squared_radius;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = x[i] - qx, dy = y[i] - qy, dz = z[i] - qz;
    const double squared = dx * dx + dy * dy + dz * dz;
    const double weight = squared <= squared_radius ? weights[i] : 0;
    terms[i] = weight * expOfMinus(std::min(squared, squared_radius) * factor);
  }
  GroupSums sums{};
  for (std::size_t i = 0; i < kLeafSize; i += kSumGroup)
    for (std::size_t k = 0; k < kSumGroup; ++k)
      sums[k] += terms[i + k];
  return total(sums);
}

/** \brief Tree of tight boxes over weighted points: exact weight sums in spheres without visiting the points of boxes
 * that lie wholly inside, so that a sum costs the boundary of the sphere and not its content.
 */
class WeightTree {
public:
  explicit WeightTree(const DirectionSet& set) : order_(static_cast<std::size_t>(set.size()))
  {
    std::iota(order_.begin(), order_.end(), Eigen::Index(0));
    if (!order_.empty())
      build(set, 0, set.size());
    points_.resize(set.size(), 3);
    weights_.resize(set.size());
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      points_.row(i) = set.directions.col(order_[static_cast<std::size_t>(i)]).transpose();
      weights_[i] = set.weights[order_[static_cast<std::size_t>(i)]];
    }
  }

  /// Column of the original set at place \p i of the tree's order; neighbours in it are neighbours in space.
  Eigen::Index
  column(Eigen::Index i) const
  {
    return order_[static_cast<std::size_t>(i)];
  }
  Eigen::Vector3d
  point(Eigen::Index i) const
  {
    return points_.row(i).transpose();
  }

  /// Weight of the points within \p radius of \p query.
  double
  weightWithin(const Eigen::Vector3d& query, double radius) const
  {
    return nodes_.empty() ? 0 : weightWithin(0, query, radius * radius);
  }

  /// Weight of the points within \p radius of \p query, each times exp(-d^2 / (radius/2)^2).
  double
  gaussianWithin(const Eigen::Vector3d& query, double radius) const
  {
    return nodes_.empty() ? 0 : gaussianWithin(0, query, radius * radius);
  }

private:
  struct Node {
    Eigen::Vector3d lower, upper;
    double weight = 0;
    Eigen::Index begin = 0, end = 0;
    std::size_t right = 0; ///< the left child follows its parent; 0: leaf
  };

  std::size_t
  build(const DirectionSet& set, Eigen::Index begin, Eigen::Index end)
  {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Node node;
    node.begin = begin;
    node.end = end;
    node.lower = node.upper = set.directions.col(column(begin));
    for (Eigen::Index i = begin; i < end; ++i) {
      node.lower = node.lower.cwiseMin(set.directions.col(column(i)));
      node.upper = node.upper.cwiseMax(set.directions.col(column(i)));
      node.weight += set.weights[column(i)];
    }
    Eigen::Index axis = 0;
    const double width = (node.upper - node.lower).maxCoeff(&axis);
    if (end - begin > static_cast<Eigen::Index>(kLeafSize) && width > 0) {
      const Eigen::Index middle = begin + (end - begin) / 2;
      std::nth_element(
          order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](Eigen::Index a, Eigen::Index b) {
            const double left = set.directions(axis, a), right = set.directions(axis, b);
            return left < right || (left == right && a < b);
          });
      build(set, begin, middle);
      node.right = build(set, middle, end);
    }
    nodes_[self] = node;
    return self;
  }

  static double
  nearestSquared(const Node& node, const Eigen::Vector3d& query)
  {
    return (node.lower - query).cwiseMax(query - node.upper).cwiseMax(0).squaredNorm();
  }
  static double
  farthestSquared(const Node& node, const Eigen::Vector3d& query)
  {
    return (query - node.lower).cwiseMax(node.upper - query).squaredNorm();
  }

  double
  weightWithin(std::size_t index, const Eigen::Vector3d& query, double squared_radius) const
  {
    const Node& node = nodes_[index];
    if (nearestSquared(node, query) > squared_radius * (1 + kRoundingOfSums))
      return 0;
    if (farthestSquared(node, query) <= squared_radius * (1 - kRoundingOfSums))
      return node.weight;
    if (node.right != 0)
      return weightWithin(index + 1, query, squared_radius) + weightWithin(node.right, query, squared_radius);
    double sum = 0;
    for (Eigen::Index i = node.begin; i < node.end; ++i)
      if ((point(i) - query).squaredNorm() <= squared_radius)
        sum += weights_[i];
    return sum;
  }

  double
  gaussianWithin(std::size_t index, const Eigen::Vector3d& query, double squared_radius) const
  {
    const Node& node = nodes_[index];
    if (nearestSquared(node, query) > squared_radius * (1 + kRoundingOfSums))
      return 0;
    if (node.right != 0)
      return gaussianWithin(index + 1, query, squared_radius) + gaussianWithin(node.right, query, squared_radius);
    double sum = 0; // points that coincide share a leaf however many they are
    for (Eigen::Index i = node.begin; i < node.end; i += static_cast<Eigen::Index>(kLeafSize))
      sum += sumGaussians(points_.col(0).data() + i,
                          points_.col(1).data() + i,
                          points_.col(2).data() + i,
                          weights_.data() + i,
                          std::min(kLeafSize, static_cast<std::size_t>(node.end - i)),
                          query,
                          squared_radius);
    return sum;
  }

  std::vector<Eigen::Index> order_;
  std::vector<Node> nodes_;
  Eigen::MatrixX3d points_; ///< N x 3: the coordinates of neighbours lie side by side
  Eigen::VectorXd weights_;
};

/** \brief Whether a curved surface left its trace around a peak: an elongated, wide distribution (METHOD stage 4).
 *
 * Judged on the directions within the silence chord: the neighbours within r_d alone could never be wide.
 */
bool
isElongated(const DirectionSet& set, Eigen::Index peak, const DensityOptions& options)
{
  const Eigen::Vector3d centre = set.directions.col(peak);
  const double squared_chord = options.silence_chord * options.silence_chord;
  double weight = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const Eigen::Vector3d offset = set.directions.col(i) - centre;
    if (offset.squaredNorm() > squared_chord)
      continue;
    weight += set.weights[i];
    mean += set.weights[i] * offset;
    moments += set.weights[i] * offset * offset.transpose();
  }
  mean /= weight; // the peak itself counts: never zero
  const Eigen::Matrix3d covariance = moments / weight - mean * mean.transpose();
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues().cwiseMax(0);
  return eigenvalues[2] > options.max_elongation * eigenvalues[1] &&
         2 * std::sqrt(eigenvalues[2]) > options.max_elongated_chord;
}

/// The neighbours of \p peak within r_d, evenly thinned to max_region_points.
DenseRegion
collectRegion(const DirectionSet& set, Eigen::Index peak, const DensityOptions& options)
{
  DenseRegion region;
  region.peak = set.directions.col(peak);
  const double squared_radius = options.radius * options.radius;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if ((set.directions.col(i) - region.peak).squaredNorm() > squared_radius)
      continue;
    region.members.push_back(i);
    region.weight += set.weights[i];
  }
  const std::size_t limit = static_cast<std::size_t>(std::max(options.max_region_points, 1));
  const std::size_t total = region.members.size();
  if (total > limit) {
    for (std::size_t i = 0; i < limit; ++i)
      region.members[i] = region.members[i * total / limit];
    region.members.resize(limit);
  }
  return region;
}

/// Every how many-th of \p n directions is asked for its density: odd, and 1 where there are few.
Eigen::Index
queryStride(Eigen::Index n, int max_queries)
{
  if (max_queries <= 0 || n <= max_queries)
    return 1;
  const Eigen::Index stride = (n + max_queries - 1) / max_queries;
  return stride % 2 == 1 ? stride : stride + 1;
}

} // namespace

Eigen::VectorXd
computeDensity(const DirectionSet& directions,
               const DensityOptions& options,
               unsigned threads,
               const Deadline& deadline)
{
  const WeightTree tree(directions);
  Eigen::VectorXd density = Eigen::VectorXd::Zero(directions.size());
  const Eigen::Index stride = queryStride(directions.size(), options.max_queries);
  std::atomic<bool> is_late{false};
  forEachInParallel(directions.size(), 256, static_cast<int>(threads), [&](Eigen::Index i) {
    if (deadline.hasPassed())
      is_late = true;
    const Eigen::Index column = tree.column(i);
    if (is_late || column % stride != 0)
      return;
    const Eigen::Vector3d query = tree.point(i);
    density[column] = options.kernel == DensityOptions::Kernel::Count ? tree.weightWithin(query, options.radius)
                                                                      : tree.gaussianWithin(query, options.radius);
  });
  return density;
}

std::vector<DenseRegion>
findDensestRegions(const DirectionSet& directions, const Eigen::VectorXd& density, const DensityOptions& options)
{
  std::vector<DenseRegion> regions;
  std::vector<bool> silenced(static_cast<std::size_t>(directions.size()), false);
  const double squared_chord = options.silence_chord * options.silence_chord;
  double highest = 0;
  for (int round = 0; round < options.max_regions; ++round) {
    Eigen::Index peak = -1;
    for (Eigen::Index i = 0; i < directions.size(); ++i)
      if (!silenced[static_cast<std::size_t>(i)] && (peak < 0 || density[i] > density[peak]))
        peak = i;
    if (peak < 0 || !(density[peak] > 0) || density[peak] < options.min_relative_density * highest)
      break;
    highest = std::max(highest, density[peak]);
    if (!options.reject_elongated || !isElongated(directions, peak, options))
      regions.push_back(collectRegion(directions, peak, options));
    for (Eigen::Index i = 0; i < directions.size(); ++i)
      if ((directions.directions.col(i) - directions.directions.col(peak)).squaredNorm() <= squared_chord)
        silenced[static_cast<std::size_t>(i)] = true;
  }
  return regions;
}

} // namespace pcl_ssfr
