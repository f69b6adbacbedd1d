// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/file_bytes.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace pcl_ssfr {
namespace io {

namespace {

struct FileCloser {
  void
  operator()(std::FILE* file) const
  {
    std::fclose(file);
  }
};
using FilePtr = std::unique_ptr<std::FILE, FileCloser>;

std::string
systemMessage()
{
  return std::strerror(errno);
}

} // namespace

std::string
readFile(const std::string& path)
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
  const FilePtr file(std::fopen(path.c_str(), "rb"));
  if (!file)
    throw IoError(path + ": cannot be opened: " + systemMessage());
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

void
writeFile(const std::string& path, std::string_view content)
{
  FilePtr file(std::fopen(path.c_str(), "wb"));
  if (!file)
    throw IoError(path + ": cannot be created: " + systemMessage());
  const bool written = std::fwrite(content.data(), 1, content.size(), file.get()) == content.size();
  if (!written || std::fclose(file.release()) != 0)
    throw IoError(path + ": cannot be written: " + systemMessage());
}

} // namespace io
} // namespace pcl_ssfr
