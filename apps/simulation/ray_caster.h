// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/surface_model.h>

#include <Eigen/Core>

#include <memory>
#include <optional>

namespace pcl_ssfr::simulation {

/// Where a ray meets a surface.
struct RayHit {
  double distance = 0; ///< along the ray [m], > 0; computed in double from the surface that was hit
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(); ///< unit, of the surface, towards the ray's origin
  std::uint16_t material = 0;
};

/** \brief Finds the first surface along a ray (Embree). Const calls may come from any number of threads.
 *
 * Triangles through Embree's watertight ("robust") tests, spheres and tubes as user geometry solved in double. The
 * instruction set is pinned, so the same scene gives the same bits on every x86-64 machine that has it.
 */
class RayCaster {
public:
  /// \throw SimulationError what validate(model) throws, and when Embree has no device or no memory
  explicit RayCaster(const SurfaceModel& model);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster&
  operator=(RayCaster&&) noexcept;

  /// First surface along origin + t * direction with t in (min_distance, max_distance); \p direction is a unit vector.
  std::optional<RayHit>
  cast(const Eigen::Vector3d& origin,
       const Eigen::Vector3d& direction,
       double max_distance,
       double min_distance = 0) const;
  /// True when nothing lies between two points but within 1 mm of either.
  bool
  isVisible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  /// The materials of the model.
  const Material&
  material(std::uint16_t index) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace pcl_ssfr::simulation
