// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <algorithm>
#include <ctime>

namespace pcl_ssfr::testing {

/// Processor time of a call, of all threads together, the least of three [s]: another program on the machine hardly
/// changes it, so that two of them can be compared.
template <typename Call>
double
processorSeconds(const Call& call)
{
  double least = 0;
  for (int run = 0; run < 3; ++run) {
    const std::clock_t before = std::clock();
    call();
    const double seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    least = run == 0 ? seconds : std::min(least, seconds);
  }
  return least;
}

} // namespace pcl_ssfr::testing
