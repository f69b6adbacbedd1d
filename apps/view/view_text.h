// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/view/view_model.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// Text as printf writes it, at most 500 bytes.
template <typename... Values>
std::string
formatted(const char* pattern, Values... values)
{
  std::array<char, 500> buffer{};
  const int length = std::snprintf(buffer.data(), buffer.size(), pattern, values...);
  return {buffer.data(), std::min(buffer.size() - 1, static_cast<std::size_t>(std::max(length, 0)))};
}

/// One line: the answer, or why there is none.
std::string
headlineOf(const ViewModel& model);

/// One line about a pose: the motion, the evidence, the error.
std::string
describePose(const ViewedPose& pose);

/// Sentences about the run, the most important first.
std::vector<std::string>
describeFacts(const ViewModel& model);

/// All of it for a terminal.
std::string
describeRun(const ViewModel& model);

} // namespace apps
} // namespace pcl_ssfr
