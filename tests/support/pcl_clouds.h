// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "synthetic_scene.h"

#include <pcl/io/pcd_io.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

// Clouds of PCL's types for tests: from synthetic scans and from dataset folders.
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
template <typename PointT>
ScanPair<PointT>
makeRoomPair(bool small_motion)
{
  constexpr double kStep = 0.0262; // 1.5 degrees: about 23,000 points
  const Scene scene = makeFurnishedRoom(1);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source =
      small_motion ? sensorPose(scene.stations.at(0) + Eigen::Vector3d(0.1, -0.06, 0.02), 0.14, 0.02)
                   : sensorPose(scene.stations.at(1), 1.85, 0.2);
  ScanPair<PointT> pair;
  pair.target = toCloud<PointT>(castScanWithNormals(scene, T_world_target, roomScanner(kStep), 11));
  pair.source = toCloud<PointT>(castScanWithNormals(scene, T_world_source, roomScanner(kStep), 12));
  pair.T_target_source = relativePose(T_world_target, T_world_source);
  return pair;
}

/// A row of a dataset's pairs.csv: names without folder, and the ground truth.
struct DatasetPair {
  std::string source;
  std::string target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

/// All rows of \p folder/pairs.csv; empty when there is no such file.
inline std::vector<DatasetPair>
readPairs(const std::string& folder)
{
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) {
      cells.push_back(cell);
    }
    return cells;
  };
  std::vector<DatasetPair> pairs;
  std::ifstream file(folder + "/pairs.csv");
  std::string line;
  if (!std::getline(file, line)) {
    return pairs;
  }
  std::map<std::string, std::size_t> column;
  for (const std::string& name : split(line)) {
    column.emplace(name, column.size());
  }
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = split(line);
    DatasetPair pair;
    pair.source = cells.at(column.at("source"));
    pair.target = cells.at(column.at("target"));
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 4; ++col) {
        const std::string name = "T" + std::to_string(row) + std::to_string(col);
        pair.T_target_source.matrix()(row, col) = std::stod(cells.at(column.at(name)));
      }
    }
    pairs.push_back(pair);
  }
  return pairs;
}

/// The clouds of one row of \p folder/pairs.csv; null clouds when it is not there.
inline ScanPair<pcl::PointXYZ>
loadPair(const std::string& folder, const std::string& source, const std::string& target)
{
  ScanPair<pcl::PointXYZ> pair;
  for (const DatasetPair& row : readPairs(folder)) {
    if (row.source != source || row.target != target) {
      continue;
    }
    auto source_cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    auto target_cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    if (pcl::io::loadPCDFile(std::string(folder).append("/").append(source), *source_cloud) == 0 &&
        pcl::io::loadPCDFile(std::string(folder).append("/").append(target), *target_cloud) == 0) {
      pair.source = source_cloud;
      pair.target = target_cloud;
      pair.T_target_source = row.T_target_source;
    }
    return pair;
  }
  return pair;
}

} // namespace pcl_ssfr::testing
