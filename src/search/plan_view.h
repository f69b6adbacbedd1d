// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Geometry>

#include <vector>

namespace pcl_ssfr {

/// A piece of surface that faces across an axis, as it is seen along the axis.
struct PlanElement {
  float x, y;    ///< place across the axis [m]
  float height;  ///< place along it [m]
  float heading; ///< of the normal [rad], [-pi, pi]
  float weight;  ///< fourth root of its area [m^2]: a patch is one observation, and a large one is hardly surer
};

/// A point that fits no plane: of a crown, a hedge, a pole.
struct PlanPoint {
  float x, y;   ///< place across the axis [m]
  float height; ///< place along it [m]
};

/// A scan as plan views are drawn of it.
struct PlanScan {
  const OrientedSamples& samples;
  const Eigen::Matrix3Xf& clutter; ///< points that fit no plane, 3 x N [m]; may be empty
};

/// What of a scan determines a rotation about an axis and a shift across it.
struct PlanView {
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity(); ///< two directions across the axis, and the axis, as columns
  std::vector<PlanElement> elements;
  std::vector<PlanPoint> clutter;
  bool oriented = true; ///< false: the signs of the normals carry no information
};

/** \brief The samples that face across \p axis, unit, within 45 degrees: with the ground's normal for an axis, all but
 * the ground. And points that fit no plane: what stands upright may have no face.
 * \param[in] most elements that are kept, evenly drawn in their order, >= 1; of the points half as many, as each meets
 * many: they have no heading
 */
PlanView
drawPlanView(const PlanScan& scan, const Eigen::Vector3d& axis, int most);

/// Options of correlatePlanViews().
struct PlanCorrelationOptions {
  double cell = 1;   ///< step of the shifts [m]: elements and points meet within about one
  double height = 2; ///< [m] along the axis within which they meet
  double reach = 50; ///< largest shift along each of the two directions [m]; 250 cells at most are looked at
};

/// A rotation about the axis and a shift under which elements of two plan views meet.
struct PlanMatch {
  double angle = 0;                                ///< of the source's frame, about the axis [rad]
  Eigen::Vector2d shift = Eigen::Vector2d::Zero(); ///< then, across the axis, in the target's frame [m]
  /// Sum of the products of the weights of the elements that meet, times one and the number of points that meet.
  double score = 0;
};

/** \brief Correlate two plan views under one rotation about their axes: the local maxima over all shifts.
 *
 * Two elements meet where the shift lays one on the other to a cell and their normals face the same way within 22
 * degrees, two points wherever it does. Both are evidence by themselves, so they are multiplied: faces alone line up
 * wherever walls are parallel, points alone wherever bushes lie on bushes. Computed on elements, not on images: N_s N_t
 * / 8 additions of elements, N_s N_t of points.
 * \param[in] angle of the source [rad]
 * \param[in] offset of the source along the axis [m]
 * \param[in] most matches that are returned
 * \return highest score first; among equal ones in the order of their shifts. Empty when nothing meets
 */
std::vector<PlanMatch>
correlatePlanViews(const PlanView& source,
                   const PlanView& target,
                   double angle,
                   double offset,
                   const PlanCorrelationOptions& options,
                   int most);

/// The pose that a match means.
/// \param[in] offset of the source along the axis [m]
Eigen::Isometry3d
poseOf(const PlanView& source, const PlanView& target, const PlanMatch& match, double offset);

} // namespace pcl_ssfr
