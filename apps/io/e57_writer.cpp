// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_writer.h>

#include <apps/io/e57_records.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>
#include <vector>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

constexpr std::size_t kPacketBytes = 60000;   ///< of the streams of a packet, which has 2^16 with its header
constexpr std::size_t kPacketAlignment = 4;   ///< of the length of a packet [bytes]
constexpr std::size_t kIndexPacketBytes = 32; ///< with one entry
constexpr const char* kNormalsUri = "http://www.libe57.org/E57_EXT_surface_normals.txt";

/// A field of the file: where its values come from and how it is described.
struct Column {
  const char* name;
  const Field* field; ///< of the table, null for coordinates and colours
  std::size_t bytes;  ///< of a stored value
  std::string type;   ///< attributes
};

/// Fields of the table besides coordinates and colour, and what they are in the file.
struct Scalar {
  const char* ours;
  const char* name;
  std::size_t bytes;
  const char* type;
};
constexpr const char* kSingle = R"(type="Float" precision="single")";
constexpr const char* kDouble = R"(type="Float")";
constexpr const char* kByte = R"(type="Integer" minimum="0" maximum="255")";
constexpr const char* kInt32 = R"(type="Integer" minimum="-2147483648" maximum="2147483647")";
constexpr Scalar kScalars[] = {{"intensity", "intensity", sizeof(float), kSingle},
                               {"normal_x", "nor:normalX", sizeof(float), kSingle},
                               {"normal_y", "nor:normalY", sizeof(float), kSingle},
                               {"normal_z", "nor:normalZ", sizeof(float), kSingle},
                               {"time", "timeStamp", sizeof(double), kDouble},
                               {"row", "rowIndex", sizeof(std::int32_t), kInt32},
                               {"column", "columnIndex", sizeof(std::int32_t), kInt32},
                               {"return_index", "returnIndex", 1, kByte},
                               {"return_count", "returnCount", 1, kByte}};

template <typename T>
void
append(std::string& bytes, T value)
{
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// True for UTF-8 as Unicode has it, overlong forms and surrogates aside.
bool
isUtf8(std::string_view text)
{
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t more = lead < 0x80   ? 0
                             : lead < 0xC2 ? 4
                             : lead < 0xE0 ? 1
                             : lead < 0xF0 ? 2
                             : lead < 0xF5 ? 3
                                           : 4;
    if (more >= text.size() - i)
      return false;
    std::uint32_t code = lead & (0x7FU >> more);
    for (std::size_t k = 0; k < more; ++k) {
      const auto byte = static_cast<unsigned char>(text[++i]);
      if ((byte & 0xC0U) != 0x80)
        return false;
      code = code << 6 | (byte & 0x3FU);
    }
    if ((more == 2 && code < 0x800) || (more == 3 && (code < 0x10000 || code > 0x10FFFF)) ||
        (code >= 0xD800 && code < 0xE000) || code == 0xFFFE || code == 0xFFFF)
      return false;
  }
  return true;
}

/// \p text between tags: what XML cannot hold becomes '?'.
std::string
toXml(const std::string& text)
{
  const bool utf8 = isUtf8(text);
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += byte < ' ' || byte == 0x7F || (byte >= 0x80 && !utf8) ? '?' : c;
  }
  return result;
}

std::string
element(const char* name, const char* type, const std::string& value)
{
  return std::string("<") + name + " type=\"" + type + "\">" + value + "</" + name + ">\n";
}

std::string
number(double value)
{
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(std::numeric_limits<double>::max_digits10) << value;
  return text.str();
}

std::string
vectorXml(const char* name, const Eigen::Vector3d& vector)
{
  std::string xml = std::string("<") + name + " type=\"Structure\">\n";
  const char* const axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    xml += element(axes[k], "Float", number(vector[k]));
  return xml + "</" + name + ">\n";
}

std::string
poseXml(const Eigen::Isometry3d& pose)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.linear()).normalized();
  std::string xml = "<pose type=\"Structure\">\n" + vectorXml("rotation", q.vec());
  xml.insert(xml.find("<x "), element("w", "Float", number(q.w())));
  return xml + vectorXml("translation", pose.translation()) + "</pose>\n";
}

/// Least and greatest of what was seen.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void
  add(double value)
  {
    low = std::min(low, value); // NaN changes nothing
    high = std::max(high, value);
  }
};

/// Writes the points of one scan as a section, and describes them.
class SectionWriter {
public:
  SectionWriter(E57PageWriter& pages, const LoadedCloud& cloud);

  void
  write();
  /// The elements after guid, name and pose.
  std::string
  xml() const;
  /// A checksum of everything that was written.
  std::uint32_t
  checksum() const
  {
    return checksum_;
  }

private:
  void
  add(std::size_t i);
  void
  flush();

  E57PageWriter& pages_;
  const pcl::PCLPointCloud2& table_;
  std::array<const Field*, 3> xyz_;
  Eigen::Vector3d sensor_;
  bool as_double_ = false; ///< coordinates
  const Field* rgb_ = nullptr;
  const Field* intensity_ = nullptr;
  std::vector<Column> columns_;
  std::size_t record_bytes_ = 0;
  std::size_t waiting_ = 0; ///< records in streams_
  std::vector<std::string> streams_;
  std::uint64_t start_ = 0; ///< of the section, logical
  std::uint64_t records_ = 0;
  std::uint32_t checksum_ = 0;
  std::array<Range, 3> bounds_;
  Range intensities_;
};

SectionWriter::SectionWriter(E57PageWriter& pages, const LoadedCloud& cloud)
    : pages_(pages), table_(cloud.table), xyz_(*findVector(cloud.table, "x", "y", "z")),
      sensor_(cloud.viewpoint.value_or(Eigen::Vector3d::Zero()))
{
  for (const Field* field : xyz_)
    as_double_ = as_double_ || field->datatype == Field::FLOAT64;
  for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
    columns_.push_back({name, nullptr, as_double_ ? sizeof(double) : sizeof(float), as_double_ ? kDouble : kSingle});
  for (const Scalar& scalar : kScalars)
    if (const Field* field = findField(table_, scalar.ours); field && field->count == 1)
      columns_.push_back({scalar.name, field, scalar.bytes, scalar.type});
  intensity_ = findField(table_, "intensity");
  for (const char* name : {"rgb", "rgba"})
    if (const Field* field = findField(table_, name);
        field && !rgb_ && field->count == 1 && valueSize(field->datatype) == 4)
      rgb_ = field;
  if (rgb_)
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
      columns_.push_back({name, nullptr, 1, kByte});
  for (const Column& column : columns_)
    record_bytes_ += column.bytes;
  streams_.resize(columns_.size());
}

void
SectionWriter::add(std::size_t i)
{
  const std::uint8_t* point = table_.data.data() + i * table_.point_step;
  std::array<double, 3> position{};
  for (std::size_t k = 0; k < 3; ++k) {
    position[k] = loadValue(point + xyz_[k]->offset, xyz_[k]->datatype) - sensor_[static_cast<Eigen::Index>(k)];
    if (!std::isfinite(position[k]) || (!as_double_ && !std::isfinite(static_cast<float>(position[k]))))
      return;
  }
  std::uint32_t packed = 0;
  if (rgb_)
    std::memcpy(&packed, point + rgb_->offset, sizeof(packed));
  unsigned color_shift = 16;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const Column& column = columns_[c];
    std::string& stream = streams_[c];
    if (c < 3 && as_double_)
      append(stream, position[c]);
    else if (c < 3)
      append(stream, static_cast<float>(position[c]));
    else if (!column.field) {
      append(stream, static_cast<std::uint8_t>(packed >> color_shift & 255U));
      color_shift -= 8;
    }
    else {
      const double value = loadValue(point + column.field->offset, column.field->datatype);
      std::array<std::uint8_t, sizeof(double)> bytes{};
      // Integers are stored as what they are above the least one.
      if (column.type == kInt32)
        storeValue(bytes.data(), Field::UINT32, value - std::numeric_limits<std::int32_t>::min());
      else
        storeValue(bytes.data(),
                   column.bytes == 1               ? Field::UINT8
                   : column.bytes == sizeof(float) ? Field::FLOAT32
                                                   : Field::FLOAT64,
                   value);
      stream.append(reinterpret_cast<const char*>(bytes.data()), column.bytes);
      if (column.field == intensity_)
        intensities_.add(value);
    }
  }
  for (std::size_t k = 0; k < 3; ++k)
    bounds_[k].add(position[k]);
  ++records_;
  if (++waiting_ == kPacketBytes / record_bytes_)
    flush();
}

void
SectionWriter::flush()
{
  if (waiting_ == 0)
    return;
  std::string packet(kE57PacketHeaderBytes, '\0');
  packet[0] = static_cast<char>(kE57DataPacket);
  append(packet, static_cast<std::uint16_t>(streams_.size()));
  for (const std::string& stream : streams_)
    append(packet, static_cast<std::uint16_t>(stream.size()));
  for (std::string& stream : streams_) {
    packet += stream;
    stream.clear();
  }
  packet.resize((packet.size() + kPacketAlignment - 1) / kPacketAlignment * kPacketAlignment);
  const auto length = static_cast<std::uint16_t>(packet.size() - 1);
  std::memcpy(packet.data() + 2, &length, sizeof(length));
  pages_.append(packet);
  checksum_ ^= crc32c(packet) + checksum_ * 31;
  waiting_ = 0;
}

void
SectionWriter::write()
{
  pages_.align();
  start_ = pages_.position();
  pages_.append(std::string(kE57SectionHeaderBytes, '\0'));
  const std::uint64_t data_at = E57PageWriter::toPhysical(pages_.position());
  for (std::size_t i = 0; i < pointCount(table_); ++i)
    add(i);
  flush();
  std::string header(8, '\0');
  header[0] = static_cast<char>(kE57RecordSection);
  std::uint64_t index_at = 0;
  if (records_ > 0) {
    // An index of one entry: record 0 is in the first packet.
    index_at = E57PageWriter::toPhysical(pages_.position());
    std::string index(kE57PacketHeaderBytes, '\0');
    index[2] = static_cast<char>(kIndexPacketBytes - 1);
    append(index, std::uint16_t{1});
    index.resize(kIndexPacketBytes - sizeof(data_at), '\0');
    append(index, data_at);
    pages_.append(index);
  }
  append(header, pages_.position() - start_);
  append(header, records_ > 0 ? data_at : 0);
  append(header, index_at);
  pages_.patch(start_, header);
}

std::string
SectionWriter::xml() const
{
  std::string xml;
  if (records_ > 0) {
    xml += "<cartesianBounds type=\"Structure\">\n";
    const char* const names[3][2] = {{"xMinimum", "xMaximum"}, {"yMinimum", "yMaximum"}, {"zMinimum", "zMaximum"}};
    for (std::size_t k = 0; k < 3; ++k)
      xml += element(names[k][0], "Float", number(bounds_[k].low)) +
             element(names[k][1], "Float", number(bounds_[k].high));
    xml += "</cartesianBounds>\n";
  }
  if (std::isfinite(intensities_.low) && std::isfinite(intensities_.high))
    xml += "<intensityLimits type=\"Structure\">\n" + element("intensityMinimum", "Float", number(intensities_.low)) +
           element("intensityMaximum", "Float", number(intensities_.high)) + "</intensityLimits>\n";
  if (rgb_) {
    xml += "<colorLimits type=\"Structure\">\n";
    for (const std::string color : {"colorRed", "colorGreen", "colorBlue"})
      xml +=
          element((color + "Minimum").c_str(), "Integer", "0") + element((color + "Maximum").c_str(), "Integer", "255");
    xml += "</colorLimits>\n";
  }
  xml += "<points type=\"CompressedVector\" fileOffset=\"" + std::to_string(E57PageWriter::toPhysical(start_)) +
         "\" recordCount=\"" + std::to_string(records_) + "\">\n<prototype type=\"Structure\">\n";
  for (const Column& column : columns_)
    xml += std::string("<") + column.name + ' ' + column.type + "/>\n";
  return xml + "</prototype>\n<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\">\n</codecs>\n</points>\n";
}

/// Text in the form of a GUID that depends on nothing but \p text.
std::string
guidOf(const std::string& text)
{
  std::ostringstream guid;
  guid.imbue(std::locale::classic());
  guid << std::hex << std::uppercase << std::setfill('0') << '{';
  std::string part = text;
  for (int k = 0; k < 4; ++k) {
    part += '#';
    const std::uint32_t hash = crc32c(part);
    if (k == 0 || k == 3)
      guid << std::setw(8) << hash;
    else
      guid << '-' << std::setw(4) << (hash >> 16) << '-' << std::setw(4) << (hash & 0xFFFFU);
  }
  guid << '}';
  return guid.str();
}

} // namespace

E57Writer::E57Writer(const std::string& path) : path_(path), pages_(path)
{}

void
E57Writer::addScan(const std::string& name, const LoadedCloud& cloud, const Eigen::Isometry3d& T_map_scan)
{
  const Eigen::Isometry3d pose = T_map_scan * Eigen::Translation3d(cloud.viewpoint.value_or(Eigen::Vector3d::Zero()));
  if (!pose.matrix().allFinite())
    throw IoError(path_ + ": the pose of scan " + inQuotes(name) + " is not finite");
  if (!findVector(cloud.table, "x", "y", "z"))
    throw IoError(path_ + ": scan " + inQuotes(name) + " has no table with x, y and z");
  SectionWriter section(pages_, cloud);
  section.write();
  ++count_;
  const std::string guid = guidOf(name + '#' + std::to_string(count_) + '#' + std::to_string(section.checksum()));
  scans_ += "<vectorChild type=\"Structure\">\n" + element("guid", "String", guid) +
            element("name", "String", toXml(name)) + poseXml(pose) + section.xml() + "</vectorChild>\n";
}

void
E57Writer::finish()
{
  const std::string xml = std::string(R"(<?xml version="1.0" encoding="UTF-8"?>
<e57Root type="Structure" xmlns="http://www.astm.org/COMMIT/E57/2010-e57-v1.0" xmlns:nor=")") +
                          kNormalsUri + "\">\n" + element("formatName", "String", "ASTM E57 3D Imaging Data File") +
                          element("guid", "String", guidOf(scans_)) + element("versionMajor", "Integer", "1") +
                          element("versionMinor", "Integer", "0") +
                          "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n" + scans_ +
                          "</data3D>\n<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n</images2D>\n"
                          "</e57Root>\n";
  pages_.finish(xml);
}

} // namespace io
} // namespace pcl_ssfr
