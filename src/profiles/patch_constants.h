// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cstddef>

namespace pcl_ssfr {

// What the preparation of a scan and the registration of two, in the default profile, go by.
constexpr double kDistinctDistance = 0.3;   // [m] at scale 1: poses nearer than this, and alike in rotation, are one
constexpr double kRefitAngle = 0.12;        // [rad] what main normals tell of a direction is good to this
constexpr double kThickness = 0.03;         // [m] at scale 1, of a patch, at least
constexpr std::size_t kMinPoints = 50;      // finite points of a scan
constexpr int kAlikePoints = 4;             // of the polish: so many err alike
constexpr double kContradictionWeight = 14; // of the score: contradictions are rare and precious (METHOD point 14b)

} // namespace pcl_ssfr
