// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/e57_pages.h>
#include <apps/io/loaded_cloud.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

namespace pcl_ssfr::testing {

/** \brief Read bytes that may be anything, as a file of this name.
 * \return what the reader says about them, empty when it takes them
 * \throw std::logic_error for a message that is not one line that names the file, and for more points than bytes
 */
inline std::string
readAnyBytes(const std::string& name, std::string_view bytes)
{
  try {
    const io::LoadedCloud cloud = io::parseCloud(name, bytes);
    if (cloud.points->size() != io::pointCount(cloud.table))
      throw std::logic_error(name + ": the table has another number of points");
    if (cloud.points->size() > bytes.size()) // a file cannot justify more
      throw std::logic_error(name + ": more points than bytes");
    return {};
  }
  catch (const io::IoError& error) {
    const std::string message = error.what();
    if (message.rfind(name.substr(0, name.find('#')), 0) != 0 || message.find_first_of("\r\n") != std::string::npos)
      throw std::logic_error("not one line that names " + name + ": " + message);
    return message;
  }
}

/// An E57 file whose length and checksums fit what was done to it, so that its reader looks at the rest.
inline std::string
repairE57(std::string_view bytes)
{
  std::string file(bytes);
  if (file.size() < io::kE57HeaderBytes)
    return file;
  std::uint64_t page_size = 0;
  std::memcpy(&page_size, file.data() + io::kE57PageSizeAt, sizeof(page_size));
  if (page_size < io::kE57HeaderBytes || page_size > file.size())
    return file;
  const auto step = static_cast<std::size_t>(page_size);
  const std::uint64_t length = file.size() / step * step;
  std::memcpy(file.data() + io::kE57LengthAt, &length, sizeof(length));
  for (std::size_t at = 0; at + step <= file.size(); at += step)
    io::sealE57Page(file.data() + at, step);
  return file;
}

} // namespace pcl_ssfr::testing
