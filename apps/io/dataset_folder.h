// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace io {

/// One row of pairs.csv.
struct ScanPair {
  std::string source; ///< file name, next to pairs.csv or in scans/
  std::string target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< ground truth
};

/// A dataset folder: pairs.csv, and what dataset.json says about them.
struct DatasetFolder {
  std::string path;
  std::string name; ///< of dataset.json, else of the folder
  std::string sensor;
  std::string note;
  bool sensor_at_origin = true;       ///< "viewpoint" is not "unknown"
  double success_rotation_deg = 2;    ///< a pose is right within this [deg] ...
  double success_translation_m = 0.3; ///< ... and this [m]
  std::vector<ScanPair> pairs;
};

/** \brief Read and check a dataset folder; every scan that a pair names must exist in a format that loadCloud reads.
 * \throw IoError naming file, line and column
 */
DatasetFolder
readDatasetFolder(const std::string& path);

/// The path of a scan of a dataset: next to pairs.csv, else in scans/.
std::string
scanPath(const std::string& folder, const std::string& scan);

} // namespace io
} // namespace pcl_ssfr
