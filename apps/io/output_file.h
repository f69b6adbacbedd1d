// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

struct FileCloser {
  void
  operator()(std::FILE* file) const
  {
    std::fclose(file);
  }
};
using FilePtr = std::unique_ptr<std::FILE, FileCloser>;

/** \brief A file that is complete, or as it was before.
 *
 * Bytes go into "NAME.PID.part" next to it, which takes its place in finish(), with the permissions of the file that
 * was there. Links are followed. Written in place is what no other file can replace: devices and pipes, and a file in a
 * folder that takes no new one.
 */
class OutputFile {
public:
  /// \throw IoError when it cannot be created
  explicit OutputFile(const std::string& path);
  /// Removes what was not finished.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile&
  operator=(const OutputFile&) = delete;

  /// \throw IoError as fail()
  void
  write(std::string_view bytes);
  /// For what else is to be done with it, reading too.
  std::FILE*
  stream() const
  {
    return file_.get();
  }
  /// All bytes are written: let the file take its place. \throw IoError as fail()
  void
  finish();
  /// \throw IoError with the error of the system: the disk is full, mostly
  [[noreturn]] void
  fail() const;

private:
  std::string path_;   ///< as messages name it
  std::string target_; ///< what links lead to
  std::string part_;   ///< empty: written in place, or finished
  FilePtr file_;
};

/// For a look before hours of work. \throw IoError when no file of this name can be written
void
requireWritable(const std::string& path);

} // namespace io
} // namespace pcl_ssfr
