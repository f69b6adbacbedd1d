// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/dataset_simulation.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/** \brief Draw a scene into one PNG: from above to scale, and in perspective, with the places of the scans.
 *
 * Shaded by the ray caster. Where most of the path has a ceiling, everything above a cut is taken off; what the cut
 * goes through is drawn dark.
 * \param[in] surfaces what is drawn
 * \param[in] T_world_sensor poses, in order
 * \param[in] threads 0: all; the picture does not depend on it
 * \throw io::IoError, SimulationError
 */
void
drawScene(const std::string& path,
          const Scene& scene,
          const SurfaceModel& surfaces,
          const std::vector<Eigen::Isometry3d>& T_world_sensor,
          unsigned threads);

/** \brief Draw the scene of a plan, with its scans, as FOLDER/SCENE.png; the folder is made when it does not exist.
 * \throw io::IoError, SimulationError
 */
void
drawPlan(const std::string& folder, const PreparedPlan& prepared, unsigned threads);

} // namespace pcl_ssfr::simulation
