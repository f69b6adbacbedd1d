// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace io {

enum class E57Type { kFloat, kDouble, kInteger, kScaledInteger, kString };

/// A field of the records of an E57 scan, which is also a stream of bytes in its packets.
struct E57Field {
  std::string name; ///< with the prefix of its extension, as in "nor:normalX"
  E57Type type = E57Type::kDouble;
  /// Of the stored integers, which are stored as what they are above the least one.
  std::int64_t minimum = std::numeric_limits<std::int64_t>::min();
  std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  double scale = 1;  ///< scaled integer: value = integer * scale + offset
  double offset = 0; ///< as scale

  /// Bits of a value, 0 to 64; of a string the least that it takes.
  unsigned
  bits() const;
  /// The value that the bits \p stored stand for.
  double
  value(std::uint64_t stored) const;
  /// The values that integers can have; for floating point numbers nothing is known: infinite.
  std::pair<double, double>
  range() const;
};

/// What the XML section of an E57 file says about one scan.
struct E57Structure {
  std::string name; ///< empty when it has none
  std::string guid;
  std::optional<Eigen::Isometry3d> T_file_scan; ///< maps points of the scan into the frame of the file [m]
  std::vector<E57Field> fields;
  std::uint64_t points_at = 0; ///< physical offset of the section of the records
  std::uint64_t records = 0;   ///< as the file says: not checked
  /// Least and greatest value of red, green, blue, when the file says so.
  std::optional<std::pair<double, double>> color_limits;
};

/** \brief The scans of a file from its XML section.
 * \throw IoError that names the scan, the element and the value; or that says that E57 support was not built
 */
std::vector<E57Structure>
parseE57Xml(const std::string& path, std::string xml);

} // namespace io
} // namespace pcl_ssfr
