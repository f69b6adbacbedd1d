// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/stage_clock.h"
#include "judgement/pose_uncertainty.h"
#include "profiles/hypothesis_source.h"
#include "profiles/patch_pair.h"

#include <vector>

namespace pcl_ssfr {

/// The most probable of some poses that differ (PatchPair::isSamePlace), at most \p most, most probable first.
std::vector<ScoredPose>
keepDistinct(const PatchPair& pair, std::vector<ScoredPose> poses, std::size_t most);

/** \brief Refine and score the poses of a batch, coarse and then fine, and merge them with those found before.
 * \param[in] known distinct; what was polished is not refined again
 * \return distinct poses, most probable first, at most batch.distinct (one more where the guess is among them)
 */
std::vector<ScoredPose>
refineAndMerge(const PatchPair& pair,
               const HypothesisBatch& batch,
               const std::vector<ScoredPose>& known,
               StageLog& stages);

/** \brief Polish the most probable pose and the rivals that come near it, so that their order does not depend on how
 * far the coarser refinements got; among the rivals are the optima in the neighbourhood of the best pose.
 * \param[in] poses distinct, most probable first, at least one
 * \return these and what was found near the best, distinct, most probable first; the first is polished, and so are its
 * rivals unless the time has run out
 */
std::vector<ScoredPose>
polishLeaders(const PatchPair& pair, std::vector<ScoredPose> poses, StageLog& stages);

/// The uncertainty of a pose that was polished; empty where it was not.
PoseUncertainty
uncertaintyOf(const PatchPair& pair, const ScoredPose& pose);

} // namespace pcl_ssfr
