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
#include <vector>

namespace pcl_ssfr::testing {

/// What a reader says about bytes that it refuses. \throw std::logic_error when it is not one line that names the file
template <typename Read>
std::string
refusalOf(const std::string& name, const Read& read)
{
  try {
    read();
    return {};
  }
  catch (const io::IoError& error) {
    const std::string message = error.what();
    if (message.rfind(name.substr(0, name.find('#')), 0) != 0 || message.find_first_of("\r\n") != std::string::npos)
      throw std::logic_error("not one line that names " + name + ": " + message);
    return message;
  }
}

/// The numbers of a scan that was read whole, as loadScanPoints() gives them.
inline std::vector<float>
floatsOf(const io::LoadedCloud& cloud)
{
  std::vector<float> floats;
  for (const auto& point : *cloud.points) {
    floats.insert(floats.end(), point.data, point.data + 3);
    if (cloud.has_normals)
      floats.insert(floats.end(), point.data_n, point.data_n + 3);
  }
  return floats;
}

/// \throw std::logic_error when reading in little memory gave other points
inline void
requireSamePoints(const std::string& name, const io::LoadedCloud& cloud, const io::ScanPoints& points)
{
  const std::vector<float> floats = floatsOf(cloud);
  const bool is_same = points.size == cloud.points->size() && points.has_normals == cloud.has_normals &&
                       points.offset == cloud.offset && points.viewpoint == cloud.viewpoint &&
                       points.bytes.size() == floats.size() * sizeof(float) &&
                       (floats.empty() || std::memcmp(points.bytes.data(), floats.data(), points.bytes.size()) == 0);
  if (!is_same)
    throw std::logic_error(name + ": read in little memory it has other points");
}

/** \brief Read bytes that may be anything, as a file of this name.
 * \return what the reader says about them, empty when it takes them
 * \throw std::logic_error for a message that is not one line that names the file, for more points than bytes, and where
 * reading in little memory gives something else
 */
inline std::string
readAnyBytes(const std::string& name, std::string_view bytes)
{
  io::LoadedCloud cloud;
  io::ScanPoints points;
  const std::string refusal = refusalOf(name, [&] { cloud = io::parseCloud(name, bytes); });
  const std::string other = refusalOf(name, [&] { points = io::parseScanPoints(name, bytes); });
  if (!refusal.empty()) // what it leaves out may be what is wrong
    return refusal;
  if (!other.empty())
    throw std::logic_error("read in little memory: " + other);
  if (cloud.points->size() != io::pointCount(cloud.table))
    throw std::logic_error(name + ": the table has another number of points");
  if (cloud.points->size() > bytes.size()) // a file cannot justify more
    throw std::logic_error(name + ": more points than bytes");
  requireSamePoints(name, cloud, points);
  return {};
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
