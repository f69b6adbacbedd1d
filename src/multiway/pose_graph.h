// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace pcl_ssfr {

/// A measured pose between two scans.
struct PoseGraphEdge {
  int source = 0;
  int target = 0;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  /// Inverse covariance of a small motion (rotation [rad], translation [m]) on the left about the target's origin.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
};

/** \brief The poses that agree best with the edges, each weighted by its information (robust least squares).
 * \param[in] poses start, T_map_scan of each scan; the first is kept, and scans that no edges connect with it may move
 * as a whole
 * \return poses; those of scans without edges are kept
 */
std::vector<Eigen::Isometry3d>
solvePoseGraph(std::vector<Eigen::Isometry3d> poses, const std::vector<PoseGraphEdge>& edges);

} // namespace pcl_ssfr
