// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

/** \brief The whole content of a regular file.
 * \throw IoError when it is missing, a directory, not a regular file, or unreadable.
 */
std::string
readFile(const std::string& path);

/** \brief Replace the content of a file.
 * \throw IoError when it cannot be created or not be written completely: it is as before then (output_file.h).
 */
void
writeFile(const std::string& path, std::string_view content);

/// The same with parts one after the other. \throw IoError
void
writeFile(const std::string& path, std::initializer_list<std::string_view> parts);

/// The same text for all names of a file, hard links too, whether it is there or not; empty for what is no file, as
/// /dev/null.
std::string
fileIdentity(const std::string& path);

/// Bytes that are read piece by piece: a file larger than memory, or what is in memory already.
class ByteSource {
public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource&
  operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;

  virtual std::uint64_t
  size() const = 0;
  /// Copy \p count bytes from byte \p at on; the caller has compared them with size(). \throw IoError
  virtual void
  read(std::uint64_t at, std::size_t count, char* to) const = 0;
  /// The first \p count bytes, or all where there are fewer. \throw IoError
  std::string
  first(std::uint64_t count) const;
};

/// Bytes in memory, which outlive this.
class MemoryBytes : public ByteSource {
public:
  explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
  std::uint64_t
  size() const override
  {
    return bytes_.size();
  }
  void
  read(std::uint64_t at, std::size_t count, char* to) const override
  {
    std::memcpy(to, bytes_.data() + at, count);
  }

private:
  std::string_view bytes_;
};

/// A regular file, of any length.
class FileBytes : public ByteSource {
public:
  /// \throw IoError as readFile()
  explicit FileBytes(const std::string& path);
  ~FileBytes() override;
  FileBytes(const FileBytes&) = delete;
  FileBytes&
  operator=(const FileBytes&) = delete;
  std::uint64_t
  size() const override
  {
    return size_;
  }
  void
  read(std::uint64_t at, std::size_t count, char* to) const override;

private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// The value of type T at byte \p at of \p bytes (little endian as stored); the caller has checked the bounds.
template <typename T>
T
valueAt(std::string_view bytes, std::size_t at)
{
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

} // namespace io
} // namespace pcl_ssfr
