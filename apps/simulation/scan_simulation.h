// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/ray_caster.h>
#include <apps/simulation/sensor_model.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <vector>

namespace pcl_ssfr::simulation {

/// How a scan is taken.
struct ScanOptions {
  std::uint64_t seed = 1;                             ///< of noise and losses
  std::size_t scan = 0;                               ///< number of the scan: another one has other noise
  bool noise = true;                                  ///< false: exact ranges on exact beams, nothing lost in range
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< of the sensor during the scan, sensor frame [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero(); ///< [rad/s], sensor frame
  unsigned threads = 0;                                       ///< 0: all; the result does not depend on it
  std::function<void(double)> progress;                       ///< called now and then by one thread with the share done
};

/// A scan in the frame of the sensor at the start of the scan; with motion, distorted as an uncorrected scan is.
struct SimulatedScan {
  std::vector<Eigen::Vector3f> points; ///< returns in the order of firing [m]
  std::vector<float> intensity;        ///< reflectance times cosine of incidence, one a point, in [0, 1]
  std::vector<std::uint32_t> beam;     ///< index of the beam of each point
  std::size_t beams = 0;               ///< fired
  std::size_t out_of_range = 0;        ///< met nothing between min_range and max_range
  std::size_t lost = 0;                ///< too weak, or lost at random
  std::size_t mixed = 0;               ///< points that mix two surfaces
};

/** \brief Fire every beam of the sensor from \p T_world_sensor. The same arguments give the same bits.
 * Memory: the returns, and a fixed amount a thread.
 */
SimulatedScan
simulateScan(const RayCaster& scene,
             const SensorModel& sensor,
             const Eigen::Isometry3d& T_world_sensor,
             const ScanOptions& options);

} // namespace pcl_ssfr::simulation
