// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/scored_pose.h"

#include <pcl_ssfr/patch_config.h>

#include <optional>
#include <vector>

namespace pcl_ssfr {

/// Probabilities of the distinct poses of a pair and of "none of them is right"; they sum to 1.
struct Posterior {
  std::vector<double> poses; ///< of each pose, in their order
  double none = 1;           ///< the truth is not among them

  /// Probability of the first pose; 0 when there is none.
  double
  best() const
  {
    return poses.empty() ? 0 : poses.front();
  }
};

/// What a posterior is computed with.
struct PosteriorModel {
  PosteriorConfig surface;              ///< what the matched surface says
  std::optional<FreeSpaceConfig> space; ///< what free space says; nothing where it was not seen
  double chance_surface = 1;            ///< that may meet by chance [m^2]
  double chance_contradictions = 0;     ///< share of the patches that may contradict by chance
};

/// What it is for a pair of which both sensors' places are known or found, or not. \param[in] scale of the pair, > 0
PosteriorModel
makePosteriorModel(const JudgementConfig& config, bool sees_free_space, double scale = 1);

/// Log odds of a pose against another one of its pair: what evidence and priors say for it.
double
logOdds(const ScoredPose& pose, const ScoredPose& other, const PosteriorModel& model);

/** \brief The posterior of distinct poses.
 *
 * How sure it is that one of them is right follows from the evidence of the most probable one alone.
 * \param[in] poses distinct, of one pair of scans, any order
 */
Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorModel& model);

/// Most probable first; equally probable poses keep their order.
void
sortByProbability(std::vector<ScoredPose>& poses, const PosteriorModel& model);

/// The pose that explains most first: the most exact one of those at one place. Equal ones keep their order.
void
sortByScore(std::vector<ScoredPose>& poses);

} // namespace pcl_ssfr
