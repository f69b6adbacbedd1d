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

/// How a pose graph is solved.
struct PoseGraphOptions {
  double robust_scale = 3;              ///< of Cauchy's loss, in standard deviations of a whole edge
  double least_sigma = 0.002;           ///< [m] and ...
  double least_sigma_rotation = 0.0005; ///< [rad] no edge is better known: dense scans claim far more than they know
  int iterations = 50;
};

/** \brief The poses that agree best with the edges, each weighted by its information (robust least squares).
 * \param[in] poses start, T_map_scan of each scan
 * \param[in] fixed the scans whose poses are kept, at least one of each part that edges connect, or the part may move
 * as a whole
 * \return poses; those of scans without edges are kept
 */
std::vector<Eigen::Isometry3d>
solvePoseGraph(std::vector<Eigen::Isometry3d> poses,
               const std::vector<PoseGraphEdge>& edges,
               const std::vector<int>& fixed,
               const PoseGraphOptions& options = {});

} // namespace pcl_ssfr
