// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/output_file.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <string>

namespace pcl_ssfr {

namespace io {
struct LoadedCloud;
}

namespace apps {

/** \brief One cloud of many scans, written scan after scan: no more than one of them is in memory.
 *
 * Binary PCD or PLY by the extension, with x, y, z, the colour of the scan, intensity and the number of the scan.
 * Coordinates are float, or double where the map is far from its origin.
 */
class MergedCloud {
public:
  /// \param[in] leaf each scan is thinned to one point per cube of this edge [m]; 0: it is not
  /// \param[in] wide coordinates as double
  /// \throw io::IoError when the file cannot be created
  MergedCloud(const std::string& path, double leaf, bool wide);
  /// \param[in] cloud its table is what is read
  /// \param[in] T_map_file maps file coordinates into the map
  /// \throw io::IoError
  void
  add(const io::LoadedCloud& cloud, const Eigen::Isometry3d& T_map_file, std::size_t number);
  /// Complete the file. \return the number of points \throw io::IoError
  std::size_t
  finish();

private:
  std::string
  header() const;

  std::string path_;
  io::OutputFile file_;
  double leaf_;
  bool wide_;
  bool pcd_;
  std::size_t points_ = 0;
};

/// The colour of a scan or component, evenly spread over the hues: red, green, blue.
Eigen::Matrix<unsigned char, 3, 1>
colourOf(std::size_t number);

} // namespace apps
} // namespace pcl_ssfr
