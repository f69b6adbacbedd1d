// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_pages.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::uint32_t kPolynomial = 0x82F63B78; ///< of CRC-32C, least significant bit first
constexpr std::size_t kSlices = 8;                ///< bytes that one step of the checksum takes
constexpr std::size_t kWrittenPayload = kE57WrittenPage - kE57ChecksumBytes;
constexpr std::size_t kReadStep = 1U << 16; ///< of a long read [bytes]
/// Longest description that is parsed: ten thousand scans take a few per cent of it [bytes].
constexpr std::uint64_t kMaxXml = 1U << 28;

using CrcTables = std::array<std::array<std::uint32_t, 256>, kSlices>;

constexpr CrcTables
makeCrcTables()
{
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1) ^ ((crc & 1U) != 0 ? kPolynomial : 0U);
    tables[0][byte] = crc;
  }
  for (std::size_t slice = 1; slice < kSlices; ++slice)
    for (std::size_t byte = 0; byte < 256; ++byte)
      tables[slice][byte] = (tables[slice - 1][byte] >> 8) ^ tables[0][tables[slice - 1][byte] & 255U];
  return tables;
}

constexpr CrcTables kCrc = makeCrcTables();

/// The checksum as it lies in a page.
std::array<char, kE57ChecksumBytes>
checksumOf(std::string_view payload)
{
  const std::uint32_t crc = crc32c(payload);
  return {{static_cast<char>(crc >> 24),
           static_cast<char>(crc >> 16 & 255U),
           static_cast<char>(crc >> 8 & 255U),
           static_cast<char>(crc & 255U)}};
}

template <typename T>
std::string_view
viewOf(const T& value)
{
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

} // namespace

std::uint32_t
crc32c(std::string_view bytes)
{
  std::uint32_t crc = ~0U;
  std::size_t at = 0;
  for (; at + kSlices <= bytes.size(); at += kSlices) {
    const std::uint64_t word = valueAt<std::uint64_t>(bytes, at) ^ crc;
    crc = 0;
    for (std::size_t k = 0; k < kSlices; ++k)
      crc ^= kCrc[kSlices - 1 - k][word >> 8 * k & 255U];
  }
  for (; at < bytes.size(); ++at)
    crc = (crc >> 8) ^ kCrc[0][(crc ^ static_cast<unsigned char>(bytes[at])) & 255U];
  return ~crc;
}

void
sealE57Page(char* page, std::size_t page_size)
{
  const std::size_t payload = page_size - kE57ChecksumBytes;
  const auto checksum = checksumOf({page, payload});
  std::copy(checksum.begin(), checksum.end(), page + payload);
}

E57PageReader::E57PageReader(std::string path, const ByteSource& source) : path_(std::move(path)), source_(source)
{
  const std::uint64_t bytes = source.size();
  std::string header(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, kE57HeaderBytes)), '\0');
  source.read(0, header.size(), header.data());
  if (header.compare(0, std::strlen(kE57Signature), kE57Signature) != 0)
    throw IoError(path_ + ": not an E57 file: it starts with " + inQuotes(header.substr(0, 8)) + ", not 'ASTM-E57'");
  if (header.size() < kE57HeaderBytes)
    throw IoError(path_ + ": the E57 header ends after " + std::to_string(bytes) + " bytes");
  const auto major = valueAt<std::uint32_t>(header, kE57MajorAt);
  if (major != 1)
    throw IoError(path_ + ": E57 version " + std::to_string(major) + " is not supported");
  const auto length = valueAt<std::uint64_t>(header, kE57LengthAt);
  const auto page_size = valueAt<std::uint64_t>(header, kE57PageSizeAt);
  if (length > bytes)
    throw IoError(path_ + ": the file is cut off: its header says " + std::to_string(length) + " bytes, there are " +
                  std::to_string(bytes));
  if (page_size < kE57HeaderBytes + kE57ChecksumBytes || page_size > length || length % page_size != 0)
    throw IoError(path_ + ": page size " + std::to_string(page_size) + " does not cut " + std::to_string(length) +
                  " bytes into pages");
  page_size_ = static_cast<std::size_t>(page_size);
  payload_ = page_size_ - kE57ChecksumBytes;
  pages_ = length / page_size;
  xml_at_ = toLogical(valueAt<std::uint64_t>(header, kE57XmlOffsetAt), "offset of the XML section");
  xml_length_ = valueAt<std::uint64_t>(header, kE57XmlLengthAt);
  if (xml_length_ == 0 || xml_length_ > size() - xml_at_ || xml_length_ > kMaxXml)
    throw IoError(path_ + ": length of the XML section " + std::to_string(xml_length_) + " does not fit into the " +
                  std::to_string(size() - xml_at_) + " bytes that follow");
}

std::uint64_t
E57PageReader::toLogical(std::uint64_t physical, const char* what) const
{
  const std::uint64_t page = physical / page_size_;
  const std::uint64_t within = physical % page_size_;
  if (page >= pages_ || within >= payload_)
    throw IoError(path_ + ": " + what + ' ' + std::to_string(physical) +
                  (page >= pages_ ? " is outside the file" : " is inside a checksum"));
  return page * payload_ + within;
}

void
E57PageReader::load(std::uint64_t first_page, std::uint64_t pages)
{
  loaded_pages_ = 0; // should this throw
  loaded_.resize(static_cast<std::size_t>(pages) * page_size_);
  source_.read(first_page * page_size_, loaded_.size(), loaded_.data());
  for (std::size_t i = 0; i < pages; ++i) {
    const std::string_view page = std::string_view(loaded_).substr(i * page_size_, page_size_);
    const auto checksum = checksumOf(page.substr(0, payload_));
    if (page.substr(payload_) != std::string_view(checksum.data(), checksum.size()))
      throw IoError(path_ + ": the checksum of page " + std::to_string(first_page + i) + " (bytes from " +
                    std::to_string((first_page + i) * page_size_) + ") is wrong: the file is damaged");
  }
  first_loaded_ = first_page;
  loaded_pages_ = pages;
}

void
E57PageReader::read(std::uint64_t at, std::size_t count, char* to)
{
  if (at > size() || count > size() - at)
    throw IoError(path_ + ": " + std::to_string(count) + " bytes at " + std::to_string(at) + " reach beyond the end");
  while (count > 0) {
    const std::size_t step = std::min(count, kReadStep);
    const std::uint64_t first = at / payload_;
    const std::uint64_t last = (at + step - 1) / payload_;
    if (first < first_loaded_ || last >= first_loaded_ + loaded_pages_)
      load(first, last - first + 1);
    for (std::size_t done = 0; done < step;) {
      const std::size_t page = static_cast<std::size_t>((at + done) / payload_ - first_loaded_);
      const std::size_t within = static_cast<std::size_t>((at + done) % payload_);
      const std::size_t piece = std::min(step - done, payload_ - within);
      std::memcpy(to + done, loaded_.data() + page * page_size_ + within, piece);
      done += piece;
    }
    at += step;
    to += step;
    count -= step;
  }
}

std::string
E57PageReader::readXml()
{
  std::string xml(static_cast<std::size_t>(xml_length_), '\0');
  read(xml_at_, xml.size(), xml.data());
  return xml;
}

E57PageWriter::E57PageWriter(const std::string& path) : file_(path)
{
  append(std::string(kE57HeaderBytes, '\0'));
}

std::uint64_t
E57PageWriter::toPhysical(std::uint64_t logical)
{
  return logical / kWrittenPayload * kE57WrittenPage + logical % kWrittenPayload;
}

void
E57PageWriter::flushPage()
{
  sealE57Page(page_.data(), page_.size());
  file_.write({page_.data(), page_.size()});
  page_.fill('\0');
}

void
E57PageWriter::append(std::string_view bytes)
{
  while (!bytes.empty()) {
    const auto within = static_cast<std::size_t>(position_ % kWrittenPayload);
    const std::size_t piece = std::min(bytes.size(), kWrittenPayload - within);
    bytes.copy(page_.data() + within, piece);
    bytes.remove_prefix(piece);
    position_ += piece;
    if (within + piece == kWrittenPayload)
      flushPage();
  }
}

void
E57PageWriter::align()
{
  constexpr std::size_t kAlignment = 4;
  append(std::string(static_cast<std::size_t>((kAlignment - position_ % kAlignment) % kAlignment), '\0'));
}

void
E57PageWriter::patch(std::uint64_t at, std::string_view bytes)
{
  while (!bytes.empty()) {
    const std::uint64_t page = at / kWrittenPayload;
    const auto within = static_cast<std::size_t>(at % kWrittenPayload);
    const std::size_t piece = std::min(bytes.size(), kWrittenPayload - within);
    if (page == position_ / kWrittenPayload) {
      bytes.copy(page_.data() + within, piece);
    }
    else {
      std::array<char, kE57WrittenPage> old{};
      const auto place = static_cast<off_t>(page * kE57WrittenPage);
      std::FILE* file = file_.stream();
      if (fseeko(file, place, SEEK_SET) != 0 || std::fread(old.data(), 1, old.size(), file) != old.size() ||
          fseeko(file, place, SEEK_SET) != 0)
        file_.fail();
      bytes.copy(old.data() + within, piece);
      sealE57Page(old.data(), old.size());
      file_.write({old.data(), old.size()});
      if (fseeko(file, 0, SEEK_END) != 0)
        file_.fail();
    }
    bytes.remove_prefix(piece);
    at += piece;
  }
}

void
E57PageWriter::finish(std::string_view xml)
{
  align();
  const std::uint64_t xml_at = toPhysical(position_);
  append(xml);
  if (position_ % kWrittenPayload != 0)
    append(std::string(static_cast<std::size_t>(kWrittenPayload - position_ % kWrittenPayload), '\0'));
  const std::uint64_t length = position_ / kWrittenPayload * kE57WrittenPage;
  std::string header = kE57Signature;
  const std::uint32_t major = 1;
  const std::uint32_t minor = 0;
  const std::uint64_t xml_length = xml.size();
  const std::uint64_t page_size = kE57WrittenPage;
  header.append(viewOf(major)).append(viewOf(minor)).append(viewOf(length));
  header.append(viewOf(xml_at)).append(viewOf(xml_length)).append(viewOf(page_size));
  patch(0, header);
  file_.finish();
}

} // namespace io
} // namespace pcl_ssfr
