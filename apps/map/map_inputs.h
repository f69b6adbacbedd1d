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
  std::string path; ///< "hall.e57#2" for a scan of several in an E57 file
  /// The file's name; with as much of its folder as makes it another one than all others; and "#NAME" or "#2" of a scan
  /// in an E57 file.
  std::string name;
};

/** \brief The scans of files and folders, by name in a folder, each file once.
 *
 * An E57 file with several scans gives all of them, one with a pick ("hall.e57#2") the one that it picks; one that
 * cannot be read stays as it is, for the reason to be found where it is read.
 * Of a folder: the files in it, and in its folder scans/, whose extension is that of a scan; not what goes with scans
 * under a known name (pairs.csv, poses.csv, poses.txt, control.csv and the results of this program).
 * \throw io::IoError for an input that does not exist, for a pick that picks nothing, for a folder without any scan
 */
std::vector<MapInputFile>
findScans(const std::vector<std::string>& inputs);

/// What a person may call a scan by, best first: its name, that without folders, that without the extension, and what
/// is behind "#" of a scan in an E57 file.
std::vector<std::string>
namesOfScan(const std::string& name);

} // namespace apps
} // namespace pcl_ssfr
