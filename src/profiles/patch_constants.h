// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cstddef>

namespace pcl_ssfr {

// What the preparation of a scan and the registration of two, in the default profile, go by.
constexpr std::size_t kMinPoints = 50; // finite points of a scan
/// Points of the polish on one patch that err together: the weight of a known vertical beside the matches allows for
/// it.
constexpr int kCorrelatedPointsPerPatch = 4;

} // namespace pcl_ssfr
