// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/drawing/drawing.h>
#include <apps/view/view_model.h>

#include <Eigen/Core>

namespace pcl_ssfr {
namespace apps {

/** \brief Half of a Gaussian sphere as a disc, as seen from above, areas kept (Lambert's projection): the density of
 * the directions and the densest regions.
 * \param[in] turn takes directions of the scan into the frame of the picture, z up
 * \param[in] threads 0: all processors
 */
void
drawSphere(cairo_surface_t* surface,
           cairo_t* context,
           const SphereView& sphere,
           const Eigen::Matrix3d& turn,
           bool upper,
           double x,
           double y,
           double radius,
           unsigned threads);

/// A numbered direction on such a disc, where it lies on this half.
void
drawSphereMark(cairo_t* context,
               const Eigen::Vector3d& direction,
               bool upper,
               double x,
               double y,
               double radius,
               int number,
               const Colour& colour,
               bool hollow);

/// What the colours of the density mean.
void
drawDensityKey(cairo_t* context, double x, double y);

} // namespace apps
} // namespace pcl_ssfr
