// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <io_testing.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

// E57 files made and taken apart bit by bit, slowly and without anything of apps/io: what the reader and the writer are
// compared with.
namespace pcl_ssfr::testing {

/// CRC-32C one bit at a time, from its definition.
inline std::uint32_t
slowCrc32c(const std::string& bytes)
{
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes)
    for (unsigned bit = 0; bit < 8; ++bit) {
      const bool carry = ((crc ^ static_cast<unsigned char>(byte) >> bit) & 1U) != 0;
      crc = (crc >> 1) ^ (carry ? 0x82F63B78U : 0U);
    }
  return crc ^ 0xFFFFFFFFU;
}

/// Logical content as pages with their checksums; the last page is filled up.
inline std::string
toPages(std::string logical, std::size_t page_size = 1024)
{
  const std::size_t payload = page_size - 4;
  logical.resize((logical.size() + payload - 1) / payload * payload);
  std::string pages;
  for (std::size_t at = 0; at < logical.size(); at += payload) {
    const std::string page = logical.substr(at, payload);
    const std::uint32_t crc = slowCrc32c(page);
    pages += page;
    for (const unsigned shift : {24U, 16U, 8U, 0U})
      pages += static_cast<char>(crc >> shift & 255U);
  }
  return pages;
}

/// The logical content of pages. A failure at a wrong checksum.
inline std::string
fromPages(const std::string& pages, std::size_t page_size = 1024)
{
  std::string logical;
  for (std::size_t at = 0; at + page_size <= pages.size(); at += page_size)
    logical += pages.substr(at, page_size - 4);
  EXPECT_TRUE(toPages(logical, page_size) == pages) << "checksums or length";
  return logical;
}

/// A field of the records and its values as they are stored: above the least one, or the bits of a float.
struct E57Column {
  std::string element; ///< of the prototype: "cartesianX type=..."
  unsigned width = 0;  ///< [bits]
  std::vector<std::uint64_t> stored;
  std::string bytes; ///< in place of stored: the stream itself

  std::string
  stream() const
  {
    std::string packed = bytes;
    std::size_t at = 0;
    for (const std::uint64_t value : stored)
      for (unsigned bit = 0; bit < width; ++bit, ++at) {
        if (at / 8 == packed.size())
          packed += '\0';
        packed[at / 8] = static_cast<char>(packed[at / 8] | static_cast<char>((value >> bit & 1U) << at % 8));
      }
    return packed;
  }
};

/// Numbers by the bits of their type, float or double.
template <typename Real>
E57Column
realColumn(const std::string& element, const std::vector<Real>& values)
{
  E57Column column{element, 8 * sizeof(Real), {}, {}};
  for (const Real value : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(value));
    column.stored.push_back(bits);
  }
  return column;
}

inline E57Column
singleColumn(const std::string& name, const std::vector<float>& values)
{
  return realColumn(name + R"( type="Float" precision="single")", values);
}

inline E57Column
doubleColumn(const std::string& name, const std::vector<double>& values)
{
  return realColumn(name + R"( type="Float")", values);
}

/// \p attributes: minimum, maximum, scale, offset
inline E57Column
integerColumn(const std::string& name, const std::string& attributes, unsigned width, std::vector<std::uint64_t> stored)
{
  const char* type = attributes.find("scale") == std::string::npos ? "Integer" : "ScaledInteger";
  return {name + " type=\"" + type + "\" " + attributes, width, std::move(stored), {}};
}

/// One scan of a made-up file, and what can be wrong with it.
struct E57Made {
  std::string head; ///< elements before its points
  std::vector<E57Column> columns;
  std::string records; ///< empty: as many as the first column has
  /// Bytes of stream \p k in packet \p packet: streams may be cut anywhere.
  std::function<std::size_t(std::size_t k, std::size_t packet)> piece = [](std::size_t, std::size_t) {
    return std::size_t{60000} / 16;
  };
  bool other_packets = false;                                      ///< index and ignored packets between the others
  std::string codecs;                                              ///< in the element of that name
  std::function<void(std::string& section)> damage = [](auto&) {}; ///< to the section before it is written
};

/// A whole file, still without pages: its logical content, header included.
inline std::string
makeE57Logical(
    const std::vector<E57Made>& scans,
    std::size_t page_size = 1024,
    const std::function<std::string(std::string)>& change_xml = [](std::string xml) { return xml; })
{
  const auto physical = [page_size](std::size_t logical) {
    return static_cast<std::uint64_t>(logical / (page_size - 4) * page_size + logical % (page_size - 4));
  };
  const auto align = [](std::string& bytes) { bytes.resize((bytes.size() + 3) / 4 * 4); };
  std::string logical(48, '\0');
  std::string data;
  for (const E57Made& scan : scans) {
    align(logical);
    const std::size_t start = logical.size();
    std::string section(32, '\0');
    section[0] = 1;
    const std::uint64_t data_at = physical(start + section.size());
    std::memcpy(section.data() + 16, &data_at, 8);
    std::vector<std::string> streams;
    for (const E57Column& column : scan.columns)
      streams.push_back(column.stream());
    const auto left = [&streams] {
      std::size_t bytes = 0;
      for (const std::string& stream : streams)
        bytes += stream.size();
      return bytes;
    };
    for (std::size_t packet = 0; left() > 0; ++packet) {
      if (scan.other_packets)
        section += std::string("\2\0\7\0abcd", 8) + std::string("\0\0\37\0\1\0", 6) + std::string(26, '\0');
      std::string body = bytesOf(static_cast<std::uint16_t>(streams.size()));
      std::string parts;
      for (std::size_t k = 0; k < streams.size(); ++k) {
        const std::string part = streams[k].substr(0, scan.piece(k, packet));
        streams[k].erase(0, part.size());
        body += bytesOf(static_cast<std::uint16_t>(part.size()));
        parts += part;
      }
      body += parts;
      body.resize((body.size() + 3) / 4 * 4);
      section += std::string("\1\0", 2) + bytesOf(static_cast<std::uint16_t>(body.size() + 3)) + body;
    }
    const std::uint64_t length = section.size();
    std::memcpy(section.data() + 8, &length, 8);
    scan.damage(section);
    logical += section;
    data += "<vectorChild type=\"Structure\">" + scan.head + "<points type=\"CompressedVector\" fileOffset=\"" +
            std::to_string(physical(start)) + "\" recordCount=\"" +
            (scan.records.empty() ? std::to_string(scan.columns.front().stored.size()) : scan.records) +
            "\"><prototype type=\"Structure\">";
    for (const E57Column& column : scan.columns)
      data += "<" + column.element + "/>";
    data += "</prototype><codecs type=\"Vector\">" + scan.codecs + "</codecs></points></vectorChild>";
  }
  align(logical);
  const std::string xml = change_xml("<?xml version=\"1.0\" encoding=\"UTF-8\"?><e57Root type=\"Structure\" "
                                     "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\"><data3D type=\"Vector\">" +
                                     data + "</data3D></e57Root>");
  const std::size_t xml_at = logical.size();
  logical += xml;
  const std::size_t pages = (logical.size() + page_size - 5) / (page_size - 4);
  const std::string header = "ASTM-E57" + bytesOf(1U) + bytesOf(0U) +
                             bytesOf(static_cast<std::uint64_t>(pages * page_size)) + bytesOf(physical(xml_at)) +
                             bytesOf(static_cast<std::uint64_t>(xml.size())) +
                             bytesOf(static_cast<std::uint64_t>(page_size));
  logical.replace(0, 48, header);
  return logical;
}

inline std::string
makeE57(const std::vector<E57Made>& scans, std::size_t page_size = 1024)
{
  return toPages(makeE57Logical(scans, page_size), page_size);
}

/// A scan as the independent decoder finds it: the stored numbers of each field.
struct E57Decoded {
  std::string xml; ///< of the scan
  std::vector<std::pair<std::string, std::vector<std::uint64_t>>> columns;

  const std::vector<std::uint64_t>&
  column(const std::string& name) const
  {
    for (const auto& [key, values] : columns)
      if (key == name)
        return values;
    throw std::runtime_error("no column " + name);
  }
  /// The text between the tags of an element; \p from: text that comes before it
  std::string
  text(const std::string& element, const std::string& from = "") const
  {
    const std::size_t start = xml.find("<" + element + " ", from.empty() ? 0 : xml.find(from));
    if (start == std::string::npos)
      throw std::runtime_error("no element " + element);
    const std::size_t begin = xml.find('>', start) + 1;
    return xml.substr(begin, xml.find('<', begin) - begin);
  }
};

/// Take a file of 1024-byte pages apart whose fields are floats or integers with limits.
inline std::vector<E57Decoded>
decodeE57(const std::string& file)
{
  const std::string logical = fromPages(file);
  const auto number = [&logical](std::size_t at, std::size_t bytes) {
    std::uint64_t value = 0;
    std::memcpy(&value, logical.data() + at, bytes);
    return value;
  };
  const auto toLogical = [](std::uint64_t physical) { return physical / 1024 * 1020 + physical % 1024; };
  EXPECT_EQ(logical.substr(0, 8), "ASTM-E57");
  EXPECT_EQ(number(8, 4), 1U);
  EXPECT_EQ(number(16, 8), file.size());
  EXPECT_EQ(number(40, 8), 1024U);
  const std::string xml = logical.substr(toLogical(number(24, 8)), number(32, 8));
  EXPECT_EQ(xml.substr(0, 5), "<?xml");
  EXPECT_EQ(xml.substr(xml.size() - 11), "</e57Root>\n");
  std::vector<E57Decoded> scans;
  for (std::size_t at = xml.find("<vectorChild"); at != std::string::npos; at = xml.find("<vectorChild", at + 1)) {
    E57Decoded scan;
    scan.xml = xml.substr(at, xml.find("</vectorChild>", at) - at);
    const auto attribute = [](const std::string& text, const std::string& name) {
      const std::size_t begin = text.find(' ' + name + "=\"");
      return begin == std::string::npos
                 ? std::string()
                 : text.substr(begin + name.size() + 3,
                               text.find('"', begin + name.size() + 3) - begin - name.size() - 3);
    };
    const std::string points = scan.xml.substr(scan.xml.find("<points"));
    const std::uint64_t records = std::stoull(attribute(points, "recordCount"));
    std::istringstream prototype(points.substr(points.find("<prototype"), points.find("</prototype>")));
    std::string line;
    std::getline(prototype, line);
    std::vector<unsigned> widths;
    while (std::getline(prototype, line) && line.rfind("</", 0) != 0) {
      unsigned width = attribute(line, "precision") == "single" ? 32 : 64;
      if (attribute(line, "type") == "Integer") {
        std::uint64_t range = static_cast<std::uint64_t>(std::stoll(attribute(line, "maximum"))) -
                              static_cast<std::uint64_t>(std::stoll(attribute(line, "minimum")));
        for (width = 0; range != 0; range /= 2)
          ++width;
      }
      widths.push_back(width);
      scan.columns.emplace_back(line.substr(1, line.find(' ') - 1), std::vector<std::uint64_t>());
    }
    std::vector<std::string> streams(widths.size());
    const std::size_t start = toLogical(std::stoull(attribute(points, "fileOffset")));
    EXPECT_EQ(start % 4, 0U);
    EXPECT_EQ(number(start, 1), 1U);
    const std::size_t end = start + number(start + 8, 8);
    std::size_t packet = records == 0 ? end : toLogical(number(start + 16, 8));
    bool index = false;
    while (packet < end) {
      const std::size_t length = number(packet + 2, 2) + 1;
      EXPECT_EQ(length % 4, 0U);
      if (number(packet, 1) == 1) {
        EXPECT_EQ(number(packet + 4, 2), streams.size());
        std::size_t part = packet + 6 + 2 * streams.size();
        for (std::size_t k = 0; k < streams.size(); ++k) {
          streams[k] += logical.substr(part, number(packet + 6 + 2 * k, 2));
          part += number(packet + 6 + 2 * k, 2);
        }
        EXPECT_LE(part, packet + length);
      }
      else {
        EXPECT_EQ(number(packet, 1), 0U);
        EXPECT_EQ(toLogical(number(start + 24, 8)), packet);
        EXPECT_EQ(toLogical(number(packet + 24, 8)), start + 32);
        index = true;
      }
      packet += length;
    }
    EXPECT_EQ(packet, end);
    EXPECT_EQ(index, records > 0);
    for (std::size_t k = 0; k < widths.size(); ++k)
      for (std::size_t i = 0; i < records; ++i) {
        std::uint64_t value = 0;
        for (unsigned bit = 0; bit < widths[k]; ++bit) {
          const std::size_t place = i * widths[k] + bit;
          value |= std::uint64_t{static_cast<unsigned char>(streams[k].at(place / 8)) >> place % 8 & 1U} << bit;
        }
        scan.columns[k].second.push_back(value);
      }
    scans.push_back(std::move(scan));
  }
  return scans;
}

} // namespace pcl_ssfr::testing
