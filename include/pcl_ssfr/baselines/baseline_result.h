// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <string>

namespace pcl_ssfr::baselines {

/// What a comparison method found, and why it is or is not taken for an answer.
struct BaselineResult {
  bool converged = false; ///< the pose passed the method's own acceptance test
  std::string message;    ///< the reason, one sentence without full stop
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< best pose found, accepted or not
  double overlap = 0;              ///< share of the thinned source within \ref inlier_distance of the target, [0, 1]
  double inlier_distance = 0;      ///< distance threshold in force [m]
  double leaf = 0;                 ///< edge of the thinning voxels in force [m]; 0: not thinned
  std::size_t source_points = 0;   ///< after thinning
  std::size_t target_points = 0;   ///< after thinning
  std::size_t correspondences = 0; ///< matches that the pose was computed from; 0 where a method has none
  std::size_t inliers = 0;         ///< of them, those nearer than \ref inlier_distance
  int iterations = 0;              ///< steps, or samples tried
};

} // namespace pcl_ssfr::baselines
