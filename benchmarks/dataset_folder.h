// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <string>
#include <vector>

namespace pcl_ssfr::benchmarks {

/// One row of pairs.csv.
struct ScanPair {
  std::string source; ///< file name, beside pairs.csv or in scans/
  std::string target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< ground truth
};

/** \brief The pairs of a dataset folder (pairs.csv with columns source, target, T00 ... T33; others are skipped).
 * \throw std::runtime_error naming file and line
 */
std::vector<ScanPair>
readPairs(const std::filesystem::path& folder);

/// The finite points of a scan of the folder. \throw std::runtime_error naming the file
pcl::PointCloud<pcl::PointXYZ>::Ptr
loadScan(const std::filesystem::path& folder, const std::string& name);

} // namespace pcl_ssfr::benchmarks
