// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_records.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::size_t kBlock = 4096; ///< records that are decoded at once
constexpr unsigned kBitsOfByte = 8;
constexpr unsigned kWord = 64;
constexpr std::size_t kMinStringBytes = 1; ///< a string in a stream begins with its length

// Byte offsets within the header of the section.
constexpr std::size_t kSectionLengthAt = 8;
constexpr std::size_t kDataOffsetAt = 16;

template <typename Float, typename Bits>
double
floatOf(std::uint64_t stored)
{
  const Bits bits = static_cast<Bits>(stored);
  Float value;
  std::memcpy(&value, &bits, sizeof(value));
  return static_cast<double>(value);
}

} // namespace

unsigned
E57Field::bits() const
{
  if (type == E57Type::kFloat)
    return kWord / 2;
  if (type == E57Type::kDouble)
    return kWord;
  if (type == E57Type::kString)
    return kBitsOfByte * kMinStringBytes;
  unsigned count = 0;
  for (auto range = static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum); range != 0; range >>= 1)
    ++count;
  return count;
}

double
E57Field::value(std::uint64_t stored) const
{
  if (type == E57Type::kFloat)
    return floatOf<float, std::uint32_t>(stored);
  if (type == E57Type::kDouble)
    return floatOf<double, std::uint64_t>(stored);
  // Modulo 2^64, for the bits of a damaged file may stand for more than the maximum.
  const auto integer = static_cast<double>(static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + stored));
  return type == E57Type::kScaledInteger ? integer * scale + offset : integer;
}

std::pair<double, double>
E57Field::range() const
{
  if (type == E57Type::kInteger || type == E57Type::kScaledInteger) {
    const double a = value(0);
    const double b = value(static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum));
    return {std::min(a, b), std::max(a, b)};
  }
  return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
}

void
E57BitStream::append(std::string_view bytes)
{
  // What was taken goes when it is the larger part, so that each byte is moved once on average.
  if (const std::size_t taken = at_ / kBitsOfByte; taken >= bytes_.size() - taken) {
    bytes_.erase(0, taken);
    at_ %= kBitsOfByte;
  }
  bytes_.append(bytes);
}

std::uint64_t
E57BitStream::next()
{
  const std::size_t first = at_ / kBitsOfByte;
  const auto shift = static_cast<unsigned>(at_ % kBitsOfByte);
  std::uint64_t word = 0;
  std::memcpy(&word, bytes_.data() + first, std::min(sizeof(word), bytes_.size() - first));
  word >>= shift;
  if (shift + width_ > kWord)
    word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[first + sizeof(word)])) << (kWord - shift);
  at_ += width_;
  return width_ == kWord ? word : word & ((std::uint64_t{1} << width_) - 1);
}

E57RecordReader::E57RecordReader(E57PageReader& pages, const E57Structure& structure, std::vector<std::size_t> wanted)
    : pages_(pages), structure_(structure), wanted_(std::move(wanted)), left_(structure.records)
{
  for (const std::size_t field : wanted_)
    streams_.emplace_back(std::max(1U, structure.fields[field].bits()));
  const std::uint64_t start = pages.toLogical(structure.points_at, "offset of the points");
  std::string header(kE57SectionHeaderBytes, '\0');
  pages.read(start, header.size(), header.data());
  const auto kind = valueAt<std::uint8_t>(header, 0);
  const auto length = valueAt<std::uint64_t>(header, kSectionLengthAt);
  if (kind != kE57RecordSection)
    throw wrong("the section of the points is of kind " + std::to_string(kind) + ", not 1");
  if (length < header.size() || length > pages.size() - start)
    throw wrong("the section of the points has " + std::to_string(length) +
                " bytes, from its place to the end of the " + "file there are " + std::to_string(pages.size() - start));
  if (left_ == 0)
    return;
  // Records that take less than a byte occur in no scan: a point has three coordinates.
  std::uint64_t bits = 0;
  for (const E57Field& field : structure.fields)
    bits += field.bits();
  const std::uint64_t least = std::max<std::uint64_t>(1, bits / kBitsOfByte);
  if (left_ > length / least)
    throw wrong("recordCount " + std::to_string(left_) + ": records of " + std::to_string(least) +
                " bytes and more do not fit into the " + std::to_string(length) + " bytes of their section");
  end_ = start + length;
  at_ = pages.toLogical(valueAt<std::uint64_t>(header, kDataOffsetAt), "offset of the first packet");
  if (at_ < start + header.size() || at_ > end_)
    throw wrong("the first packet is outside the section of the points");
}

IoError
E57RecordReader::wrong(const std::string& message) const
{
  return IoError(pages_.path() + ": " + message);
}

std::size_t
E57RecordReader::next(std::vector<std::vector<double>>& columns)
{
  columns.resize(wanted_.size());
  std::uint64_t ready = 0;
  while (left_ > 0) {
    ready = left_;
    for (std::size_t k = 0; k < wanted_.size(); ++k)
      if (structure_.fields[wanted_[k]].bits() != 0)
        ready = std::min(ready, streams_[k].available());
    if (ready > 0)
      break;
    readPacket();
  }
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(ready, kBlock));
  for (std::size_t k = 0; k < wanted_.size(); ++k) {
    const E57Field& field = structure_.fields[wanted_[k]];
    columns[k].resize(count);
    if (field.bits() == 0)
      std::fill(columns[k].begin(), columns[k].end(), field.value(0));
    else
      for (double& value : columns[k])
        value = field.value(streams_[k].next());
  }
  left_ -= count;
  return count;
}

void
E57RecordReader::readPacket()
{
  if (end_ - at_ < kE57PacketHeaderBytes)
    throw wrong("the section of the points ends after " + std::to_string(structure_.records - left_) + " of " +
                std::to_string(structure_.records) + " records");
  std::string header(kE57PacketHeaderBytes, '\0');
  pages_.read(at_, header.size(), header.data());
  const auto kind = valueAt<std::uint8_t>(header, 0);
  const std::size_t length = std::size_t{valueAt<std::uint16_t>(header, 2)} + 1;
  if (length < kE57PacketHeaderBytes || length > end_ - at_)
    throw wrong("a packet of " + std::to_string(length) + " bytes does not fit into the " + std::to_string(end_ - at_) +
                " bytes that are left of its section");
  if (kind > kE57IgnoredPacket)
    throw wrong("packet of kind " + std::to_string(kind) + ", not 0, 1 or 2");
  if (kind == kE57DataPacket) {
    packet_.resize(length);
    pages_.read(at_, length, packet_.data());
    readDataPacket();
  }
  at_ += length;
}

void
E57RecordReader::readDataPacket()
{
  const std::size_t fields = structure_.fields.size();
  const std::size_t streams =
      packet_.size() < kE57DataHeaderBytes ? 0 : valueAt<std::uint16_t>(packet_, kE57PacketHeaderBytes);
  if (streams != fields)
    throw wrong("a packet has " + std::to_string(streams) + " streams, the records have " + std::to_string(fields) +
                " fields");
  std::vector<std::string_view> parts;
  std::size_t at = kE57DataHeaderBytes + streams * sizeof(std::uint16_t);
  for (std::size_t i = 0; i < streams && at <= packet_.size(); ++i) {
    const std::size_t length = valueAt<std::uint16_t>(packet_, kE57DataHeaderBytes + i * sizeof(std::uint16_t));
    parts.push_back(std::string_view(packet_).substr(at, length));
    at += length;
  }
  if (at > packet_.size())
    throw wrong("the streams of a packet take more than its " + std::to_string(packet_.size()) + " bytes");
  for (std::size_t k = 0; k < wanted_.size(); ++k)
    if (structure_.fields[wanted_[k]].bits() != 0)
      streams_[k].append(parts[wanted_[k]]);
}

} // namespace io
} // namespace pcl_ssfr
