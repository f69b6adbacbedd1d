// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "synthetic_scene.h"

#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <type_traits>

// Clouds of PCL's types for tests, from synthetic scans.
namespace pcl_ssfr::testing {

/// A cloud of the scan's points; normals, intensity (number of the point) and colour are filled in where they exist.
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
toCloud(const ScanWithNormals& scan)
{
  auto cloud = pcl::make_shared<pcl::PointCloud<PointT>>();
  const Eigen::Index count = scan.points.cols();
  for (Eigen::Index i = 0; i < count; ++i) {
    PointT point;
    point.getVector3fMap() = scan.points.col(i);
    if constexpr (pcl::traits::has_normal_v<PointT>) {
      point.getNormalVector3fMap() = scan.normals.col(i);
    }
    if constexpr (pcl::traits::has_intensity_v<PointT>) {
      point.intensity = static_cast<float>(i);
    }
    if constexpr (std::is_same_v<PointT, pcl::PointXYZRGB>) {
      point.r = static_cast<std::uint8_t>(i % 256);
      point.g = static_cast<std::uint8_t>(i / 256 % 256);
      point.b = 7;
    }
    cloud->push_back(point);
  }
  return cloud;
}

/// A pair of scans and the pose that maps the source into the target's frame.
template <typename PointT>
struct ScanPair {
  typename pcl::PointCloud<PointT>::Ptr source;
  typename pcl::PointCloud<PointT>::Ptr target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

/// Two scans of one furnished apartment. A small motion is one that ICP follows; the other is 100 degrees and 2 m.
/// \p step between two rays [rad]: at 1.5 degrees each has about 23,000 points
template <typename PointT>
ScanPair<PointT>
makeRoomPair(bool small_motion, double step = 0.0262)
{
  const Scene scene = makeFurnishedRoom(1);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source =
      small_motion ? sensorPose(scene.stations.at(0) + Eigen::Vector3d(0.1, -0.06, 0.02), 0.14, 0.02)
                   : sensorPose(scene.stations.at(1), 1.85, 0.2);
  ScanPair<PointT> pair;
  pair.target = toCloud<PointT>(castScanWithNormals(scene, T_world_target, roomScanner(step), 11));
  pair.source = toCloud<PointT>(castScanWithNormals(scene, T_world_source, roomScanner(step), 12));
  pair.T_target_source = relativePose(T_world_target, T_world_source);
  return pair;
}

} // namespace pcl_ssfr::testing
