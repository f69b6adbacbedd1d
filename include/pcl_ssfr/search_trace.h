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
  double votes = 0;     ///< share of votes for it, less the weighted share of votes against it
  bool refined = false; ///< it was refined and scored; else the posterior had decided before its turn
};

/// One pass of the search.
struct TracedPass {
  bool little_overlap = false;              ///< by votes against poses: the pass for scans that share little
  std::vector<Eigen::Matrix3d> rotations;   ///< R_target_source that were searched, best supported first
  std::vector<TracedHypothesis> hypotheses; ///< most votes first
};

/** \brief What a registration by Profile::Default proposed and looked at: shows where a true pose was lost.
 *
 * Filled by registerScans() when one is handed to it; the result is the same with and without.
 */
struct SearchTrace {
  std::vector<TracedPass> passes; ///< in the order in which they were made
  /// After these, poses under which the scans agree in one direction, most votes first; empty: not looked for, or none.
  std::vector<TracedHypothesis> plan_hypotheses;
};

} // namespace pcl_ssfr
