// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/file_bytes.h>

#include <apps/io/output_file.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pcl_ssfr {
namespace io {

namespace {

std::string
systemMessage()
{
  return std::strerror(errno);
}

void
requireRegularFile(const std::string& path)
{
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw IoError(path + ": no such file");
  if (error)
    throw IoError(path + ": " + error.message());
  if (std::filesystem::is_directory(status))
    throw IoError(path + ": is a directory");
  if (!std::filesystem::is_regular_file(status))
    throw IoError(path + ": is not a regular file");
}

} // namespace

std::string
readFile(const std::string& path)
{
  requireRegularFile(path);
  const FilePtr file(std::fopen(path.c_str(), "rb"));
  if (!file)
    throw IoError(path + ": cannot be opened: " + systemMessage());
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error)
    throw IoError(path + ": " + error.message());
  std::string content(static_cast<std::size_t>(size), '\0');
  const std::size_t got = std::fread(content.data(), 1, content.size(), file.get());
  if (std::ferror(file.get()) != 0)
    throw IoError(path + ": cannot be read: " + systemMessage());
  content.resize(got);
  return content;
}

std::string
fileIdentity(const std::string& path)
{
  struct stat info {};
  if (::stat(path.c_str(), &info) == 0)
    return S_ISREG(info.st_mode) ? std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) : std::string();
  std::error_code error;
  return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error).string();
}

std::string
ByteSource::first(std::uint64_t count) const
{
  std::string bytes(static_cast<std::size_t>(std::min(count, size())), '\0');
  read(0, bytes.size(), bytes.data());
  return bytes;
}

FileBytes::FileBytes(const std::string& path) : path_(path)
{
  requireRegularFile(path);
  std::error_code error;
  size_ = std::filesystem::file_size(path, error);
  if (error)
    throw IoError(path + ": " + error.message());
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw IoError(path + ": cannot be opened: " + systemMessage());
}

FileBytes::~FileBytes()
{
  ::close(descriptor_);
}

void
FileBytes::read(std::uint64_t at, std::size_t count, char* to) const
{
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, to, count, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR)
      continue;
    if (got < 0)
      throw IoError(path_ + ": cannot be read: " + systemMessage());
    if (got == 0)
      throw IoError(path_ + ": became shorter while it was read");
    at += static_cast<std::uint64_t>(got);
    to += got;
    count -= static_cast<std::size_t>(got);
  }
}

void
writeFile(const std::string& path, std::string_view content)
{
  writeFile(path, {content});
}

void
writeFile(const std::string& path, std::initializer_list<std::string_view> parts)
{
  OutputFile file(path);
  for (const std::string_view part : parts)
    file.write(part);
  file.finish();
}

} // namespace io
} // namespace pcl_ssfr
