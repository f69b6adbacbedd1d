// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/planar_points.h>

#include "common/parallel.h"

#include <pcl_ssfr/patch_config.h>

#include <pcl/search/kdtree.h>

#include <Eigen/Eigenvalues>

#include <cstdint>
#include <vector>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kMinWidth = 1e-3;  ///< of a plane over its length: rounding alone gives a line some width
constexpr std::int64_t kBlock = 64; ///< points that a thread takes at a time

} // namespace

MethodCloud::Ptr
planarPoints(const MethodCloud& cloud, const Eigen::Vector3d& sensor, double radius, double thickness, unsigned threads)
{
  if (cloud.empty())
    return pcl::make_shared<MethodCloud>();
  const PatchConfig patch; // what is a plane there is one here
  pcl::search::KdTree<MethodPoint> tree;
  tree.setInputCloud(cloud.makeShared());
  MethodCloud points = cloud;
  std::vector<std::uint8_t> is_planar(cloud.size(), 0);
  forEachInParallel(static_cast<std::int64_t>(cloud.size()), kBlock, static_cast<int>(threads), [&](std::int64_t i) {
    MethodPoint& point = points[static_cast<std::size_t>(i)];
    pcl::Indices near;
    std::vector<float> squares;
    tree.radiusSearch(point, radius, near, squares);
    if (near.size() < static_cast<std::size_t>(patch.min_points))
      return;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    const Eigen::Vector3d p = point.getVector3fMap().cast<double>();
    for (const pcl::index_t k : near) {
      const Eigen::Vector3d d = cloud[static_cast<std::size_t>(k)].getVector3fMap().cast<double>() - p;
      mean += d;
      sum += d * d.transpose();
    }
    const auto n = static_cast<double>(near.size());
    mean /= n;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum / n - mean * mean.transpose());
    const Eigen::Vector3d variances = solver.eigenvalues().cwiseMax(0);
    if (variances[0] > thickness * thickness || variances[0] > patch.max_flatness * patch.max_flatness * variances[1] ||
        variances[1] <= kMinWidth * kMinWidth * variances[2])
      return;
    const Eigen::Vector3d normal = solver.eigenvectors().col(0);
    point.getNormalVector3fMap() = (normal.dot(sensor - p) < 0 ? -normal : normal).cast<float>();
    is_planar[static_cast<std::size_t>(i)] = 1;
  });
  auto result = pcl::make_shared<MethodCloud>();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (is_planar[i])
      result->push_back(points[i]);
  return result;
}

} // namespace apps
} // namespace pcl_ssfr
