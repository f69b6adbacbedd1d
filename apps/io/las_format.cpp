// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/las_format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

// Byte offsets within the public header block (LAS 1.4 R15, table 3).
constexpr std::size_t kVersionMajorAt = 24;
constexpr std::size_t kVersionMinorAt = 25;
constexpr std::size_t kDataOffsetAt = 96;
constexpr std::size_t kFormatAt = 104;
constexpr std::size_t kRecordLengthAt = 105;
constexpr std::size_t kLegacyCountAt = 107;
constexpr std::size_t kScaleAt = 131;
constexpr std::size_t kOffsetAt = 155;
constexpr std::size_t kHeaderBytes = 227;
constexpr std::size_t kCountAt = 247; // 1.4 only
constexpr std::size_t kHeaderBytes14 = 375;

// Byte offsets within a point record; x, y, z and intensity are the same in all formats.
constexpr std::size_t kIntensityAt = 12;
constexpr std::size_t kLegacyClassAt = 15;
constexpr unsigned kLegacyClassMask = 31; ///< formats 0 to 5 keep flags in the upper bits

/// What a point format holds and where (LAS 1.4 R15, tables 7 to 17); 0: not there.
struct PointFormat {
  std::size_t bytes;
  std::size_t classification_at;
  std::size_t time_at;
  std::size_t rgb_at;
};
constexpr std::array<PointFormat, 11> kFormats{{{20, 15, 0, 0},
                                                {28, 15, 20, 0},
                                                {26, 15, 0, 20},
                                                {34, 15, 20, 28},
                                                {57, 15, 20, 0},
                                                {63, 15, 20, 28},
                                                {30, 16, 22, 0},
                                                {36, 16, 22, 30},
                                                {38, 16, 22, 30},
                                                {59, 16, 22, 0},
                                                {67, 16, 22, 30}}};
constexpr unsigned kCompressedFrom = 64; // LAZ sets the upper bits of the point format

struct LasHeader {
  PointFormat format{};
  std::size_t record = 0;      ///< bytes of a point record
  std::size_t data_offset = 0; ///< of the first record [bytes]
  std::size_t points = 0;
  std::array<double, 3> scale{};
  std::array<double, 3> offset{};
};

/// \param[in] bytes the first of a file of \p size bytes, all that a header can have
LasHeader
readHeader(const std::string& path, std::string_view bytes, std::uint64_t size)
{
  if (bytes.substr(0, 4) != "LASF")
    throw IoError(path + ": not a LAS file: it starts with " + inQuotes(bytes.substr(0, 4)) + ", not 'LASF'");
  if (bytes.size() < kHeaderBytes)
    throw IoError(path + ": the LAS header ends after " + std::to_string(bytes.size()) + " bytes");
  const unsigned major = valueAt<std::uint8_t>(bytes, kVersionMajorAt);
  const unsigned minor = valueAt<std::uint8_t>(bytes, kVersionMinorAt);
  if (major != 1 || minor > 4)
    throw IoError(path + ": LAS version " + std::to_string(major) + "." + std::to_string(minor) + " is not supported");
  const unsigned format = valueAt<std::uint8_t>(bytes, kFormatAt);
  if (format >= kCompressedFrom)
    throw IoError(path +
                  ": is compressed (LAZ), which is not read: 'pdal translate IN.laz OUT.las' or 'laszip -i IN.laz -o "
                  "OUT.las' makes a LAS file of it (free programs, see docs/FORMATS.md)");
  if (format >= kFormats.size())
    throw IoError(path + ": LAS point format " + std::to_string(format) + " is not supported");

  LasHeader header;
  header.format = kFormats[format];
  header.record = valueAt<std::uint16_t>(bytes, kRecordLengthAt);
  if (header.record < header.format.bytes)
    throw IoError(path + ": point record length " + std::to_string(header.record) + " is less than the " +
                  std::to_string(header.format.bytes) + " bytes of point format " + std::to_string(format));
  header.data_offset = valueAt<std::uint32_t>(bytes, kDataOffsetAt);
  std::uint64_t points = valueAt<std::uint32_t>(bytes, kLegacyCountAt);
  if (minor == 4) {
    if (bytes.size() < kHeaderBytes14)
      throw IoError(path + ": the LAS 1.4 header ends after " + std::to_string(bytes.size()) + " bytes");
    if (const auto count = valueAt<std::uint64_t>(bytes, kCountAt); count != 0)
      points = count;
  }
  if (header.data_offset < kHeaderBytes || header.data_offset > size)
    throw IoError(path + ": offset to point data " + std::to_string(header.data_offset) + " is outside the file");
  if (points > (size - header.data_offset) / header.record ||
      points > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
    throw IoError(path + ": number of point records " + std::to_string(points) + " of " +
                  std::to_string(header.record) + " bytes do not fit into the " +
                  std::to_string(size - header.data_offset) + " bytes of point data");
  header.points = static_cast<std::size_t>(points);
  for (std::size_t k = 0; k < 3; ++k) {
    header.scale[k] = valueAt<double>(bytes, kScaleAt + k * sizeof(double));
    header.offset[k] = valueAt<double>(bytes, kOffsetAt + k * sizeof(double));
    if (!std::isfinite(header.scale[k]) || header.scale[k] == 0 || !std::isfinite(header.offset[k]))
      throw IoError(path + ": scale " + std::to_string(header.scale[k]) + " and offset " +
                    std::to_string(header.offset[k]) + " of " + "xyz"[k] + " give no coordinates");
  }
  return header;
}

double
coordinate(std::string_view record, const LasHeader& header, std::size_t k)
{
  return valueAt<std::int32_t>(record, k * sizeof(std::int32_t)) * header.scale[k] + header.offset[k];
}

std::array<std::uint16_t, 3>
colourAt(std::string_view record, std::size_t at)
{
  return {{valueAt<std::uint16_t>(record, at),
           valueAt<std::uint16_t>(record, at + 2),
           valueAt<std::uint16_t>(record, at + 4)}};
}

/// Call \p use with the bytes of each point record, one after the other.
template <typename Use>
void
forEachRecord(const ByteSource& source, const LasHeader& header, const Use& use)
{
  const std::size_t in_block = std::max<std::size_t>(1, kBlockBytes / header.record);
  std::string block;
  for (std::size_t i = 0; i < header.points; i += in_block) {
    block.resize(std::min(in_block, header.points - i) * header.record);
    source.read(header.data_offset + std::uint64_t{i} * header.record, block.size(), block.data());
    for (std::size_t at = 0; at < block.size(); at += header.record)
      use(std::string_view(block).substr(at, header.record));
  }
}

} // namespace

RawCloud
readLas(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  std::string head(static_cast<std::size_t>(std::min<std::uint64_t>(kHeaderBytes14, source.size())), '\0');
  source.read(0, head.size(), head.data());
  const LasHeader header = readHeader(path, head, source.size());
  const bool has_time = header.format.time_at != 0 && isKept(fields, "gps_time");
  const bool has_colour = header.format.rgb_at != 0 && isKept(fields, "rgb");
  double extent = 0;
  unsigned brightest = 0;
  forEachRecord(source, header, [&](std::string_view from) {
    for (std::size_t k = 0; k < 3; ++k)
      extent = std::max(extent, std::abs(coordinate(from, header, k)));
    if (has_colour)
      for (const unsigned value : colourAt(from, header.format.rgb_at))
        brightest = std::max(brightest, value);
  });
  const unsigned colour_shift = brightest > 255 ? 8 : 0; // the standard asks for 16 bits, many files hold 8

  RawCloud cloud;
  pcl::PCLPointCloud2& table = cloud.table;
  const std::uint8_t xyz_type = extent > kLargeCoordinate ? Field::FLOAT64 : Field::FLOAT32;
  for (const char* name : {"x", "y", "z"})
    addField(table, name, xyz_type);
  const bool has_scalars = isKept(fields, "intensity");
  if (has_scalars) {
    addField(table, "intensity", Field::FLOAT32);
    addField(table, "classification", Field::UINT8);
  }
  if (has_time)
    addField(table, "gps_time", Field::FLOAT64);
  if (has_colour)
    addField(table, "rgb", Field::FLOAT32);
  resizeTable(table, header.points);
  std::uint8_t* to = table.data.data();
  forEachRecord(source, header, [&](std::string_view from) {
    std::size_t field = 0;
    const auto put = [&](double value) {
      storeValue(to + table.fields[field].offset, table.fields[field].datatype, value);
      ++field;
    };
    for (std::size_t k = 0; k < 3; ++k)
      put(coordinate(from, header, k));
    if (has_scalars) {
      put(valueAt<std::uint16_t>(from, kIntensityAt));
      const unsigned classification = valueAt<std::uint8_t>(from, header.format.classification_at);
      put(header.format.classification_at == kLegacyClassAt ? classification & kLegacyClassMask : classification);
    }
    if (has_time)
      put(valueAt<double>(from, header.format.time_at));
    if (has_colour) {
      const auto colour = colourAt(from, header.format.rgb_at);
      const std::uint32_t packed = packRgb(static_cast<std::uint32_t>(colour[0]) >> colour_shift,
                                           static_cast<std::uint32_t>(colour[1]) >> colour_shift,
                                           static_cast<std::uint32_t>(colour[2]) >> colour_shift);
      std::memcpy(to + table.fields[field].offset, &packed, sizeof(packed));
    }
    to += table.point_step;
  });
  return cloud;
}

} // namespace io
} // namespace pcl_ssfr
