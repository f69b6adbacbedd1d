// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cmath>

namespace pcl_ssfr {

/// Log odds of a probability, [0, 1]: infinite at both ends.
inline double
logit(double probability)
{
  return std::log(probability / (1 - probability));
}

} // namespace pcl_ssfr
