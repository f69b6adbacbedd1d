// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/neighbor_index.h"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pcl_ssfr {

namespace {

pcl::PointXYZ
toPcl(const Eigen::Vector3d& point)
{
  return {static_cast<float>(point.x()), static_cast<float>(point.y()), static_cast<float>(point.z())};
}

} // namespace

struct NeighborIndex::Impl {
  Points3 points;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;

  /// The neighbours that the tree named, with their distances in double, in ascending distance.
  std::vector<Neighbor>
  sorted(const Eigen::Vector3d& query, const pcl::Indices& indices) const
  {
    std::vector<Neighbor> neighbors;
    neighbors.reserve(indices.size());
    for (const auto index : indices)
      neighbors.push_back({index, (points.col(index) - query).squaredNorm()});
    std::sort(neighbors.begin(), neighbors.end(), [](const Neighbor& a, const Neighbor& b) {
      return std::make_pair(a.squared_distance, a.index) < std::make_pair(b.squared_distance, b.index);
    });
    return neighbors;
  }
};

NeighborIndex::NeighborIndex(const Points3& points)
{
  if (!points.allFinite())
    throw std::invalid_argument("NeighborIndex: points must be finite");
  if (points.cols() == 0)
    return;
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cloud->push_back(toPcl(points.col(i)));
  auto impl = std::make_shared<Impl>();
  impl->points = points;
  impl->tree.setInputCloud(cloud);
  impl_ = std::move(impl);
}

Eigen::Index
NeighborIndex::size() const
{
  return impl_ ? impl_->points.cols() : 0;
}

NeighborIndex::Neighbor
NeighborIndex::nearest(const Eigen::Vector3d& query, double max_distance) const
{
  Neighbor none;
  if (!impl_ || !query.allFinite())
    return none;
  pcl::Indices indices(1);
  std::vector<float> squared_distances(1);
  if (impl_->tree.nearestKSearch(toPcl(query), 1, indices, squared_distances) < 1)
    return none;
  const double squared = (impl_->points.col(indices[0]) - query).squaredNorm();
  return squared < max_distance * max_distance ? Neighbor{indices[0], squared} : none;
}

std::vector<NeighborIndex::Neighbor>
NeighborIndex::kNearest(const Eigen::Vector3d& query, int k) const
{
  if (!impl_ || k <= 0 || !query.allFinite())
    return {};
  const auto count = static_cast<unsigned>(std::min<Eigen::Index>(k, size()));
  pcl::Indices indices;
  std::vector<float> squared_distances;
  impl_->tree.nearestKSearch(toPcl(query), static_cast<int>(count), indices, squared_distances);
  return impl_->sorted(query, indices);
}

} // namespace pcl_ssfr
