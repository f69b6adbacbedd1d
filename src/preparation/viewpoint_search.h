// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/patch_config.h>

#include <Eigen/Core>

#include <optional>

namespace pcl_ssfr {

/** \brief Whether \p points look as if they were seen from \p place (METHOD, "The place of the sensor"): it rates
 * markedly higher than places around it, by many points or by fewer. Where it does not, as in a corridor or in the
 * open, free space constrains little as well.
 *
 * \param[in] points 3 x N, as dense as the sensor made them or evened out [m]
 * \param[in] place in the same frame [m]
 * \param[in] config lengths are those of this scene, see scaled()
 * \param[in] deadline when it passes meanwhile, the result is unspecified
 * \return false for no points, or a place that is not finite
 */
bool
isPlausibleViewpoint(const Eigen::Matrix3Xf& points,
                     const Eigen::Vector3f& place,
                     const PreparationConfig& config,
                     const Deadline& deadline = Deadline());

/** \brief A plausible viewpoint, found by trying places about the middle of the points: the one that rates highest.
 *
 * It need not be the sensor: in an empty room any place will do, and the free side of the walls is the same.
 * \param[in] points 3 x N, as dense as the sensor made them: they crowd around it [m]
 * \param[in] config lengths are those of this scene, see scaled()
 * \param[in] threads at least 1; the result does not depend on it
 * \param[in] deadline when it passes meanwhile, none is found
 * \return none when even the best place is not plausible
 */
std::optional<Eigen::Vector3f>
findViewpoint(const Eigen::Matrix3Xf& points,
              const PreparationConfig& config,
              unsigned threads,
              const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
