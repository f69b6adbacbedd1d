// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <Eigen/Geometry>

#include <map>
#include <optional>
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

/** \brief The pose of each scan of a list; none: the list has none.
 *
 * Each scan is looked up by namesOfScan(), best first. A name that two scans answer to is nobody's.
 * \param[in] names of the scans, each another one
 * \throw io::IoError when a scan has no other entry than one of a name that two answer to, but for what is behind "#"
 * of scans in E57 files; naming \p file, the name and both
 */
std::vector<std::optional<Eigen::Isometry3d>>
posesOfScans(const std::map<std::string, Eigen::Isometry3d>& poses,
             const std::vector<std::string>& names,
             const std::string& file);

/// The rigid motion that lays \p from onto \p to in the least squares sense: of three points or more that are not on a
/// line. \throw std::invalid_argument otherwise
Eigen::Isometry3d
fitPlaces(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);

} // namespace apps
} // namespace pcl_ssfr
