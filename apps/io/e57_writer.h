// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/e57_pages.h>
#include <apps/io/loaded_cloud.h>

#include <Eigen/Geometry>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief Writes scans with their poses into one E57 file, one after the other: no scan is kept in memory.
 *
 * Kept of each point: coordinates, intensity, colour, and normals, row, column, time and returns as readE57 names
 * them. Points that are not finite are left out. The same scans give the same bytes. Until finish() the file has no
 * E57 header: what a crash leaves behind is not taken for a whole file.
 */
class E57Writer {
public:
  /// Replaces the file. \throw IoError when it cannot be created
  explicit E57Writer(const std::string& path);

  /** \brief Append a scan. Its points are written in the frame of the sensor: relative to cloud.viewpoint where that is
   * known, and the pose leads from there to the map.
   * \param[in] cloud with its table
   * \param[in] name any text; made fit for XML
   * \param[in] T_map_scan maps file coordinates of the cloud into the map, a rigid motion [m]
   * \throw IoError when it cannot be written, the pose is not finite or the cloud has no table
   */
  void
  addScan(const std::string& name, const LoadedCloud& cloud, const Eigen::Isometry3d& T_map_scan);

  /// Write what describes the scans, and close. \throw IoError when the disk is full
  void
  finish();

private:
  std::string path_;
  E57PageWriter pages_;
  std::string scans_; ///< XML
  std::size_t count_ = 0;
};

} // namespace io
} // namespace pcl_ssfr
