// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <cmath>

namespace pcl_ssfr {

constexpr double kPi = static_cast<double>(EIGEN_PI);
constexpr double kDegree = kPi / 180; ///< one degree [rad]

/// Chord between two unit vectors that are \p angle [rad, 0..pi] apart: 2 sin(angle / 2).
inline double
chordFromAngle(double angle)
{
  return 2 * std::sin(angle / 2);
}

} // namespace pcl_ssfr
