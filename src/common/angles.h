// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

constexpr double kPi = static_cast<double>(EIGEN_PI);
constexpr double kDegree = kPi / 180;           ///< one degree [rad]
constexpr double kDegreesPerRadian = 180 / kPi; ///< one radian [deg]

/// Chord between two unit vectors that are \p angle [rad, 0..pi] apart: 2 sin(angle / 2).
inline double
chordFromAngle(double angle)
{
  return 2 * std::sin(angle / 2);
}

/// Angle [rad] between two unit vectors that are \p chord [0..2] apart.
inline double
angleFromChord(double chord)
{
  return 2 * std::asin(std::clamp(chord / 2, -1.0, 1.0));
}

} // namespace pcl_ssfr
