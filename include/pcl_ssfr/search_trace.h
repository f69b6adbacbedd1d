// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace pcl_ssfr {

/// A pose that the search for translations proposed.
struct TracedHypothesis {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< maps source points into the target frame
  double votes = 0;     ///< share of votes for it, less twice the share against it; in the pass for scans that share
                        ///< little, and by plan views, the share for it over the number against it and one
  bool refined = false; ///< it was refined and scored; else the posterior had decided before its turn
};

/// One pass of the search.
struct TracedPass {
  bool little_overlap = false;              ///< the pass for scans that share little
  std::vector<Eigen::Matrix3d> rotations;   ///< R_target_source that were searched, best supported first
  std::vector<TracedHypothesis> hypotheses; ///< best first, by their votes
};

/** \brief The hypotheses of a registration by Profile::Default: shows at which stage a true pose was lost.
 *
 * registerScans() fills it when given one; its result is the same with and without.
 */
struct SearchTrace {
  std::vector<TracedPass> passes; ///< in the order in which they were made
  /// Proposed last, by plan views (one main normal in common), best first; empty: not searched, or none found.
  std::vector<TracedHypothesis> plan_hypotheses;
};

} // namespace pcl_ssfr
