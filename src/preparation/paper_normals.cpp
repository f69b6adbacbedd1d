// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/paper_normals.h"

#include "common/parallel.h"
#include "preparation/voxel_sampling.h"

#include <Eigen/Eigenvalues>

#include <pcl/common/centroid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace pcl_ssfr {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// A given normal is accepted when its norm is this near to 1.
constexpr double kUnitTolerance = 0.01;
/// Neighbours lie on a line when their second spread is below this share of the first (variances).
constexpr float kLineRatio = 1e-4F;
/// Fewest points that span a plane.
constexpr std::size_t kMinNeighbors = 3;
/// The resolution is measured on at most so many points, evenly strided.
constexpr std::size_t kResolutionSamples = 5000;

// Scales from the data (METHOD: settings the authors ran): at room scale they took r = 0.1 m and leaf 0.04-0.06 m, on
// a vehicle r = 0.6 m and leaf 0.05-0.1 m.
constexpr double kRadiusInResolutions = 10;
constexpr double kSmallestRadius = 0.1, kLargestRadius = 0.9; ///< [m]
constexpr double kLeafInRadii = 0.5;
// A spinning sensor with few rings measures densely along a ring and sparsely across: the nearest neighbours lie on one
// line and do not determine the surface. r must reach the next ring around nine points in ten of those that are used.
constexpr double kSurfaceShare = 0.9;
constexpr float kSurfaceRatio = 0.1F; ///< second spread over the first (variances) of neighbours on a surface
constexpr std::size_t kMinSurfaceNeighbors = 5;
constexpr std::size_t kSurfaceSamples = 1000;              ///< at most so many points, evenly strided
constexpr double kSurfaceStep = 1.25;                      ///< ratio of the radii that are tried
constexpr double kSmallestLeaf = 0.04, kLargestLeaf = 0.1; ///< [m]

/// The returns of a scan near enough to the viewpoint, centred; and the normals that came with them.
struct Returns {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Points3 points;
  Points3 given_normals; ///< unit or zero; no columns when the scan has none
  std::size_t count = 0; ///< of any range
};

Returns
collectReturns(const ScanView& scan, const NormalOptions& options)
{
  Returns result;
  std::vector<std::size_t> kept;
  kept.reserve(scan.count());
  for (std::size_t i = 0; i < scan.count(); ++i) {
    if (!scan.isReturn(i))
      continue;
    const Eigen::Vector3d point = scan.point(i).cast<double>();
    ++result.count;
    if (options.max_range > 0 && (point - scan.viewpoint).norm() > options.max_range)
      continue;
    kept.push_back(i);
    result.origin += point;
  }
  if (kept.empty())
    return result;
  result.origin /= static_cast<double>(kept.size());
  const auto size = static_cast<Eigen::Index>(kept.size());
  result.points.resize(3, size);
  for (Eigen::Index i = 0; i < size; ++i)
    result.points.col(i) = scan.point(kept[static_cast<std::size_t>(i)]).cast<double>() - result.origin;
  if (!scan.normals || !options.use_given_normals)
    return result;
  result.given_normals = Points3::Zero(3, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Vector3d normal = scan.normal(kept[static_cast<std::size_t>(i)]).cast<double>();
    if (std::abs(normal.norm() - 1) <= kUnitTolerance) // false for NaN
      result.given_normals.col(i) = normal.normalized();
  }
  return result;
}

void
keepColumns(Points3& points, const std::vector<Eigen::Index>& columns)
{
  if (points.cols() == 0)
    return;
  for (std::size_t i = 0; i < columns.size(); ++i) // ascending columns: never overwrites what is still needed
    points.col(static_cast<Eigen::Index>(i)) = points.col(columns[i]).eval();
  points.conservativeResize(3, static_cast<Eigen::Index>(columns.size()));
}

Cloud::Ptr
toCloud(const Points3& points)
{
  auto cloud = pcl::make_shared<Cloud>();
  cloud->resize(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    (*cloud)[static_cast<std::size_t>(i)].getVector3fMap() = points.col(i).cast<float>();
  return cloud;
}

/// Mean distance to the nearest neighbour [m]; 0 for fewer than two points.
double
measureResolution(const Cloud& cloud, const pcl::search::KdTree<pcl::PointXYZ>& tree, int threads)
{
  if (cloud.size() < 2)
    return 0;
  const std::size_t samples = std::min(cloud.size(), kResolutionSamples);
  std::vector<double> distances(samples, 0);
  forEachInParallel(static_cast<std::int64_t>(samples), 64, threads, [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    pcl::Indices indices;
    std::vector<float> squared;
    if (tree.nearestKSearch(cloud[i * cloud.size() / samples], 2, indices, squared) == 2)
      distances[i] = std::sqrt(static_cast<double>(squared[1]));
  });
  double sum = 0;
  for (const double distance : distances)
    sum += distance;
  return sum / static_cast<double>(samples);
}

/// Covariance of some points; false for none.
bool
computeCovariance(const Cloud& cloud, const pcl::Indices& indices, Eigen::Matrix3f& covariance)
{
  Eigen::Vector4f centroid;
  return pcl::computeMeanAndCovarianceMatrix(cloud, indices, covariance, centroid) > 0;
}

/** \brief The radius [m] within which kSurfaceShare of the points have neighbours that span a surface, and not a line.
 * Measured on \p columns of the cloud, one per voxel of the thinning, so that near and far surfaces count by their
 * area. At least 2 resolutions, at most kLargestRadius.
 */
double
measureSurfaceRadius(const Cloud& cloud,
                     const pcl::search::KdTree<pcl::PointXYZ>& tree,
                     const std::vector<Eigen::Index>& columns,
                     double resolution,
                     const Deadline& deadline,
                     int threads)
{
  const std::size_t samples = std::min(columns.size(), kSurfaceSamples);
  if (samples == 0 || !(resolution > 0))
    return 0;
  std::vector<double> radii(samples, kLargestRadius);
  forEachInParallel(static_cast<std::int64_t>(samples), 16, threads, [&](std::int64_t k) {
    if (deadline.hasPassed())
      return;
    const auto i = static_cast<std::size_t>(k);
    const pcl::PointXYZ& point = cloud[static_cast<std::size_t>(columns[i * columns.size() / samples])];
    pcl::Indices indices;
    std::vector<float> squared;
    Eigen::Matrix3f covariance;
    for (double radius = 2 * resolution; radius < kLargestRadius; radius *= kSurfaceStep) {
      tree.radiusSearch(point, radius, indices, squared);
      if (indices.size() < kMinSurfaceNeighbors || !computeCovariance(cloud, indices, covariance))
        continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(covariance, Eigen::EigenvaluesOnly);
      if (solver.eigenvalues()[1] > kSurfaceRatio * solver.eigenvalues()[2]) {
        radii[i] = radius;
        break;
      }
    }
  });
  const auto rank = std::min(samples - 1, static_cast<std::size_t>(kSurfaceShare * static_cast<double>(samples)));
  const auto chosen = radii.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(radii.begin(), chosen, radii.end());
  return *chosen;
}

/// PCA normal of some points, as pcl::NormalEstimation computes it; zero when they span no plane.
Eigen::Vector3d
fitNormal(const Cloud& cloud, const pcl::Indices& indices)
{
  if (indices.size() < kMinNeighbors)
    return Eigen::Vector3d::Zero();
  Eigen::Matrix3f covariance;
  if (!computeCovariance(cloud, indices, covariance))
    return Eigen::Vector3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(covariance);
  if (!(solver.eigenvalues()[1] > kLineRatio * solver.eigenvalues()[2]))
    return Eigen::Vector3d::Zero();
  return solver.eigenvectors().col(0).cast<double>().normalized();
}

} // namespace

NormalEstimationResult
estimateNormals(
    const ScanView& scan, const NormalOptions& options, bool oriented, unsigned threads, const Deadline& deadline)
{
  const int workers = static_cast<int>(threads);
  NormalEstimationResult result;
  result.samples.oriented = oriented;

  Returns returns = collectReturns(scan, options);
  result.origin = returns.origin;
  result.returns = returns.count;
  const std::vector<Eigen::Index> sampled = samplePerVoxel(returns.points, options.pre_leaf);
  keepColumns(returns.points, sampled);
  keepColumns(returns.given_normals, sampled);
  if (returns.points.cols() == 0 || deadline.hasPassed()) {
    result.radius = options.radius;
    return result;
  }

  const Cloud::Ptr surface = toCloud(returns.points);
  pcl::search::KdTree<pcl::PointXYZ> tree(false);
  tree.setInputCloud(surface);
  result.resolution = measureResolution(*surface, tree, workers);
  result.radius = options.radius;
  if (!(result.radius > 0)) {
    const double spacing = measureSurfaceRadius(
        *surface, tree, samplePerVoxel(returns.points, kLargestLeaf), result.resolution, deadline, workers);
    result.radius =
        std::clamp(std::max(kRadiusInResolutions * result.resolution, spacing), kSmallestRadius, kLargestRadius);
  }
  const double leaf =
      options.leaf > 0 ? options.leaf : std::clamp(kLeafInRadii * result.radius, kSmallestLeaf, kLargestLeaf);

  // Thinning after the normals keeps real points: estimating at those alone, over all points, gives the same.
  const std::vector<Eigen::Index> kept = samplePerVoxel(returns.points, leaf);
  const Eigen::Vector3d viewpoint = scan.viewpoint - result.origin;
  Points3 normals = Points3::Zero(3, static_cast<Eigen::Index>(kept.size()));
  forEachInParallel(normals.cols(), 64, workers, [&](Eigen::Index i) {
    if (deadline.hasPassed())
      return;
    const Eigen::Index column = kept[static_cast<std::size_t>(i)];
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    if (returns.given_normals.cols() > 0)
      normal = returns.given_normals.col(column);
    if (normal.isZero(0)) {
      pcl::Indices indices;
      std::vector<float> squared;
      tree.radiusSearch((*surface)[static_cast<std::size_t>(column)], result.radius, indices, squared);
      normal = fitNormal(*surface, indices);
    }
    const double towards = normal.dot(viewpoint - returns.points.col(column));
    if (oriented && (options.away_from_viewpoint ? towards > 0 : towards < 0))
      normal = -normal;
    normals.col(i) = normal;
  });

  OrientedSamples& samples = result.samples;
  samples.points.resize(3, normals.cols());
  samples.normals.resize(3, normals.cols());
  Eigen::Index size = 0;
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    if (normals.col(i).isZero(0) || !normals.col(i).allFinite())
      continue;
    samples.points.col(size) = returns.points.col(kept[static_cast<std::size_t>(i)]);
    samples.normals.col(size) = normals.col(i);
    ++size;
  }
  samples.points.conservativeResize(3, size);
  samples.normals.conservativeResize(3, size);
  samples.weights = Eigen::VectorXd::Ones(size);
  samples.extents = Eigen::VectorXd::Zero(size);
  return result;
}

} // namespace pcl_ssfr
