// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/output_file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <unistd.h>

namespace pcl_ssfr {
namespace io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 200; ///< bytes of a name that the name of its part begins with

/// Where the bytes go until the file is complete; empty: into the file itself.
std::string
partOf(const fs::path& target)
{
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (fs::exists(status) && (!fs::is_regular_file(status) || access(folder.c_str(), W_OK) != 0))
    return {};
  const std::string name = target.filename().string().substr(0, kLongestName);
  return (folder / (name + "." + std::to_string(getpid()) + ".part")).string();
}

/// The standard output is one of them, whatever it is redirected to.
bool
isOfTheSystem(const std::string& path)
{
  return path.rfind("/dev/", 0) == 0 || path.rfind("/proc/", 0) == 0;
}

} // namespace

OutputFile::OutputFile(const std::string& path) : path_(path), target_(path)
{
  std::error_code error;
  if (!isOfTheSystem(path)) {
    if (fs::is_symlink(path, error))
      target_ = fs::weakly_canonical(path, error).string();
    part_ = partOf(target_);
  }
  const bool is_there = fs::exists(target_, error);
  // A file that is protected stays, though another one could take its place.
  if (!is_there || access(target_.c_str(), W_OK) == 0)
    file_.reset(std::fopen((part_.empty() ? target_ : part_).c_str(), "w+b"));
  if (!file_)
    throw IoError(path + ": cannot be created: " + std::strerror(errno));
  if (is_there && !part_.empty())
    fs::permissions(part_, fs::status(target_, error).permissions(), error);
}

OutputFile::~OutputFile()
{
  if (!part_.empty())
    unlink(part_.c_str());
}

void
OutputFile::write(std::string_view bytes)
{
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size())
    fail();
}

void
OutputFile::finish()
{
  if (std::fclose(file_.release()) != 0)
    fail();
  if (!part_.empty() && std::rename(part_.c_str(), target_.c_str()) != 0)
    fail();
  part_.clear();
}

void
OutputFile::fail() const
{
  throw IoError(path_ + ": cannot be written: " + std::strerror(errno));
}

void
requireWritable(const std::string& path)
{
  std::error_code error;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  if (fs::is_directory(path, error))
    throw IoError(path + ": is a directory");
  if (!fs::is_directory(folder, error))
    throw IoError(path + ": the folder " + folder.string() + " does not exist");
  if (access(fs::exists(path, error) ? path.c_str() : folder.c_str(), W_OK) != 0)
    throw IoError(path + ": cannot be written");
}

} // namespace io
} // namespace pcl_ssfr
