// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/file_bytes.h>
#include <apps/io/output_file.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

// E57 (ASTM E2807) cuts a file into pages. Each ends with a checksum of what is before it. A physical offset counts all
// bytes of the file, a logical one leaves the checksums out.

constexpr std::size_t kE57ChecksumBytes = 4;
constexpr std::size_t kE57HeaderBytes = 48;
constexpr std::size_t kE57WrittenPage = 1024; ///< the page size that the standard asks for [bytes]
constexpr const char* kE57Signature = "ASTM-E57";

// Byte offsets within the file header.
constexpr std::size_t kE57MajorAt = 8;
constexpr std::size_t kE57LengthAt = 16;
constexpr std::size_t kE57XmlOffsetAt = 24;
constexpr std::size_t kE57XmlLengthAt = 32;
constexpr std::size_t kE57PageSizeAt = 40;

/// CRC-32C (Castagnoli) of \p bytes.
std::uint32_t
crc32c(std::string_view bytes);

/// Write the checksum of a whole page into its last bytes, most significant byte first as the standard has it.
void
sealE57Page(char* page, std::size_t page_size);

/** \brief The logical bytes of an E57 file, each page checked as it is read. Memory: the pages of one read(). */
class E57PageReader {
public:
  /** \brief Read and check the file header. The source outlives this.
   * \throw IoError that names \p path and the field
   */
  E57PageReader(std::string path, const ByteSource& source);

  const std::string&
  path() const
  {
    return path_;
  }
  /// Logical bytes of the file.
  std::uint64_t
  size() const
  {
    return pages_ * payload_;
  }
  /// \throw IoError when \p physical, called \p what in the message, is no place in the file's content
  std::uint64_t
  toLogical(std::uint64_t physical, const char* what) const;

  /// Copy \p count logical bytes from \p at on. \throw IoError when the file ends before, or a checksum is wrong
  void
  read(std::uint64_t at, std::size_t count, char* to);

  /// The XML section. \throw IoError
  std::string
  readXml();

private:
  void
  load(std::uint64_t first_page, std::uint64_t pages);

  std::string path_;
  const ByteSource& source_;
  std::size_t page_size_ = 0; ///< [bytes]
  std::size_t payload_ = 0;   ///< of a page, without its checksum [bytes]
  std::uint64_t pages_ = 0;
  std::uint64_t xml_at_ = 0; ///< logical
  std::uint64_t xml_length_ = 0;
  std::string loaded_; ///< whole pages, checked
  std::uint64_t first_loaded_ = 0;
  std::uint64_t loaded_pages_ = 0;
};

/** \brief Writes logical bytes one after the other as pages. A file that is not finished has no signature. */
class E57PageWriter {
public:
  /// \throw IoError when the file cannot be created
  explicit E57PageWriter(const std::string& path);

  /// \throw IoError when the disk is full
  void
  append(std::string_view bytes);
  /// Logical bytes so far.
  std::uint64_t
  position() const
  {
    return position_;
  }
  static std::uint64_t
  toPhysical(std::uint64_t logical);
  /// Fill up to a multiple of four bytes, where each section begins.
  void
  align();
  /// Replace bytes that were written before. \throw IoError
  void
  patch(std::uint64_t at, std::string_view bytes);
  /// Append the XML section, fill the last page and write the file header. \throw IoError
  void
  finish(std::string_view xml);

private:
  void
  flushPage();

  OutputFile file_;
  std::array<char, kE57WrittenPage> page_{}; ///< the last page, not yet written
  std::uint64_t position_ = 0;
};

} // namespace io
} // namespace pcl_ssfr
