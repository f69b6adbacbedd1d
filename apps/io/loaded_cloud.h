// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/io_error.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/// A cloud as the tools work on it.
struct LoadedCloud {
  std::string path;
  /// Every point of the file in its order, NaN included, as float relative to \ref offset [m]. Normals and intensity
  /// are zero when the file has none. Without its offset: file coordinates = offset + points.
  pcl::PointCloud<pcl::PointXYZINormal>::Ptr points;
  bool has_intensity = false;
  bool has_normals = false;
  /// Subtracted in double before the cast to float; zero unless the coordinates are large (map frames) [m].
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  /// Where the file says that the sensor was, in file coordinates [m]; nothing when it says the origin or nothing.
  std::optional<Eigen::Vector3d> viewpoint;
  /// Where the file places the scan among others: maps file coordinates into the frame that they share (E57) [m].
  std::optional<Eigen::Isometry3d> T_file_scan;
  /// All fields in file coordinates, for writing the cloud again without loss.
  pcl::PCLPointCloud2 table;
};

/// The extensions that loadCloud knows, for messages and help.
const char*
readableFormats();

/// The extension of the file of a scan, in lower case: ".pcd"; empty where it has none.
std::string
extensionOf(const std::string& scan);

/// True when loadCloud knows the extension of this file, in any case of letters.
bool
isReadableFormat(const std::string& path);

/** \brief Read a cloud in the format that the extension of \p path names, in any case of letters.
 * An E57 file with several scans needs a pick: "FILE#2" or "FILE#NAME" (e57_format.h).
 * \throw IoError naming the file and what is wrong with it
 */
LoadedCloud
loadCloud(const std::string& path);

/// loadCloud() with LoadedCloud::points null: what it takes to write the scan again. \throw as loadCloud()
LoadedCloud
loadTable(const std::string& path);

/// What a registration takes of a scan, as floats.
struct ScanPoints {
  std::vector<std::uint8_t> bytes; ///< of the floats
  std::size_t size = 0;            ///< points: every one of the file in its order, NaN included
  bool has_normals = false;
  /// As LoadedCloud::offset: the points are relative to it [m].
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> viewpoint; ///< as LoadedCloud::viewpoint

  /// Floats of a point: x, y, z [m], and a normal where there are normals.
  std::size_t
  stride() const
  {
    return has_normals ? 6 : 3;
  }
  const float*
  xyz() const
  {
    return reinterpret_cast<const float*>(bytes.data());
  }
};

/** \brief The same numbers as of loadCloud() in little memory.
 *
 * Files are read block by block: at most 12 bytes a point with single precision, 24 with double, and as much again for
 * normals. While they are read, tables of numbers in text (PLY too) take 24 for the coordinates and 24 for the normals
 * besides. Compressed PCD, KITTI and 3DTK files take the file, decompressed, and its table.
 * \throw as loadCloud()
 */
ScanPoints
loadScanPoints(const std::string& path);

/// loadScanPoints() on the content of a file that is already in memory.
ScanPoints
parseScanPoints(const std::string& path, std::string_view bytes);

/// loadCloud() on the content of a file that is already in memory; \p path gives the format and the name in messages.
LoadedCloud
parseCloud(const std::string& path, std::string_view bytes);

/// The extensions that saveMovedCloud knows, for messages: "a, b or c".
const char*
writableFormats();

/// True when saveMovedCloud can write a file of this name, in any case of letters.
bool
isWritableFormat(const std::string& path);

/** \brief Write \p cloud moved by a rigid motion, with all its fields; normals are rotated with it.
 *
 * E57 keeps points in the frame of the sensor and the motion as the pose of the scan (e57_writer.h). Else coordinates
 * are written as FLOAT64 when the file had them so or when the moved ones are large, else as FLOAT32.
 * \param[in] T_target_source maps file coordinates of the cloud to those of the target
 * \param[in] pcd_comment as of writePcd(); other formats take none
 * \throw IoError
 */
void
saveMovedCloud(const std::string& path,
               const LoadedCloud& cloud,
               const Eigen::Isometry3d& T_target_source,
               std::string_view pcd_comment = {});

} // namespace io
} // namespace pcl_ssfr
