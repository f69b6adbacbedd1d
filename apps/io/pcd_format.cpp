// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/pcd_format.h>

#include <apps/io/text_scanner.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <locale>
#include <set>
#include <sstream>
#include <string_view>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

constexpr std::size_t kMaxPointStep = 1U << 20; ///< longest point that we believe in [bytes]

struct PcdField {
  std::string name;
  std::size_t size = 4;
  char type = 'F';
  std::size_t count = 1;
  std::uint8_t datatype = 0;
  std::size_t file_offset = 0;        ///< within a point of the file [bytes]
  const Field* table_field = nullptr; ///< null: padding

  std::size_t
  bytes() const
  {
    return size * count;
  }
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::size_t point_step = 0; ///< of the file, padding included [bytes]
  std::size_t values = 0;     ///< numbers a point, padding included
  std::size_t points = 0;
  std::optional<Eigen::Vector3d> viewpoint;
  std::string encoding;
};

std::uint8_t
pcdDatatype(char type, std::size_t size)
{
  const std::string key = type + std::to_string(size);
  if (key == "F4")
    return Field::FLOAT32;
  if (key == "F8")
    return Field::FLOAT64;
  if (key == "I1")
    return Field::INT8;
  if (key == "I2")
    return Field::INT16;
  if (key == "I4")
    return Field::INT32;
  if (key == "U1")
    return Field::UINT8;
  if (key == "U2")
    return Field::UINT16;
  if (key == "U4")
    return Field::UINT32;
  if (key == "I8")
    return kInt64;
  if (key == "U8")
    return kUint64;
  return 0;
}

/// The unsigned numbers of one header line, as many as there are fields.
std::vector<std::size_t>
headerCounts(const TextScanner& scanner, const std::vector<std::string_view>& tokens, std::size_t expected)
{
  if (tokens.size() != expected + 1)
    throw scanner.error(std::string(tokens[0]) + " has " + std::to_string(tokens.size() - 1) + " values, expected " +
                        std::to_string(expected));
  std::vector<std::size_t> counts;
  for (std::size_t i = 1; i < tokens.size(); ++i) {
    const auto count = parseCount(tokens[i]);
    if (!count)
      throw scanner.error(std::string(tokens[0]) + ": " + inQuotes(tokens[i]) + " is not a count");
    counts.push_back(static_cast<std::size_t>(*count));
  }
  return counts;
}

PcdHeader
readHeader(TextScanner& scanner)
{
  PcdHeader header;
  std::optional<std::size_t> width;
  std::optional<std::size_t> height;
  std::optional<std::size_t> points;
  while (header.encoding.empty()) {
    if (!scanner.nextData())
      throw scanner.error("the PCD header ends before its DATA line");
    const auto tokens = splitTokens(scanner.line());
    const std::string_view key = tokens[0];
    if (key == "VERSION")
      continue;
    if (key == "FIELDS" || key == "COLUMNS") {
      if (tokens.size() > kMaxFields + 1)
        throw scanner.error("a point of more than " + std::to_string(kMaxFields) + " fields");
      header.fields.clear();
      for (std::size_t i = 1; i < tokens.size(); ++i) {
        header.fields.emplace_back();
        header.fields.back().name = std::string(tokens[i]);
      }
    }
    else if (key == "SIZE") {
      const auto counts = headerCounts(scanner, tokens, header.fields.size());
      for (std::size_t i = 0; i < counts.size(); ++i)
        header.fields[i].size = counts[i];
    }
    else if (key == "TYPE") {
      if (tokens.size() != header.fields.size() + 1)
        throw scanner.error("TYPE has " + std::to_string(tokens.size() - 1) + " values, expected " +
                            std::to_string(header.fields.size()));
      for (std::size_t i = 0; i < header.fields.size(); ++i)
        header.fields[i].type = tokens[i + 1].size() == 1 ? tokens[i + 1][0] : '?';
    }
    else if (key == "COUNT") {
      const auto counts = headerCounts(scanner, tokens, header.fields.size());
      for (std::size_t i = 0; i < counts.size(); ++i)
        header.fields[i].count = counts[i];
    }
    else if (key == "WIDTH") {
      width = headerCounts(scanner, tokens, 1)[0];
    }
    else if (key == "HEIGHT") {
      height = headerCounts(scanner, tokens, 1)[0];
    }
    else if (key == "POINTS") {
      points = headerCounts(scanner, tokens, 1)[0];
    }
    else if (key == "VIEWPOINT") {
      std::vector<double> pose;
      for (std::size_t i = 1; i < tokens.size(); ++i) {
        const auto value = parseNumber(tokens[i]);
        if (!value)
          throw scanner.error("VIEWPOINT: " + inQuotes(tokens[i]) + " is not a number");
        pose.push_back(*value);
      }
      if (pose.size() != 7)
        throw scanner.error("VIEWPOINT has " + std::to_string(pose.size()) + " values, expected 7");
      const Eigen::Vector3d position(pose[0], pose[1], pose[2]);
      if (position.allFinite() && !position.isZero(0))
        header.viewpoint = position;
    }
    else if (key == "DATA") {
      header.encoding = tokens.size() == 2 ? std::string(tokens[1]) : "";
      if (header.encoding != "ascii" && header.encoding != "binary" && header.encoding != "binary_compressed")
        throw scanner.error("DATA: " + inQuotes(header.encoding) + " is not ascii, binary or binary_compressed");
    }
    else {
      throw scanner.error(inQuotes(key) + " is not a line of a PCD header");
    }
  }
  if (header.fields.empty())
    throw scanner.error("the PCD header has no FIELDS line");
  if (!points && !width)
    throw scanner.error("the PCD header has neither POINTS nor WIDTH");
  const std::size_t rows = height.value_or(1);
  if (width && rows > 0 && *width > std::numeric_limits<std::size_t>::max() / rows)
    throw scanner.error("WIDTH times HEIGHT is too large");
  header.points = points.value_or(width.value_or(0) * rows);
  if (points && width && *width * rows != *points)
    throw scanner.error("POINTS " + std::to_string(*points) + " is not WIDTH " + std::to_string(*width) +
                        " times HEIGHT " + std::to_string(rows));
  for (PcdField& field : header.fields) {
    field.datatype = pcdDatatype(field.type, field.size);
    const bool padding = field.name == "_";
    if (!padding && field.datatype == 0)
      throw scanner.error("field " + inQuotes(field.name) + " has TYPE " + field.type + " and SIZE " +
                          std::to_string(field.size) + ", which is not supported");
    if (field.count > kMaxPointStep || field.size > kMaxPointStep || (field.size == 0 && field.count > 0))
      throw scanner.error("field " + inQuotes(field.name) + " has SIZE " + std::to_string(field.size) + " and COUNT " +
                          std::to_string(field.count));
    field.file_offset = header.point_step;
    header.point_step += field.bytes();
    header.values += field.count;
    if (header.point_step > kMaxPointStep)
      throw scanner.error("a point of more than " + std::to_string(kMaxPointStep) + " bytes");
  }
  return header;
}

/// The table's layout: the fields of the file that are kept, without padding.
pcl::PCLPointCloud2
makeLayout(PcdHeader& header, const TextScanner& scanner, FieldChoice fields)
{
  const auto isLeftOut = [fields](const PcdField& field) {
    return field.name == "_" || field.count == 0 || !isKept(fields, field.name);
  };
  pcl::PCLPointCloud2 table;
  std::set<std::string> names;
  for (const PcdField& field : header.fields) {
    if (field.name != "_" && field.count > 0 && !names.insert(field.name).second)
      throw scanner.error("field " + inQuotes(field.name) + " occurs twice");
    if (!isLeftOut(field))
      addField(table, field.name, field.datatype, static_cast<std::uint32_t>(field.count));
  }
  if (!findVector(table, "x", "y", "z"))
    throw scanner.error("fields x, y and z of TYPE F are needed");
  for (PcdField& field : header.fields)
    field.table_field = isLeftOut(field) ? nullptr : findField(table, field.name);
  return table;
}

void
checkSize(const TextScanner& scanner, std::size_t points, std::size_t bytes_each, std::size_t available)
{
  if (points > std::numeric_limits<std::int32_t>::max() || (points > 0 && bytes_each > available / points))
    throw scanner.error("POINTS " + std::to_string(points) + " of " + std::to_string(bytes_each) +
                        " bytes do not fit into the " + std::to_string(available) + " bytes that follow");
}

void
readAscii(TextScanner& scanner, const PcdHeader& header, pcl::PCLPointCloud2& table)
{
  // Every number takes a byte and a separator; the last line may lack its end.
  checkSize(scanner, header.points, 2 * header.values, static_cast<std::size_t>(scanner.left()) + 1);
  resizeTable(table, header.points);
  std::vector<double> values;
  for (std::size_t i = 0; i < header.points; ++i) {
    if (!scanner.nextData())
      throw scanner.error("the file ends after " + std::to_string(i) + " of " + std::to_string(header.points) +
                          " points");
    values.clear();
    if (scanner.appendNumbers(values) != header.values)
      throw scanner.error(std::to_string(values.size()) + " values, expected " + std::to_string(header.values));
    std::uint8_t* point = table.data.data() + i * table.point_step;
    const double* value = values.data();
    for (const PcdField& field : header.fields) {
      if (field.table_field)
        for (std::size_t k = 0; k < field.count; ++k)
          storeValue(point + field.table_field->offset + k * field.size, field.datatype, value[k]);
      value += field.count;
    }
  }
}

/// Points as they are in the file, from byte \p data_at on.
void
readBinary(const TextScanner& scanner,
           const PcdHeader& header,
           const ByteSource& source,
           std::uint64_t data_at,
           pcl::PCLPointCloud2& table)
{
  checkSize(scanner, header.points, header.point_step, static_cast<std::size_t>(source.size() - data_at));
  resizeTable(table, header.points);
  // Fields that follow each other in the file as in the table are copied at once.
  struct Run {
    std::size_t from, to, bytes;
  };
  std::vector<Run> runs;
  for (const PcdField& field : header.fields) {
    if (!field.table_field)
      continue;
    if (!runs.empty() && runs.back().from + runs.back().bytes == field.file_offset &&
        runs.back().to + runs.back().bytes == field.table_field->offset)
      runs.back().bytes += field.bytes();
    else
      runs.push_back({field.file_offset, field.table_field->offset, field.bytes()});
  }
  const std::size_t in_block = std::max<std::size_t>(1, kBlockBytes / std::max<std::size_t>(1, header.point_step));
  std::string block;
  std::uint8_t* target = table.data.data();
  for (std::size_t i = 0; i < header.points; i += in_block) {
    block.resize(std::min(in_block, header.points - i) * header.point_step);
    source.read(data_at + std::uint64_t{i} * header.point_step, block.size(), block.data());
    for (std::size_t at = 0; at < block.size(); at += header.point_step, target += table.point_step)
      for (const Run& run : runs)
        std::memcpy(target + run.to, block.data() + at + run.from, run.bytes);
  }
}

/** \brief Undo LZF compression: a control byte below 32 starts a run of literals, any other a copy from what was
 * already written. False when \p packed does not give exactly the length of \p out.
 */
bool
decompressLzf(std::string_view packed, std::string& out)
{
  std::size_t in = 0;
  std::size_t at = 0;
  while (in < packed.size()) {
    const std::size_t control = static_cast<unsigned char>(packed[in++]);
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > packed.size() - in || length > out.size() - at)
        return false;
      std::memcpy(out.data() + at, packed.data() + in, length);
      in += length;
      at += length;
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    if (length == 9) {
      if (in >= packed.size())
        return false;
      length += static_cast<unsigned char>(packed[in++]);
    }
    if (in >= packed.size())
      return false;
    const std::size_t back = ((control & 31U) << 8 | static_cast<unsigned char>(packed[in++])) + 1;
    if (back > at || length > out.size() - at)
      return false;
    for (std::size_t i = 0; i < length; ++i, ++at) // may overlap itself: byte by byte
      out[at] = out[at - back];
  }
  return at == out.size();
}

void
readCompressed(const TextScanner& scanner, const PcdHeader& header, pcl::PCLPointCloud2& table)
{
  constexpr std::size_t kSizes = 2 * sizeof(std::uint32_t);
  constexpr std::size_t kMaxRatio = 88; // LZF: 3 bytes give at most 264
  const std::string_view rest = scanner.rest();
  if (header.points == 0)
    return resizeTable(table, 0);
  if (rest.size() < kSizes)
    throw scanner.error("the file ends before the sizes of its compressed data");
  const std::size_t packed = valueAt<std::uint32_t>(rest, 0);
  const std::size_t unpacked = valueAt<std::uint32_t>(rest, sizeof(std::uint32_t));
  if (packed > rest.size() - kSizes)
    throw scanner.error("compressed data of " + std::to_string(packed) + " bytes do not fit into the " +
                        std::to_string(rest.size() - kSizes) + " bytes that follow");
  if (unpacked / kMaxRatio > packed || header.points > unpacked || header.points * header.point_step != unpacked)
    throw scanner.error("compressed data give " + std::to_string(unpacked) + " bytes, POINTS " +
                        std::to_string(header.points) + " need " + std::to_string(header.point_step) + " each");
  std::string data(unpacked, '\0');
  if (!decompressLzf(rest.substr(kSizes, packed), data))
    throw scanner.error("the compressed data are damaged");
  resizeTable(table, header.points);
  // Structure of arrays: all values of one field, then those of the next.
  const char* source = data.data();
  for (const PcdField& field : header.fields) {
    if (field.table_field)
      for (std::size_t i = 0; i < header.points; ++i)
        std::memcpy(table.data.data() + i * table.point_step + field.table_field->offset,
                    source + i * field.bytes(),
                    field.bytes());
    source += header.points * field.bytes();
  }
}

char
pcdType(std::uint8_t datatype)
{
  switch (datatype) {
  case Field::FLOAT32:
  case Field::FLOAT64:
    return 'F';
  case Field::UINT8:
  case Field::UINT16:
  case Field::UINT32:
  case kUint64:
    return 'U';
  default:
    return 'I';
  }
}

/// The first lines of a file that is written.
std::string
beginningOf(std::string_view comment)
{
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\n";
  if (!comment.empty())
    text.append("# ").append(comment).append("\n");
  return text;
}

} // namespace

RawCloud
readPcd(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  const std::string head = headOf(source, path, [](TextScanner& lines) { readHeader(lines); });
  TextScanner scanner(head, path);
  PcdHeader header = readHeader(scanner);
  RawCloud cloud;
  cloud.viewpoint = header.viewpoint;
  cloud.table = makeLayout(header, scanner, fields);
  if (header.encoding == "binary") {
    readBinary(scanner, header, source, head.size() - scanner.rest().size(), cloud.table);
    return cloud;
  }
  if (header.encoding == "ascii") {
    TextScanner body(source, path);
    readHeader(body);
    readAscii(body, header, cloud.table);
    return cloud;
  }
  const std::string bytes = source.first(source.size()); // decompression needs all of it
  TextScanner body(bytes, path);
  readHeader(body);
  readCompressed(body, header, cloud.table);
  return cloud;
}

void
writePcd(const std::string& path,
         const pcl::PCLPointCloud2& table,
         const Eigen::Isometry3d& sensor,
         std::string_view comment)
{
  std::ostringstream names;
  std::ostringstream sizes;
  std::ostringstream types;
  std::ostringstream counts;
  for (auto* stream : {&names, &sizes, &types, &counts})
    stream->imbue(std::locale::classic());
  for (const Field& field : table.fields) {
    names << ' ' << field.name;
    sizes << ' ' << valueSize(field.datatype);
    types << ' ' << pcdType(field.datatype);
    counts << ' ' << field.count;
  }
  const std::size_t points = pointCount(table);
  const Eigen::Vector3d t = sensor.translation();
  const Eigen::Quaterniond q(sensor.linear());
  std::ostringstream header;
  header.imbue(std::locale::classic());
  header << std::setprecision(15);
  header << beginningOf(comment) << "VERSION 0.7\nFIELDS" << names.str() << "\nSIZE" << sizes.str() << "\nTYPE"
         << types.str() << "\nCOUNT" << counts.str() << "\nWIDTH " << points << "\nHEIGHT 1\nVIEWPOINT " << t.x() << ' '
         << t.y() << ' ' << t.z() << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "\nPOINTS "
         << points << "\nDATA binary\n";
  writeFile(path,
            {header.str(), std::string_view(reinterpret_cast<const char*>(table.data.data()), table.data.size())});
}

bool
isPcdWithComment(const std::string& path, std::string_view comment)
{
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return false;
  const std::string beginning = beginningOf(comment);
  return FileBytes(path).first(beginning.size()) == beginning;
}

} // namespace io
} // namespace pcl_ssfr
