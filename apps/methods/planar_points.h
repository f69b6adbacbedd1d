// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/comparison_methods.h>

#include <Eigen/Core>

namespace pcl_ssfr {
namespace apps {

/** \brief The points of a thinned scan that lie on planes, with normals towards the sensor: those that a refiner may
 * move a pose by that is nearly right. Near edges, and where points lie on one line, a normal is nothing to rely on.
 * \param[in] sensor its place in the frame of the cloud [m]
 * \param[in] radius of the neighbours that make a plane [m]
 * \param[in] thickness largest standard deviation across it [m]
 * \param[in] threads only change the speed
 */
MethodCloud::Ptr
planarPoints(
    const MethodCloud& cloud, const Eigen::Vector3d& sensor, double radius, double thickness, unsigned threads);

} // namespace apps
} // namespace pcl_ssfr
