// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "search/plan_view.h"
#include "search/pose_search.h"

#include <pcl_ssfr/patch_config.h>

#include <functional>
#include <vector>

namespace pcl_ssfr {

/// A direction of the source and the direction of the target that it is laid on, unit.
struct AxisPair {
  Eigen::Vector3d source = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d target = Eigen::Vector3d::UnitZ();
};

/** \brief Pairs of main normals, one of which the scans probably have in common: each of the best supported ones of the
 * source with each of those of the target. Of two pairs that are opposite in both scans, the first is kept: they allow
 * the same rotations.
 * \param[in] config sweep_axes: of each scan; direction_error: two directions within it are one
 */
std::vector<AxisPair>
pairAxes(const std::vector<MainNormal>& source, const std::vector<MainNormal>& target, const SearchConfig& config);

/// Options of searchPlans().
struct PlanSearchOptions {
  int elements = PreparationConfig{}.coarse_patches; ///< of a scan that are correlated, and half as many points, >= 1
  double cell = 2 * RefinementConfig{}.coarse_reach; ///< [m] step of the shifts, in which heights meet too
  int rotations = SearchConfig{}.sweep_steps;        ///< rotations about an axis, >= 1
  int matches = SearchConfig{}.much_overlap.refined; ///< that are voted on, >= 1
  double reach = 50;                                 ///< largest shift across an axis [m]
  PoseSearchOptions voting; ///< how places vote on poses: step, visibility, config and deadline are read
  int threads = 1;          ///< the bits do not depend on it
  std::function<bool(const Eigen::Isometry3d&)> is_allowed; ///< empty: every pose
};

/** \brief Poses under which one direction of the scans agrees: for scans that have no other main normal in common.
 *
 * The shift along the axis is the highest peak of the correlation along it (of the ground, with its normal for an
 * axis). Seen along the axis, what faces across it is correlated under rotations all around it and every shift across
 * it. The best matches are moved to and fro within a cell and a step of the rotation to where most places of the source
 * vote for them and fewest against them, as in the search for scans that share little.
 * \return distinct poses, those with the most votes for each one against them first
 */
std::vector<PoseHypothesis>
searchPlans(const PlanScan& source,
            const VotingSamples& votes,
            const PlanScan& target,
            const PatchIndex& target_index,
            const RangeImage* target_image,
            const AxisPair& axes,
            const PlanSearchOptions& options);

} // namespace pcl_ssfr
