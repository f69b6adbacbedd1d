// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>

namespace pcl_ssfr {

/// Text by a pattern of printf; cut after 511 characters.
template <typename... Values>
std::string
format(const char* pattern, Values... values)
{
  std::array<char, 512> buffer{};
  const int length = std::snprintf(buffer.data(), buffer.size(), pattern, values...);
  return {buffer.data(), std::min(buffer.size() - 1, static_cast<std::size_t>(std::max(length, 0)))};
}

} // namespace pcl_ssfr
