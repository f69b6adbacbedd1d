// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/surface_model.h>

#include <Eigen/Core>

namespace pcl_ssfr::simulation {

/// The ground a thing covers: a rotated rectangle, and the heights it takes up.
struct Footprint {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero(); ///< [m]
  Eigen::Vector2d half = Eigen::Vector2d::Zero();   ///< half extents along its own axes [m]
  double yaw = 0;                                   ///< [rad]
  double low = 0;                                   ///< [m]
  double high = 0;                                  ///< [m]
};

/// Of a part that stands on \p foot, rotated by \p yaw.
Footprint
footprintOf(const SurfaceModel& part, const Eigen::Vector3d& foot, double yaw);
/// How far a part reaches from its origin on level ground, whatever its yaw [m].
double
reachOf(const SurfaceModel& part);
/// Whether two things are in each other's way.
bool
meet(const Footprint& a, const Footprint& b);
/// Level distance of a footprint to a segment (or to a point: the same one twice); 0 when they meet [m].
double
distance(const Footprint& footprint, const Eigen::Vector2d& from, const Eigen::Vector2d& to);

} // namespace pcl_ssfr::simulation
