// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/kitti_format.h>

#include <apps/io/file_bytes.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::size_t kPointBytes = 4 * sizeof(float);
constexpr float kMaxCoordinate = 1e6F; ///< no scanner sees farther; beyond it the file is something else [m]
constexpr std::size_t kProbe = 4096;   ///< bytes that decide whether a file is a text

bool
isText(std::string_view bytes)
{
  const std::string_view probe = bytes.substr(0, kProbe);
  return std::all_of(
      probe.begin(), probe.end(), [](char c) { return (c >= ' ' && c <= '~') || (c >= '\t' && c <= '\r'); });
}

} // namespace

RawCloud
readKitti(const std::string& path, std::string_view bytes)
{
  if (bytes.empty())
    throw IoError(path + ": is empty");
  if (isText(bytes))
    throw IoError(path + ": is a text, not a KITTI scan of 32-bit floats");
  if (bytes.size() % kPointBytes != 0)
    throw IoError(path + ": " + std::to_string(bytes.size()) + " bytes are not a whole number of KITTI points of " +
                  std::to_string(kPointBytes) + " bytes");
  RawCloud cloud;
  for (const char* name : {"x", "y", "z", "intensity"})
    addField(cloud.table, name, pcl::PCLPointField::FLOAT32);
  resizeTable(cloud.table, bytes.size() / kPointBytes);
  std::copy(bytes.begin(), bytes.end(), cloud.table.data.begin());
  for (std::size_t at = 0; at < bytes.size(); at += kPointBytes)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = valueAt<float>(bytes, at + k * sizeof(float));
      if (std::isfinite(value) && std::abs(value) > kMaxCoordinate)
        throw IoError(path + ": point " + std::to_string(at / kPointBytes) + " has " + "xyz"[k] + " = " +
                      std::to_string(value) + " m: not a KITTI scan");
    }
  return cloud;
}

} // namespace io
} // namespace pcl_ssfr
