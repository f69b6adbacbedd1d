// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <functional>
#include <vector>

namespace pcl_ssfr::benchmarks {

/// The upper median; the values must not be empty.
inline double
median(std::vector<double> values)
{
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median of what \p clock [s] advances by in \p runs calls.
inline double
medianAdvance(int runs, const std::function<double()>& clock, const std::function<void()>& call)
{
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) {
    const double start = clock();
    call();
    seconds.push_back(clock() - start);
  }
  return median(seconds);
}

/// Median wall clock time of \p runs calls [s].
inline double
medianSeconds(int runs, const std::function<void()>& call)
{
  const auto now = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  return medianAdvance(runs, now, call);
}

/// Median processor time of \p runs calls, all threads of the process together [s].
inline double
medianCpuSeconds(int runs, const std::function<void()>& call)
{
  const auto now = [] { return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC); };
  return medianAdvance(runs, now, call);
}

} // namespace pcl_ssfr::benchmarks
