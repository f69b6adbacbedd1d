// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_format.h>

#include <apps/io/e57_pages.h>
#include <apps/io/e57_records.h>
#include <apps/io/e57_structure.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

constexpr std::size_t kListed = 10; ///< scans that a message names
constexpr std::string_view kExtension = ".e57";

/// Where "#" of a pick is in a path, npos without one.
std::size_t
pickAt(std::string_view path)
{
  for (std::size_t at = path.find('#'); at != std::string_view::npos; at = path.find('#', at + 1)) {
    const std::string_view file = path.substr(0, at);
    if (file.size() > kExtension.size() &&
        std::equal(kExtension.begin(), kExtension.end(), file.end() - kExtension.size(), [](char a, char b) {
          return a == std::tolower(static_cast<unsigned char>(b));
        }))
      return at;
  }
  return std::string_view::npos;
}

/// "hall.e57#1 ('Hall', 1000 points), hall.e57#2 (2000 points)"
template <typename Scan>
std::string
listing(const std::string& file, const std::vector<Scan>& scans)
{
  std::string text;
  for (std::size_t i = 0; i < std::min(scans.size(), kListed); ++i)
    text += (i == 0 ? "" : ", ") + file + '#' + std::to_string(i + 1) + " (" +
            (scans[i].name.empty() ? "" : inQuotes(scans[i].name) + ", ") + std::to_string(scans[i].records) +
            " points)";
  return text + (scans.size() > kListed ? " and " + std::to_string(scans.size() - kListed) + " more" : "");
}

std::vector<E57Structure>
structuresOf(E57PageReader& pages)
{
  std::vector<E57Structure> scans = parseE57Xml(pages.path(), pages.readXml());
  if (scans.empty())
    throw IoError(pages.path() + ": holds no scan");
  return scans;
}

/// The number that \p pick is, counted from 1; 0 when it is none up to \p count.
std::size_t
numberOf(std::string_view pick, std::size_t count)
{
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(pick.data(), pick.data() + pick.size(), number);
  const bool is_number = error == std::errc() && end == pick.data() + pick.size() && pick[0] != '0';
  return is_number && number <= count ? number : 0;
}

/// The scan that \p pick names: its number, counted from 1, or its name.
template <typename Scan>
std::size_t
pickScan(const std::string& file, std::string_view pick, const std::vector<Scan>& scans)
{
  if (const std::size_t number = numberOf(pick, scans.size()); number > 0)
    return number - 1;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < scans.size(); ++i)
    if (!pick.empty() && scans[i].name == pick)
      found.push_back(i);
  if (found.size() == 1)
    return found[0];
  throw IoError(file + ": " + (found.empty() ? "no scan is called " : "several scans are called ") + inQuotes(pick) +
                "; it holds " + listing(file, scans));
}

/// The place of a field in a record, nothing when there is none.
std::optional<std::size_t>
findField(const E57Structure& scan, std::string_view name)
{
  for (std::size_t i = 0; i < scan.fields.size(); ++i)
    if (scan.fields[i].name == name && scan.fields[i].type != E57Type::kString)
      return i;
  return std::nullopt;
}

/// The fields of these three names, when all are there.
std::optional<std::array<std::size_t, 3>>
findVector(const E57Structure& scan, const std::array<const char*, 3>& names)
{
  std::array<std::size_t, 3> places{};
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto place = findField(scan, names[k]);
    if (!place)
      return std::nullopt;
    places[k] = *place;
  }
  return places;
}

constexpr std::array<const char*, 3> kCartesian{{"cartesianX", "cartesianY", "cartesianZ"}};
constexpr std::array<const char*, 3> kSpherical{{"sphericalRange", "sphericalAzimuth", "sphericalElevation"}};
constexpr std::array<const char*, 3> kColors{{"colorRed", "colorGreen", "colorBlue"}};

/// Fields of one number that become one field of ours.
struct Scalar {
  const char* name;
  const char* ours;
  std::uint8_t datatype;
};
constexpr Scalar kScalars[] = {{"intensity", "intensity", Field::FLOAT32},
                               {"nor:normalX", "normal_x", Field::FLOAT32},
                               {"nor:normalY", "normal_y", Field::FLOAT32},
                               {"nor:normalZ", "normal_z", Field::FLOAT32},
                               {"timeStamp", "time", Field::FLOAT64},
                               {"rowIndex", "row", Field::INT32},
                               {"columnIndex", "column", Field::INT32},
                               {"returnIndex", "return_index", Field::UINT8},
                               {"returnCount", "return_count", Field::UINT8}};

/// Turns decoded records into a table.
class TableBuilder {
public:
  TableBuilder(const std::string& path, const E57Structure& scan, FieldChoice fields);

  /// Fields to decode, in the order in which columns arrive.
  const std::vector<std::size_t>&
  wanted() const
  {
    return wanted_;
  }
  /// \p records: not more than the file has data for
  void
  reserve(std::uint64_t records)
  {
    table_.data.reserve(static_cast<std::size_t>(records) * table_.point_step);
  }
  void
  add(const std::vector<std::vector<double>>& columns, std::size_t records);
  pcl::PCLPointCloud2
  take();

private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  /// A value of the table and the column that it comes from.
  struct Target {
    std::size_t column;
    std::size_t offset;
    std::uint8_t datatype;
  };

  std::size_t
  want(std::optional<std::size_t> field)
  {
    if (!field)
      return kNone;
    wanted_.push_back(*field);
    return wanted_.size() - 1;
  }
  std::uint32_t
  color(double value, const std::pair<double, double>& range) const;

  std::string path_;
  std::vector<std::size_t> wanted_;
  bool spherical_ = false;
  std::uint8_t xyz_type_ = Field::FLOAT32;
  std::size_t invalid_ = kNone; ///< columns
  std::size_t invalid_intensity_ = kNone;
  std::size_t invalid_color_ = kNone;
  std::size_t first_color_ = kNone;
  std::array<std::pair<double, double>, 3> color_ranges_{};
  std::size_t rgb_offset_ = 0;
  std::size_t intensity_target_ = kNone;
  std::vector<Target> targets_;
  pcl::PCLPointCloud2 table_;
  std::size_t points_ = 0;
};

TableBuilder::TableBuilder(const std::string& path, const E57Structure& scan, FieldChoice fields) : path_(path)
{
  auto places = findVector(scan, kCartesian);
  if (!places) {
    places = findVector(scan, kSpherical);
    spherical_ = places.has_value();
  }
  if (!places)
    throw IoError(path + ": the points have neither cartesianX, Y, Z nor sphericalRange, Azimuth, Elevation");
  for (const std::size_t place : *places) {
    const E57Field& field = scan.fields[place];
    const auto [low, high] = field.range();
    const bool is_integer = field.type == E57Type::kInteger || field.type == E57Type::kScaledInteger;
    if (field.type == E57Type::kDouble || (is_integer && std::max(-low, high) > kLargeCoordinate))
      xyz_type_ = Field::FLOAT64;
    want(place);
  }
  for (const char* name : {"x", "y", "z"})
    addField(table_, name, xyz_type_);
  invalid_ = want(findField(scan, spherical_ ? "sphericalInvalidState" : "cartesianInvalidState"));
  for (const Scalar& scalar : kScalars) {
    const auto place = findField(scan, scalar.name);
    if (!place || !isKept(fields, scalar.ours))
      continue;
    if (std::strcmp(scalar.name, "intensity") == 0) {
      intensity_target_ = targets_.size();
      invalid_intensity_ = want(findField(scan, "isIntensityInvalid"));
    }
    targets_.push_back({want(place), table_.point_step, scalar.datatype});
    addField(table_, scalar.ours, scalar.datatype);
  }
  if (const auto colors = findVector(scan, kColors); colors && isKept(fields, "rgb")) {
    first_color_ = wanted_.size();
    for (std::size_t k = 0; k < colors->size(); ++k) {
      want((*colors)[k]);
      color_ranges_[k] = scan.color_limits.value_or(scan.fields[(*colors)[k]].range());
      if (!scan.color_limits && color_ranges_[k].second > UINT32_MAX) // no bound at all: as nearly all files have them
        color_ranges_[k] = {0, 255};
    }
    invalid_color_ = want(findField(scan, "isColorInvalid"));
    rgb_offset_ = table_.point_step;
    addField(table_, "rgb", Field::FLOAT32);
  }
}

/// 8 bits of a colour: what fits into them as it is, more bits by their upper eight, fractions of one by 255.
std::uint32_t
TableBuilder::color(double value, const std::pair<double, double>& range) const
{
  constexpr double kLevels = 256;
  if (std::isfinite(range.second) && range.second > kLevels - 1)
    value = std::floor((value - range.first) * (kLevels / (range.second - range.first + 1)));
  else if (range.second <= 1)
    value *= kLevels - 1;
  return std::isfinite(value) ? static_cast<std::uint32_t>(std::clamp(std::round(value), 0.0, kLevels - 1)) : 0U;
}

void
TableBuilder::add(const std::vector<std::vector<double>>& columns, std::size_t records)
{
  const auto isSet = [&columns](std::size_t column, std::size_t i) {
    return column != kNone && columns[column][i] != 0;
  };
  table_.data.resize((points_ + records) * table_.point_step);
  for (std::size_t i = 0; i < records; ++i) {
    if (isSet(invalid_, i))
      continue;
    std::uint8_t* point = table_.data.data() + points_ * table_.point_step;
    std::array<double, 3> xyz{{columns[0][i], columns[1][i], columns[2][i]}};
    if (spherical_) {
      const auto [range, azimuth, elevation] = xyz;
      xyz = {{range * std::cos(elevation) * std::cos(azimuth),
              range * std::cos(elevation) * std::sin(azimuth),
              range * std::sin(elevation)}};
    }
    for (std::size_t k = 0; k < xyz.size(); ++k)
      storeValue(point + k * valueSize(xyz_type_), xyz_type_, xyz[k]);
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      const bool missing = k == intensity_target_ && isSet(invalid_intensity_, i);
      storeValue(point + targets_[k].offset, targets_[k].datatype, missing ? 0 : columns[targets_[k].column][i]);
    }
    if (first_color_ != kNone) {
      std::array<std::uint32_t, 3> rgb{};
      for (std::size_t k = 0; k < rgb.size() && !isSet(invalid_color_, i); ++k)
        rgb[k] = color(columns[first_color_ + k][i], color_ranges_[k]);
      const std::uint32_t packed = packRgb(rgb[0], rgb[1], rgb[2]);
      std::memcpy(point + rgb_offset_, &packed, sizeof(packed));
    }
    ++points_;
  }
  if (points_ > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw IoError(path_ + ": more than " + std::to_string(std::numeric_limits<std::int32_t>::max()) + " points");
}

pcl::PCLPointCloud2
TableBuilder::take()
{
  table_.height = 1;
  table_.width = static_cast<std::uint32_t>(points_);
  table_.row_step = table_.point_step * table_.width;
  table_.data.resize(points_ * table_.point_step);
  return std::move(table_);
}

} // namespace

std::string
fileOfScan(const std::string& path)
{
  return path.substr(0, pickAt(path));
}

bool
isE57(const std::string& path)
{
  return pickAt(path + '#') == fileOfScan(path).size();
}

std::vector<E57Scan>
listE57Scans(const std::string& path)
{
  const FileBytes source(path);
  E57PageReader pages(path, source);
  const std::vector<E57Structure> structures = structuresOf(pages);
  std::map<std::string, std::size_t> named;
  for (const E57Structure& scan : structures)
    ++named[scan.name];
  std::vector<E57Scan> scans;
  for (const E57Structure& scan : structures) {
    const std::string number = std::to_string(scans.size() + 1);
    std::string pick = path;
    pick += '#';
    pick += number;
    const bool by_name = !scan.name.empty() && named[scan.name] == 1 && numberOf(scan.name, structures.size()) == 0;
    scans.push_back({pick, scan.name, scan.guid, scan.records, scan.T_file_scan, by_name ? scan.name : number});
  }
  return scans;
}

std::size_t
findE57Scan(const std::string& file, const std::string& pick, const std::vector<E57Scan>& scans)
{
  return pickScan(file, pick, scans);
}

RawCloud
readE57(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  const std::size_t pick = pickAt(path);
  const std::string file = path.substr(0, pick);
  E57PageReader pages(file, source);
  const std::vector<E57Structure> scans = structuresOf(pages);
  if (pick == std::string::npos && scans.size() > 1)
    throw IoError(file + ": holds " + std::to_string(scans.size()) + " scans, pick one of " + listing(file, scans));
  const std::string_view picked =
      pick == std::string::npos ? std::string_view("1") : std::string_view(path).substr(pick + 1);
  const E57Structure& scan = scans[pickScan(file, picked, scans)];
  RawCloud cloud;
  cloud.T_file_scan = scan.T_file_scan;
  TableBuilder builder(path, scan, fields);
  E57RecordReader records(pages, scan, builder.wanted());
  builder.reserve(scan.records);
  std::vector<std::vector<double>> columns;
  while (const std::size_t count = records.next(columns))
    builder.add(columns, count);
  cloud.table = builder.take();
  return cloud;
}

} // namespace io
} // namespace pcl_ssfr
