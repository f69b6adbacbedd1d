// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>

namespace pcl_ssfr {
namespace apps {

/// Wall clock since \p start [s].
inline double
secondsSince(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace apps
} // namespace pcl_ssfr
