// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_structure.h>

#include <apps/io/text_scanner.h>

#include <pugixml.hpp>

#include <array>
#include <charconv>
#include <cmath>

namespace pcl_ssfr {
namespace io {

namespace {

using pugi::xml_node;

constexpr std::string_view kBlanks = " \t\r\n";

std::string_view
trimmed(std::string_view text)
{
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

/// Reads one scan and knows where it is, so that errors can say so.
class ScanParser {
public:
  /// \param[in] place the file and the scan, as messages begin
  explicit ScanParser(std::string place) : place_(std::move(place)) {}

  E57Structure
  parse(const xml_node& scan) const;

private:
  IoError
  wrong(const std::string& element, std::string_view value, const char* problem) const
  {
    return IoError(place_ + element + ' ' + inQuotes(value) + ' ' + problem);
  }

  double
  number(std::string_view text, double fallback, const std::string& element) const
  {
    text = trimmed(text);
    if (text.empty())
      return fallback;
    const auto value = parseNumber(text);
    if (!value || !std::isfinite(*value))
      throw wrong(element, text, "is not a finite number");
    return *value;
  }

  template <typename Integer>
  Integer
  integer(std::string_view text, Integer fallback, const std::string& element) const
  {
    text = trimmed(text);
    if (text.empty())
      return fallback;
    if (text.size() > 1 && text[0] == '+' && text[1] != '-')
      text.remove_prefix(1);
    Integer value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      throw wrong(element, text, "is not an integer of its kind");
    return value;
  }

  E57Field
  field(const xml_node& node) const;

  void
  readPose(const xml_node& pose, E57Structure& structure) const;

  void
  readColorLimits(const xml_node& limits, E57Structure& structure) const;

  void
  readPrototype(const xml_node& prototype, E57Structure& structure) const;

  std::string place_;
};

E57Field
ScanParser::field(const xml_node& node) const
{
  E57Field result;
  result.name = node.name();
  const std::string element = "field " + inQuotes(result.name) + ": ";
  const std::string_view type = node.attribute("type").value();
  const auto attribute = [&node](const char* name) { return std::string_view(node.attribute(name).value()); };
  if (type == "Float") {
    const std::string_view precision = trimmed(attribute("precision"));
    if (!precision.empty() && precision != "single" && precision != "double")
      throw wrong(element + "precision", precision, "is neither single nor double");
    result.type = precision == "single" ? E57Type::kFloat : E57Type::kDouble;
  }
  else if (type == "Integer" || type == "ScaledInteger") {
    result.type = type == "Integer" ? E57Type::kInteger : E57Type::kScaledInteger;
    result.minimum = integer(attribute("minimum"), result.minimum, element + "minimum");
    result.maximum = integer(attribute("maximum"), result.maximum, element + "maximum");
    if (result.maximum < result.minimum)
      throw wrong(element + "maximum", attribute("maximum"), "is less than the minimum");
    if (result.type == E57Type::kScaledInteger) {
      result.scale = number(attribute("scale"), result.scale, element + "scale");
      result.offset = number(attribute("offset"), result.offset, element + "offset");
      if (result.scale == 0)
        throw wrong(element + "scale", attribute("scale"), "gives no values");
    }
  }
  else if (type == "String") {
    result.type = E57Type::kString;
  }
  else {
    throw wrong(element + "type", type, "cannot be in a record");
  }
  return result;
}

void
ScanParser::readPose(const xml_node& pose, E57Structure& structure) const
{
  if (!pose)
    return;
  const auto read = [this](const xml_node& parent, const char* name, const std::string& element) {
    return number(parent.child_value(name), 0, element + '/' + name);
  };
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (const xml_node rotation = pose.child("rotation")) {
    Eigen::Vector4d q;
    constexpr std::array<const char*, 4> kNames{{"w", "x", "y", "z"}};
    for (std::size_t k = 0; k < kNames.size(); ++k)
      q[static_cast<Eigen::Index>(k)] = read(rotation, kNames[k], "pose/rotation");
    const double norm = q.norm();
    if (!std::isnormal(norm))
      throw IoError(place_ + "pose/rotation: a quaternion of length " + std::to_string(norm) + " is no rotation");
    q /= norm;
    motion.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  }
  const xml_node translation = pose.child("translation");
  constexpr std::array<const char*, 3> kAxes{{"x", "y", "z"}};
  for (std::size_t k = 0; k < kAxes.size(); ++k)
    motion.translation()[static_cast<Eigen::Index>(k)] = read(translation, kAxes[k], "pose/translation");
  structure.T_file_scan = motion;
}

void
ScanParser::readColorLimits(const xml_node& limits, E57Structure& structure) const
{
  if (!limits)
    return;
  std::pair<double, double> range(0, 0);
  for (const std::string color : {"colorRed", "colorGreen", "colorBlue"}) {
    for (const auto& [end, value] : {std::pair("Minimum", &range.first), std::pair("Maximum", &range.second)}) {
      const double limit = number(limits.child_value((color + end).c_str()), 0, "colorLimits/" + color + end);
      *value = value == &range.first ? std::min(*value, limit) : std::max(*value, limit);
    }
  }
  if (range.second > range.first)
    structure.color_limits = range;
}

void
ScanParser::readPrototype(const xml_node& prototype, E57Structure& structure) const
{
  // The leaves in the order of the document; structures may be nested, in extensions.
  xml_node node = prototype.first_child();
  while (node) {
    const bool element = node.type() == pugi::node_element;
    const std::string_view type = node.attribute("type").value();
    const bool branch = element && (type == "Structure" || type == "Vector");
    if (element && !branch) {
      structure.fields.push_back(field(node));
      if (node.parent() != prototype)
        structure.fields.back().name.insert(0, "/"); // not one of the standard's
    }
    if (branch && node.first_child()) {
      node = node.first_child();
      continue;
    }
    while (node != prototype && !node.next_sibling())
      node = node.parent();
    node = node == prototype ? xml_node() : node.next_sibling();
  }
}

E57Structure
ScanParser::parse(const xml_node& scan) const
{
  E57Structure structure;
  structure.name = std::string(trimmed(scan.child_value("name")));
  structure.guid = std::string(trimmed(scan.child_value("guid")));
  readPose(scan.child("pose"), structure);
  readColorLimits(scan.child("colorLimits"), structure);
  const xml_node points = scan.child("points");
  const std::string_view type = points.attribute("type").value();
  if (type != "CompressedVector")
    throw wrong("points: type", type, "is not CompressedVector");
  for (const char* needed : {"fileOffset", "recordCount"})
    if (!points.attribute(needed))
      throw IoError(place_ + "points: " + needed + " is missing");
  structure.points_at = integer(points.attribute("fileOffset").value(), std::uint64_t{0}, "points: fileOffset");
  structure.records = integer(points.attribute("recordCount").value(), std::uint64_t{0}, "points: recordCount");
  readPrototype(points.child("prototype"), structure);
  for (const xml_node codec : points.child("codecs").children())
    for (const xml_node part : codec.children())
      if (const std::string_view name = part.name();
          part.type() == pugi::node_element && name != "inputs" && name != "bitPackCodec")
        throw wrong("codecs:", name, "is not supported");
  return structure;
}

} // namespace

std::vector<E57Structure>
parseE57Xml(const std::string& path, std::string xml)
{
  while (!xml.empty() && (xml.back() == '\0' || kBlanks.find(xml.back()) != std::string_view::npos))
    xml.pop_back();
  pugi::xml_document document;
  // pugixml neither recurses nor resolves entities of a document's own.
  const auto parsed = document.load_buffer_inplace(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed)
    throw IoError(path + ": the XML section is wrong at its byte " + std::to_string(parsed.offset) + ": " +
                  parsed.description());
  const xml_node root = document.document_element();
  if (std::string_view(root.name()) != "e57Root")
    throw IoError(path + ": the XML section is of " + inQuotes(root.name()) + ", not of 'e57Root'");
  std::vector<E57Structure> scans;
  for (const xml_node scan : root.child("data3D").children())
    if (scan.type() == pugi::node_element)
      scans.push_back(ScanParser(path + ": scan " + std::to_string(scans.size() + 1) + ": ").parse(scan));
  return scans;
}

} // namespace io
} // namespace pcl_ssfr
