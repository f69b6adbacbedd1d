// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/PCLPointCloud2.h>

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/// Coordinates beyond this lose millimetres as 32-bit floats: they are kept as doubles, and offset before the cast [m].
constexpr double kLargeCoordinate = 1e4;

/// Fields of a point that text, PCD and PLY files may have.
constexpr std::size_t kMaxFields = 1000;

/// Data types of 64-bit integers as PCL numbers them (its names for them are newer than PCL 1.12).
constexpr std::uint8_t kInt64 = 9;
constexpr std::uint8_t kUint64 = 10;

/// What a reader found: every field of every point as stored in the file, and where the file says the sensor was.
struct RawCloud {
  pcl::PCLPointCloud2 table;                ///< packed; has scalar fields x, y, z of type FLOAT32 or FLOAT64 [m]
  std::optional<Eigen::Vector3d> viewpoint; ///< in the coordinates of the points [m]
  /// Where the file places the scan: maps its points into a frame that several scans share [m].
  std::optional<Eigen::Isometry3d> T_file_scan;
};

/// Which fields of a file a reader keeps.
enum class FieldChoice {
  kAll,
  kGeometry ///< coordinates and normals: what a registration takes
};

/// True when \p choice keeps the field that is called \p name in a table.
bool
isKept(FieldChoice choice, std::string_view name);

/// Bytes of records that a reader takes from a file at a time.
constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

/// Number of points of a table.
std::size_t
pointCount(const pcl::PCLPointCloud2& table);

/// Bytes of one value of a PCL data type; 0 for an unknown type.
std::size_t
valueSize(std::uint8_t datatype);

/// Append a field to the layout of a table that has no points yet.
void
addField(pcl::PCLPointCloud2& table, const std::string& name, std::uint8_t datatype, std::uint32_t count = 1);

/** \brief Make room for \p points points in one row, all bytes zero.
 * The caller has compared the number with the size of the file.
 */
void
resizeTable(pcl::PCLPointCloud2& table, std::size_t points);

/// The field of this name, null when there is none.
const pcl::PCLPointField*
findField(const pcl::PCLPointCloud2& table, std::string_view name);

/// The fields of these three names, when all exist as single FLOAT32 or FLOAT64 values.
std::optional<std::array<const pcl::PCLPointField*, 3>>
findVector(const pcl::PCLPointCloud2& table, const char* x, const char* y, const char* z);

/// The value of type \p datatype at \p at.
double
loadValue(const std::uint8_t* at, std::uint8_t datatype);

/// Store \p value as \p datatype; integers are rounded and clamped to the range of the type, NaN becomes 0 in them.
void
storeValue(std::uint8_t* at, std::uint8_t datatype, double value);

/// Three colours of 0..255 in the packed form of PCL's rgb field.
std::uint32_t
packRgb(std::uint32_t red, std::uint32_t green, std::uint32_t blue);

/** \brief A table from named columns of numbers, as text formats and PLY have them.
 *
 * x, y, z come first, as FLOAT64 when any coordinate is large, else FLOAT32. Columns red, green, blue become one field
 * rgb; every other column keeps its name and becomes FLOAT32, or FLOAT64 when FLOAT32 cannot hold its integers (times).
 * \param[in] names one per column, among them "x", "y", "z"; distinct
 * \param[in] values row-major, names.size() per row
 */
pcl::PCLPointCloud2
tableFromColumns(const std::vector<std::string>& names, const std::vector<double>& values);

/** \brief Our name for a column or property of a file: lower case, without unit or quotes; nx -> normal_x, i and its
 * kin -> intensity, r -> red, ... Names that mean nothing to us stay, with spaces as '_'.
 */
std::string
canonicalName(std::string_view name);

} // namespace io
} // namespace pcl_ssfr
