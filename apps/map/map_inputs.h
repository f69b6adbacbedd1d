// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A scan to be placed.
struct MapInputFile {
  std::string path;
  std::string name; ///< the file's name; with as much of its folder as makes it another one than all others
};

/** \brief The scans of files and folders, by name in a folder, each file once.
 *
 * Of a folder: the files in it, and in its folder scans/, whose extension is that of a scan; not what goes with scans
 * under a known name (pairs.csv, poses.csv, poses.txt, control.csv and the results of this program).
 * \throw io::IoError for an input that does not exist, and for a folder without any scan
 */
std::vector<MapInputFile>
findScans(const std::vector<std::string>& inputs);

} // namespace apps
} // namespace pcl_ssfr
