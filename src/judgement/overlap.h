// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/detail/neighbor_index.h>

namespace pcl_ssfr {

/// How well one point set lies on another under a pose.
struct Overlap {
  double ratio = 0;         ///< inliers / points, [0, 1]; 0 for an empty source
  double kernel_sum = 0;    ///< sum of exp(-d / radius) over the inliers (LCP of 2019, METHOD stage 12)
  Eigen::Index inliers = 0; ///< source points with a target point nearer than the radius (LCP of 2017)
  double rmse = 0;          ///< root mean square distance of the inliers [m]
};

/** \brief Largest-common-pointset measure (paper, section 3.6): how many source points find a target point nearer than
 * \p radius [m] once moved by \p T_target_source. Public on its own. The result does not depend on \p threads.
 */
Overlap
computeOverlap(const Points3& source,
               const NeighborIndex& target,
               const Eigen::Isometry3d& T_target_source,
               double radius,
               unsigned threads = 1);

} // namespace pcl_ssfr
