// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scenes.h>
#include <apps/simulation/sensor_model.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace pcl_ssfr::simulation {

/// How the sensor moves through a scene.
struct TrajectoryOptions {
  int scans = 2;                ///< >= 1
  double step = 0;              ///< distance of consecutive scans along the path [m]; 0: the scene's stations or step
  double overlap = 0;           ///< wanted overlap of consecutive scans, in (0, 1): decides the step; 0: not used
  double turn = 0.15;           ///< largest change of heading between consecutive scans beyond the path's own [rad]
  double tilt = 0;              ///< largest roll and pitch [rad]
  bool random_rotation = false; ///< every scan rotated at random about its sensor
  std::uint64_t seed = 1;
};

/** \brief Poses of the sensor (world from sensor) along the path of the scene, back and forth when it is too short.
 *
 * Scan k is k steps along the path, mount_height above it, and looks where the path leads (on the way back too). With
 * neither a step nor an overlap, in a scene with stations, scan k is at station k; the scans after the last station are
 * half way between each two of them, then a quarter, three quarters, and so on. With a
 * wanted overlap the step is searched for which visibleOverlap() of consecutive scans has that mean, within 0.05.
 * \throw SimulationError naming the setting; also when the overlap cannot be reached on this path
 */
std::vector<Eigen::Isometry3d>
makeTrajectory(const Scene& scene,
               const RayCaster& surfaces,
               const SensorModel& sensor,
               const TrajectoryOptions& options);

/** \brief Share of what the source sees that the target's sensor sees too: within its range and field of view, and not
 * hidden. By \p rays beams of the source, evenly taken.
 */
double
visibleOverlap(const RayCaster& scene,
               const SensorModel& source,
               const SensorModel& target,
               const Eigen::Isometry3d& T_world_source,
               const Eigen::Isometry3d& T_world_target,
               std::size_t rays = 2000);
/// Of two scans of the same sensor.
double
visibleOverlap(const RayCaster& scene,
               const SensorModel& sensor,
               const Eigen::Isometry3d& T_world_source,
               const Eigen::Isometry3d& T_world_target,
               std::size_t rays = 2000);

} // namespace pcl_ssfr::simulation
