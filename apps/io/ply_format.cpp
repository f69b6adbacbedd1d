// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/ply_format.h>

#include <apps/io/file_bytes.h>
#include <apps/io/text_scanner.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;

enum class Encoding { Ascii, LittleEndian, BigEndian };

struct Property {
  std::string name;
  std::uint8_t datatype = 0;      ///< of the value, or of the items of a list
  std::uint8_t list_datatype = 0; ///< of the length of a list; 0: a single value
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;

  bool
  hasList() const
  {
    return std::any_of(properties.begin(), properties.end(), [](const Property& p) { return p.list_datatype != 0; });
  }
  /// Bytes of one element without lists in a binary file.
  std::size_t
  step() const
  {
    std::size_t bytes = 0;
    for (const Property& property : properties)
      bytes += valueSize(property.datatype);
    return bytes;
  }
};

struct PlyHeader {
  Encoding encoding = Encoding::Ascii;
  std::vector<Element> elements;
};

std::uint8_t
plyDatatype(std::string_view name)
{
  struct Entry {
    std::string_view name;
    std::uint8_t datatype;
  };
  static constexpr Entry kTypes[] = {{"char", Field::INT8},
                                     {"int8", Field::INT8},
                                     {"uchar", Field::UINT8},
                                     {"uint8", Field::UINT8},
                                     {"short", Field::INT16},
                                     {"int16", Field::INT16},
                                     {"ushort", Field::UINT16},
                                     {"uint16", Field::UINT16},
                                     {"int", Field::INT32},
                                     {"int32", Field::INT32},
                                     {"uint", Field::UINT32},
                                     {"uint32", Field::UINT32},
                                     {"float", Field::FLOAT32},
                                     {"float32", Field::FLOAT32},
                                     {"double", Field::FLOAT64},
                                     {"float64", Field::FLOAT64}};
  for (const Entry& entry : kTypes)
    if (entry.name == name)
      return entry.datatype;
  return 0;
}

const char*
plyName(std::uint8_t datatype)
{
  static constexpr const char* kNames[] = {
      "", "char", "uchar", "short", "ushort", "int", "uint", "float", "double"}; // in the order of PCLPointField
  return datatype < std::size(kNames) ? kNames[datatype] : "double";             // PLY has no 64-bit integers
}

Property
readProperty(const TextScanner& scanner, const std::vector<std::string_view>& tokens)
{
  Property property;
  const bool is_list = tokens.size() == 5 && tokens[1] == "list";
  if (!is_list && tokens.size() != 3)
    throw scanner.error("not a property: " + inQuotes(scanner.line()));
  property.name = canonicalName(tokens.back());
  property.datatype = plyDatatype(tokens[tokens.size() - 2]);
  if (property.datatype == 0)
    throw scanner.error("property " + inQuotes(tokens.back()) + " has unknown type " +
                        inQuotes(tokens[tokens.size() - 2]));
  if (is_list) {
    property.list_datatype = plyDatatype(tokens[2]);
    if (property.list_datatype == 0 || property.list_datatype >= Field::FLOAT32)
      throw scanner.error("list " + inQuotes(tokens.back()) + " has a length of type " + inQuotes(tokens[2]));
  }
  return property;
}

PlyHeader
readHeader(TextScanner& scanner)
{
  PlyHeader header;
  if (!scanner.next() || scanner.line() != "ply")
    throw scanner.error("not a PLY file: it starts with " + inQuotes(scanner.line()));
  bool has_format = false;
  while (true) {
    if (!scanner.next())
      throw scanner.error("the PLY header ends before its end_header line");
    const auto tokens = splitTokens(scanner.line());
    const std::string_view key = tokens.empty() ? std::string_view() : tokens[0];
    if (key == "end_header")
      break;
    if (key.empty() || key == "comment" || key == "obj_info")
      continue;
    if (key == "format" && tokens.size() >= 2) {
      if (tokens[1] == "ascii")
        header.encoding = Encoding::Ascii;
      else if (tokens[1] == "binary_little_endian")
        header.encoding = Encoding::LittleEndian;
      else if (tokens[1] == "binary_big_endian")
        header.encoding = Encoding::BigEndian;
      else
        throw scanner.error("unknown PLY format " + inQuotes(tokens[1]));
      has_format = true;
    }
    else if (key == "element" && tokens.size() == 3) {
      const auto count = parseCount(tokens[2]);
      if (!count)
        throw scanner.error("element " + inQuotes(tokens[1]) + ": " + inQuotes(tokens[2]) + " is not a count");
      header.elements.push_back({std::string(tokens[1]), static_cast<std::size_t>(*count), {}});
    }
    else if (key == "property" && !header.elements.empty()) {
      if (header.elements.back().properties.size() == kMaxFields)
        throw scanner.error("element " + inQuotes(header.elements.back().name) + " has more than " +
                            std::to_string(kMaxFields) + " properties");
      header.elements.back().properties.push_back(readProperty(scanner, tokens));
    }
    else {
      throw scanner.error("not a line of a PLY header: " + inQuotes(scanner.line()));
    }
  }
  if (!has_format)
    throw scanner.error("the PLY header has no format line");
  return header;
}

/// A single value of a binary file, in the byte order of this machine.
double
binaryValue(const char* at, std::uint8_t datatype, bool swap)
{
  std::uint8_t value[sizeof(double)];
  const std::size_t size = valueSize(datatype);
  std::memcpy(value, at, size);
  if (swap)
    std::reverse(value, value + size);
  return loadValue(value, datatype);
}

/// Rows of numbers, as the vertices of a file have them, and the table of those columns that are kept.
class VertexRows {
public:
  VertexRows(const Element& vertex, Encoding encoding, FieldChoice choice)
  {
    for (const Property& property : vertex.properties)
      names_.push_back(property.name);
    if (choice == FieldChoice::kAll)
      return;
    for (std::size_t column = 0; column < names_.size(); ++column)
      if (isKept(choice, names_[column])) {
        // Digits may say more than the type that is declared for them: coordinates on a map to the millimetre.
        const bool is_float = encoding != Encoding::Ascii && vertex.properties[column].datatype == Field::FLOAT32;
        addField(geometry_, names_[column], is_float ? Field::FLOAT32 : Field::FLOAT64);
        kept_.push_back(column);
      }
  }

  void
  reserve(std::size_t rows)
  {
    if (kept_.empty())
      values_.reserve(rows * names_.size());
    else
      resizeTable(geometry_, rows);
  }

  /// A number for each property.
  void
  add(const std::vector<double>& row)
  {
    if (kept_.empty()) {
      values_.insert(values_.end(), row.begin(), row.end());
      return;
    }
    std::uint8_t* point = geometry_.data.data() + added_++ * geometry_.point_step;
    for (std::size_t k = 0; k < kept_.size(); ++k)
      storeValue(point + geometry_.fields[k].offset, geometry_.fields[k].datatype, row[kept_[k]]);
  }

  pcl::PCLPointCloud2
  table() &&
  {
    return kept_.empty() ? tableFromColumns(names_, values_) : std::move(geometry_);
  }

private:
  std::vector<std::string> names_;
  std::vector<double> values_;    ///< of all columns, where all are kept
  std::vector<std::size_t> kept_; ///< else the columns that are
  pcl::PCLPointCloud2 geometry_;
  std::size_t added_ = 0;
};

/// Walks the binary body of a PLY file.
class BinaryBody {
public:
  BinaryBody(const TextScanner& scanner, const ByteSource& source, std::uint64_t at, bool swap)
      : scanner_(scanner), source_(source), at_(at), swap_(swap)
  {}

  void
  skip(const Element& element)
  {
    if (!element.hasList()) {
      require(element, element.step(), element.count);
      at_ += element.step() * element.count;
      return;
    }
    for (std::size_t i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) {
        std::size_t values = 1;
        if (property.list_datatype != 0) {
          require(element, valueSize(property.list_datatype), 1);
          const double length = binaryValue(take(valueSize(property.list_datatype)), property.list_datatype, swap_);
          if (length < 0)
            throw scanner_.error("element " + inQuotes(element.name) + " has a list of negative length");
          values = static_cast<std::size_t>(length);
        }
        require(element, valueSize(property.datatype), values);
        at_ += valueSize(property.datatype) * values;
      }
  }

  void
  append(const Element& element, VertexRows& rows)
  {
    require(element, element.step(), element.count);
    rows.reserve(element.count);
    std::vector<double> row(element.properties.size());
    for (std::size_t i = 0; i < element.count; ++i) {
      const char* value = take(element.step());
      for (std::size_t k = 0; k < row.size(); ++k) {
        row[k] = binaryValue(value, element.properties[k].datatype, swap_);
        value += valueSize(element.properties[k].datatype);
      }
      rows.add(row);
    }
  }

private:
  /// The next \p count bytes, which the caller has compared with what is left.
  const char*
  take(std::size_t count)
  {
    if (at_ < block_at_ || at_ + count > block_at_ + block_.size()) {
      block_at_ = at_;
      block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::max(count, kBlockBytes), left())));
      source_.read(block_at_, block_.size(), block_.data());
    }
    const char* bytes = block_.data() + (at_ - block_at_);
    at_ += count;
    return bytes;
  }
  std::uint64_t
  left() const
  {
    return source_.size() - at_;
  }
  void
  require(const Element& element, std::size_t bytes_each, std::size_t count) const
  {
    if (count > 0 && bytes_each > left() / count)
      throw scanner_.error("element " + inQuotes(element.name) + ": " + std::to_string(count) + " times " +
                           std::to_string(bytes_each) + " bytes do not fit into the " + std::to_string(left()) +
                           " bytes that are left");
  }

  const TextScanner& scanner_;
  const ByteSource& source_;
  std::uint64_t at_; ///< of the next byte in the file
  std::string block_;
  std::uint64_t block_at_ = 0;
  bool swap_;
};

void
appendAscii(TextScanner& scanner, const Element& element, VertexRows& rows)
{
  const std::size_t columns = element.properties.size();
  // Every number takes a byte and a separator; the last line may lack its end.
  if (element.count > 0 && 2 * columns > (scanner.left() + 1) / element.count)
    throw scanner.error("element " + inQuotes(element.name) + ": " + std::to_string(element.count) +
                        " lines do not fit into the " + std::to_string(scanner.left()) + " bytes that are left");
  rows.reserve(element.count);
  std::vector<double> row;
  for (std::size_t i = 0; i < element.count; ++i) {
    if (!scanner.nextData())
      throw scanner.error("the file ends after " + std::to_string(i) + " of " + std::to_string(element.count) + " " +
                          element.name + " lines");
    row.clear();
    const std::size_t got = scanner.appendNumbers(row);
    if (got != columns)
      throw scanner.error(std::to_string(got) + " values, expected " + std::to_string(columns));
    rows.add(row);
  }
}

/// The element of the vertices. \throw IoError where there is none, or its properties are not what we read
const Element&
requireVertex(const TextScanner& scanner, const PlyHeader& header)
{
  const auto vertex = std::find_if(
      header.elements.begin(), header.elements.end(), [](const Element& element) { return element.name == "vertex"; });
  if (vertex == header.elements.end())
    throw scanner.error("the PLY header has no element 'vertex'");
  std::vector<std::string> names;
  for (const Property& property : vertex->properties) {
    if (property.list_datatype != 0)
      throw scanner.error("element 'vertex' has a list " + inQuotes(property.name) + ", which is not supported");
    if (std::find(names.begin(), names.end(), property.name) != names.end())
      throw scanner.error("element 'vertex' has property " + inQuotes(property.name) + " twice");
    names.push_back(property.name);
  }
  for (const char* needed : {"x", "y", "z"})
    if (std::find(names.begin(), names.end(), needed) == names.end())
      throw scanner.error("element 'vertex' has no property '" + std::string(needed) + "'");
  if (vertex->count > std::numeric_limits<std::int32_t>::max())
    throw scanner.error("element 'vertex' " + std::to_string(vertex->count) + " is too many");
  return *vertex;
}

bool
isPackedColour(const Field& field)
{
  return (field.name == "rgb" || field.name == "rgba") && field.count == 1 && valueSize(field.datatype) == 4;
}

void
appendHeader(std::string& header, const Field& field)
{
  if (isPackedColour(field)) {
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (field.name == "rgba")
      header += "property uchar alpha\n";
    return;
  }
  std::string name = field.name;
  if (name.size() == 8 && name.rfind("normal_", 0) == 0)
    name = std::string("n") + name.back();
  for (std::uint32_t k = 0; k < field.count; ++k)
    header += std::string("property ") + plyName(field.datatype) + " " + name +
              (field.count > 1 ? "_" + std::to_string(k) : "") + "\n";
}

} // namespace

RawCloud
readPly(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  const std::string head = headOf(source, path, [](TextScanner& lines) { readHeader(lines); });
  TextScanner scanner(head, path);
  const PlyHeader header = readHeader(scanner);
  const Element& vertex = requireVertex(scanner, header);
  VertexRows rows(vertex, header.encoding, fields);
  if (header.encoding == Encoding::Ascii) {
    TextScanner body(source, path);
    readHeader(body);
    for (const Element* element = header.elements.data(); element != &vertex; ++element)
      for (std::size_t i = 0; i < element->count; ++i)
        if (!body.nextData())
          throw body.error("the file ends within element " + inQuotes(element->name));
    appendAscii(body, vertex, rows);
  }
  else {
    BinaryBody body(scanner, source, head.size() - scanner.rest().size(), header.encoding == Encoding::BigEndian);
    for (const Element* element = header.elements.data(); element != &vertex; ++element)
      body.skip(*element);
    body.append(vertex, rows);
  }
  return {std::move(rows).table(), std::nullopt, std::nullopt};
}

void
writePly(const std::string& path, const pcl::PCLPointCloud2& table)
{
  const std::size_t points = pointCount(table);
  std::string content = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points) + "\n";
  for (const Field& field : table.fields)
    appendHeader(content, field);
  content += "end_header\n";
  content.reserve(content.size() + table.data.size());
  for (std::size_t i = 0; i < points; ++i) {
    const char* point = reinterpret_cast<const char*>(table.data.data()) + i * table.point_step;
    for (const Field& field : table.fields) {
      const char* value = point + field.offset;
      if (isPackedColour(field)) {
        content.append({value[2], value[1], value[0]}); // packed as 0xAARRGGBB
        if (field.name == "rgba")
          content.append({value[3]});
      }
      else if (field.datatype == kInt64 || field.datatype == kUint64) {
        for (std::uint32_t k = 0; k < field.count; ++k) {
          const double number =
              loadValue(reinterpret_cast<const std::uint8_t*>(value) + k * sizeof(double), field.datatype);
          content.append(reinterpret_cast<const char*>(&number), sizeof(number));
        }
      }
      else {
        content.append(value, valueSize(field.datatype) * field.count);
      }
    }
  }
  writeFile(path, content);
}

} // namespace io
} // namespace pcl_ssfr
