// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_map.h>

#include <apps/map/map_inputs.h>

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// Files with the points of the scans of the largest component; empty: not wanted.
struct CloudOutputs {
  std::string merged;        ///< .pcd or .ply: all of them as one cloud, coloured by scan
  double merged_leaf = 0.02; ///< [m]; 0: every point
  std::string e57;           ///< every scan with all that it has, and its pose
  std::string pcd;           ///< folder: a copy of each scan in the map, its sensor's pose as VIEWPOINT

  bool
  any() const
  {
    return !merged.empty() || !e57.empty() || !pcd.empty();
  }
};

/// The files that are written of these scans, each with the option that asks for it.
std::vector<std::pair<const char*, std::string>>
outputFiles(const CloudOutputs& outputs, const std::vector<MapInputFile>& files);

/** \brief Look at what can be seen before the scans are placed, and make the folder.
 * \throw io::IoError where a file cannot be written, or a copy would replace a file that is no copy of an earlier run
 */
void
checkOutputs(const CloudOutputs& outputs, const std::vector<MapInputFile>& files);

/// Whether a scan is written: those of the largest component are.
bool
isWritten(const MapScan& scan);

/** \brief Write them. Each scan is read once more, one at a time: memory does not grow with their number.
 * \param[in] map with poses in the coordinates of the files
 * \param[in] places of the sensors in these [m]
 * \param[in] found sensors that were found in the points, which go before what the files say; nothing: none was found
 * \param[in] progress scans that are done, and all
 * \throw io::IoError
 */
void
writeClouds(const CloudOutputs& outputs,
            const std::vector<MapInputFile>& files,
            const MultiwayMap& map,
            const std::vector<Eigen::Vector3d>& places,
            const std::vector<std::optional<Eigen::Vector3d>>& found,
            const std::function<void(std::size_t done, std::size_t total)>& progress);

/// Names of scans in an E57 file of a map: without extensions and without the file of those that came from one,
/// where these differ from each other.
std::vector<std::string>
shortNames(const std::vector<MapInputFile>& files);

/// Names of PCD copies: as shortNames(), fit for any file system, each another one.
std::vector<std::string>
copyNames(const std::vector<MapInputFile>& files);

} // namespace apps
} // namespace pcl_ssfr
