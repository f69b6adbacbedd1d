// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>
#include <apps/map/map_inputs.h>

#include <Eigen/Geometry>

#include <map>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/** \brief Poses of scans by their names: T_map_scan.
 *
 * Either lines "scan tx ty tz qx qy qz qw" or "scan T00 T01 ... T33", or a CSV file with the columns scan and T00..T33
 * (of a poses.csv with several components, those of component 0), or an E57 file whose scans have poses; these are
 * named by their numbers and, where it is clear, by their names. \throw io::IoError naming file, line and value
 */
std::map<std::string, Eigen::Isometry3d>
readPoses(const std::string& path);

/// The entry of a scan by one of namesOfScan(); null when there is none.
template <typename Value>
const Value*
findByName(const std::map<std::string, Value>& values, const std::string& name)
{
  for (const std::string& key : namesOfScan(name)) {
    const auto found = values.find(key);
    if (found != values.end())
      return &found->second;
  }
  return nullptr;
}

/// The rigid motion that lays \p from onto \p to in the least squares sense: of three points or more that are not on a
/// line. \throw std::invalid_argument otherwise
Eigen::Isometry3d
fitPlaces(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);

} // namespace apps
} // namespace pcl_ssfr
