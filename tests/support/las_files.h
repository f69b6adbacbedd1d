// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <io_testing.h>

#include <cstdint>
#include <string>

namespace pcl_ssfr::testing {

/// Replace the bytes of a value.
template <typename T>
void
put(std::string& bytes, std::size_t at, T value)
{
  bytes.replace(at, sizeof(T), bytesOf(value));
}

/// A LAS file of \p points points on a line, all optional values set.
inline std::string
makeLas(unsigned minor, unsigned format, std::uint16_t record, std::uint32_t points, double origin = 0)
{
  const std::size_t header = minor == 4 ? 375 : minor == 3 ? 235 : 227;
  std::string bytes(header, '\0');
  bytes.replace(0, 4, "LASF");
  put<std::uint8_t>(bytes, 24, 1);
  put(bytes, 25, static_cast<std::uint8_t>(minor));
  put(bytes, 94, static_cast<std::uint16_t>(header));
  put(bytes, 96, static_cast<std::uint32_t>(header));
  put(bytes, 104, static_cast<std::uint8_t>(format));
  put(bytes, 105, record);
  if (minor < 4)
    put(bytes, 107, points);
  else
    put<std::uint64_t>(bytes, 247, points);
  for (const std::size_t k : {0U, 1U, 2U}) {
    put(bytes, 131 + 8 * k, 0.001);
    put(bytes, 155 + 8 * k, origin);
  }
  for (std::uint32_t i = 0; i < points; ++i) {
    std::string point(record, '\0');
    put(point, 0, static_cast<std::int32_t>(1000 * i + 1));
    put(point, 4, static_cast<std::int32_t>(-2000));
    put(point, 8, static_cast<std::int32_t>(500));
    put(point, 12, static_cast<std::uint16_t>(40000));
    put(point, format < 6 ? 15 : 16, static_cast<std::uint8_t>(6));
    const std::size_t time = format == 0 || format == 2 ? 0 : format < 6 ? 20 : 22;
    const std::size_t rgb = format == 2                                  ? 20
                            : format == 3 || format == 5                 ? 28
                            : format == 7 || format == 8 || format == 10 ? 30
                                                                         : 0;
    if (time != 0)
      put(point, time, 1234.5);
    if (rgb != 0)
      for (const std::size_t k : {0U, 1U, 2U})
        put(point, rgb + 2 * k, static_cast<std::uint16_t>((k + 1) << 8));
    bytes += point;
  }
  return bytes;
}

} // namespace pcl_ssfr::testing
