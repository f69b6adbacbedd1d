// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/field_table.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

/// Integers up to here are exact in a FLOAT32.
constexpr double kFloatExact = 16777216;

template <typename T>
double
load(const std::uint8_t* at)
{
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

template <typename T>
void
store(std::uint8_t* at, double value)
{
  T typed = 0;
  if constexpr (std::numeric_limits<T>::is_integer) {
    constexpr double kLow = static_cast<double>(std::numeric_limits<T>::lowest());
    constexpr double kHigh = static_cast<double>(std::numeric_limits<T>::max());
    const double rounded = std::round(value);
    if (rounded >= kHigh) // 2^63 and 2^64 are doubles, the largest 64-bit integers are not
      typed = std::numeric_limits<T>::max();
    else if (rounded <= kLow)
      typed = std::numeric_limits<T>::lowest();
    else if (!std::isnan(rounded))
      typed = static_cast<T>(rounded);
  }
  else {
    typed = static_cast<T>(value);
  }
  std::memcpy(at, &typed, sizeof(T));
}

/// Largest finite absolute value of one column.
double
largestMagnitude(const std::vector<double>& values, std::size_t column, std::size_t columns)
{
  double largest = 0;
  for (std::size_t i = column; i < values.size(); i += columns)
    if (std::isfinite(values[i]))
      largest = std::max(largest, std::abs(values[i]));
  return largest;
}

std::size_t
columnOf(const std::vector<std::string>& names, std::string_view name)
{
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::uint32_t
colour(double value)
{
  return std::isfinite(value) ? static_cast<std::uint32_t>(std::clamp(std::round(value), 0.0, 255.0)) : 0U;
}

} // namespace

bool
isKept(FieldChoice choice, std::string_view name)
{
  constexpr std::string_view kGeometry[] = {"x", "y", "z", "normal_x", "normal_y", "normal_z"};
  return choice == FieldChoice::kAll ||
         std::find(std::begin(kGeometry), std::end(kGeometry), name) != std::end(kGeometry);
}

std::size_t
pointCount(const pcl::PCLPointCloud2& table)
{
  return static_cast<std::size_t>(table.width) * table.height;
}

std::size_t
valueSize(std::uint8_t datatype)
{
  switch (datatype) {
  case Field::INT8:
  case Field::UINT8:
    return 1;
  case Field::INT16:
  case Field::UINT16:
    return 2;
  case Field::INT32:
  case Field::UINT32:
  case Field::FLOAT32:
    return 4;
  case Field::FLOAT64:
  case kInt64:
  case kUint64:
    return 8;
  default:
    return 0;
  }
}

void
addField(pcl::PCLPointCloud2& table, const std::string& name, std::uint8_t datatype, std::uint32_t count)
{
  Field field;
  field.name = name;
  field.offset = table.point_step;
  field.datatype = datatype;
  field.count = count;
  table.fields.push_back(field);
  table.point_step += static_cast<std::uint32_t>(valueSize(datatype)) * count;
}

void
resizeTable(pcl::PCLPointCloud2& table, std::size_t points)
{
  table.height = 1;
  table.width = static_cast<std::uint32_t>(points);
  table.row_step = table.point_step * table.width;
  table.data.assign(points * table.point_step, 0);
}

const Field*
findField(const pcl::PCLPointCloud2& table, std::string_view name)
{
  for (const auto& field : table.fields)
    if (field.name == name)
      return &field;
  return nullptr;
}

std::optional<std::array<const Field*, 3>>
findVector(const pcl::PCLPointCloud2& table, const char* x, const char* y, const char* z)
{
  const std::array<const Field*, 3> fields{{findField(table, x), findField(table, y), findField(table, z)}};
  for (const auto* field : fields)
    if (!field || field->count != 1 || (field->datatype != Field::FLOAT32 && field->datatype != Field::FLOAT64))
      return std::nullopt;
  return fields;
}

double
loadValue(const std::uint8_t* at, std::uint8_t datatype)
{
  switch (datatype) {
  case Field::INT8:
    return load<std::int8_t>(at);
  case Field::UINT8:
    return load<std::uint8_t>(at);
  case Field::INT16:
    return load<std::int16_t>(at);
  case Field::UINT16:
    return load<std::uint16_t>(at);
  case Field::INT32:
    return load<std::int32_t>(at);
  case Field::UINT32:
    return load<std::uint32_t>(at);
  case Field::FLOAT32:
    return load<float>(at);
  case Field::FLOAT64:
    return load<double>(at);
  case kInt64:
    return load<std::int64_t>(at);
  case kUint64:
    return load<std::uint64_t>(at);
  default:
    return std::numeric_limits<double>::quiet_NaN();
  }
}

void
storeValue(std::uint8_t* at, std::uint8_t datatype, double value)
{
  switch (datatype) {
  case Field::INT8:
    return store<std::int8_t>(at, value);
  case Field::UINT8:
    return store<std::uint8_t>(at, value);
  case Field::INT16:
    return store<std::int16_t>(at, value);
  case Field::UINT16:
    return store<std::uint16_t>(at, value);
  case Field::INT32:
    return store<std::int32_t>(at, value);
  case Field::UINT32:
    return store<std::uint32_t>(at, value);
  case Field::FLOAT32:
    return store<float>(at, value);
  case Field::FLOAT64:
    return store<double>(at, value);
  case kInt64:
    return store<std::int64_t>(at, value);
  case kUint64:
    return store<std::uint64_t>(at, value);
  default:
    return;
  }
}

std::uint32_t
packRgb(std::uint32_t red, std::uint32_t green, std::uint32_t blue)
{
  return red << 16 | green << 8 | blue;
}

pcl::PCLPointCloud2
tableFromColumns(const std::vector<std::string>& names, const std::vector<double>& values)
{
  const std::size_t columns = names.size();
  const std::size_t rows = values.size() / columns;
  struct Target {
    std::size_t column;
    std::size_t offset;
    std::uint8_t datatype;
  };
  std::vector<Target> targets;
  pcl::PCLPointCloud2 table;
  const auto add = [&](std::size_t column, std::uint8_t datatype) {
    targets.push_back({column, table.point_step, datatype});
    addField(table, names[column], datatype);
  };

  const std::array<std::size_t, 3> xyz{{columnOf(names, "x"), columnOf(names, "y"), columnOf(names, "z")}};
  double extent = 0;
  for (const std::size_t column : xyz)
    extent = std::max(extent, largestMagnitude(values, column, columns));
  for (const std::size_t column : xyz)
    add(column, extent > kLargeCoordinate ? Field::FLOAT64 : Field::FLOAT32);

  const std::array<std::size_t, 3> rgb{{columnOf(names, "red"), columnOf(names, "green"), columnOf(names, "blue")}};
  const bool has_rgb = *std::max_element(rgb.begin(), rgb.end()) < columns;
  for (std::size_t column = 0; column < columns; ++column) {
    const bool done = std::find(xyz.begin(), xyz.end(), column) != xyz.end() ||
                      (has_rgb && std::find(rgb.begin(), rgb.end(), column) != rgb.end());
    if (!done)
      add(column, largestMagnitude(values, column, columns) > kFloatExact ? Field::FLOAT64 : Field::FLOAT32);
  }
  const std::size_t rgb_offset = table.point_step;
  if (has_rgb)
    addField(table, "rgb", Field::FLOAT32);

  resizeTable(table, rows);
  for (std::size_t row = 0; row < rows; ++row) {
    std::uint8_t* point = table.data.data() + row * table.point_step;
    const double* source = values.data() + row * columns;
    for (const Target& target : targets)
      storeValue(point + target.offset, target.datatype, source[target.column]);
    if (has_rgb) {
      const std::uint32_t packed = packRgb(colour(source[rgb[0]]), colour(source[rgb[1]]), colour(source[rgb[2]]));
      std::memcpy(point + rgb_offset, &packed, sizeof(packed));
    }
  }
  return table;
}

std::string
canonicalName(std::string_view name)
{
  static constexpr std::string_view kEdges = " \t\"'/#%";
  const std::size_t begin = std::min(name.find_first_not_of(kEdges), name.size());
  name.remove_prefix(begin);
  name = name.substr(0, name.find_first_of("[("));
  while (!name.empty() && kEdges.find(name.back()) != std::string_view::npos)
    name.remove_suffix(1);
  std::string result;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    result += std::isalnum(byte) != 0 ? static_cast<char>(std::tolower(byte)) : '_';
  }
  static constexpr const char* kScalar = "scalar_"; // prefix of CloudCompare's PLY properties
  if (result.rfind(kScalar, 0) == 0)
    result.erase(0, std::strlen(kScalar));

  struct Alias {
    std::string_view from;
    const char* to;
  };
  static constexpr Alias kAliases[] = {{"i", "intensity"},
                                       {"intensities", "intensity"},
                                       {"reflectance", "intensity"},
                                       {"reflectivity", "intensity"},
                                       {"remission", "intensity"},
                                       {"nx", "normal_x"},
                                       {"ny", "normal_y"},
                                       {"nz", "normal_z"},
                                       {"normals_x", "normal_x"},
                                       {"normals_y", "normal_y"},
                                       {"normals_z", "normal_z"},
                                       {"r", "red"},
                                       {"g", "green"},
                                       {"b", "blue"},
                                       {"diffuse_red", "red"},
                                       {"diffuse_green", "green"},
                                       {"diffuse_blue", "blue"},
                                       {"points_0", "x"},
                                       {"points_1", "y"},
                                       {"points_2", "z"}};
  for (const Alias& alias : kAliases)
    if (result == alias.from)
      return alias.to;
  return result.empty() ? "unnamed" : result;
}

} // namespace io
} // namespace pcl_ssfr
