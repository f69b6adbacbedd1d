// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/// One scan of an E57 file.
struct E57Scan {
  std::string path;                             ///< picks this scan wherever a scan is read: "hall.e57#2"
  std::string name;                             ///< as in the file, empty when it has none; not always unique
  std::string guid;                             ///< as in the file
  std::uint64_t records = 0;                    ///< points, those without a return included; as the file says
  std::optional<Eigen::Isometry3d> T_file_scan; ///< maps points of the scan into the frame of the file [m]
  std::string pick; ///< what to call it by: its name where no other scan of the file and no number is meant, else "2"
};

/// True for "hall.e57" in any case of letters, with a pick or without.
bool
isE57(const std::string& path);

/** \brief The scans of an E57 file in their order; their points are not read.
 * \throw IoError when the file cannot be read or holds no scan
 */
std::vector<E57Scan>
listE57Scans(const std::string& path);

/** \brief The scan that "hall.e57#2" or "hall.e57#Lobby" picks, its place in the list of the file.
 * \throw IoError that lists the scans when \p pick is none of them or may be several
 */
std::size_t
findE57Scan(const std::string& file, const std::string& pick, const std::vector<E57Scan>& scans);

/// The path of a scan without "#2" or "#NAME" behind an E57 file: the file that holds the scan.
std::string
fileOfScan(const std::string& path);

/** \brief Read one scan of an E57 file, streaming: the whole file is never in memory.
 *
 * Points come in the frame of the scan (the sensor is its origin) and RawCloud::T_file_scan is the pose in the file.
 * Points that the file calls invalid are left out. Intensity, colour (8 bits), normals (extension), row, column, time
 * and returns are kept, everything else is skipped.
 * \param[in] path the file, or "FILE#2" or "FILE#NAME" for the second scan or the one of that name
 * \throw IoError that lists the scans when the file has several and \p path picks none; when anything is damaged
 */
RawCloud
readE57(const std::string& path, const ByteSource& source, FieldChoice fields);

} // namespace io
} // namespace pcl_ssfr
