// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <cstring>
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
 * \throw IoError when it cannot be created or not be written completely.
 */
void
writeFile(const std::string& path, std::string_view content);

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
