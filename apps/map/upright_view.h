// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What the drawings show of a scan, in its own frame.
struct ScanOutline {
  Eigen::Matrix3Xd points;                         ///< some of its surface [m]
  std::vector<Eigen::Vector3d> normals;            ///< unit, of its main surfaces
  std::vector<double> weights;                     ///< of these, > 0
  Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< of its sensor [m]
};

/** \brief A rotation that draws a building upright: z is its vertical, and most walls go along x and y.
 *
 * The vertical is the mean of the scans' z axes where these agree within 14 degrees; else the axis along which the
 * points extend least, as in most buildings. Then the normals near it decide. For drawings only.
 * \param[in] points of the building [m]
 * \param[in] normals unit, of its surfaces
 * \param[in] weights of these
 * \param[in] axes z axes of its scans, unit; all in one frame
 * \return maps that frame into the drawing
 */
Eigen::Matrix3d
uprightView(const std::vector<Eigen::Vector3d>& points,
            const std::vector<Eigen::Vector3d>& normals,
            const std::vector<double>& weights,
            const std::vector<Eigen::Vector3d>& axes);

} // namespace apps
} // namespace pcl_ssfr
