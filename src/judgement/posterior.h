// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/scored_pose.h"

#include <pcl_ssfr/patch_config.h>

#include <cstddef>
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
  PosteriorConfig lead;      ///< the model that asks how far a pose leads; what both ask of any
  RatioModelConfig ratios;   ///< the one that asks how many times as much speaks for it
  double chance_surface = 1; ///< that may meet by chance [m^2]
  double trust = 0.5;        ///< probability of the second model: which of them is right is not known
};

/// What it is for a pair of which both sensors' places are known or found, or not.
PosteriorModel
makePosteriorModel(const JudgementConfig& config, bool sees_free_space);

/** \brief Log odds of a pose against another one of its pair: what evidence and priors say for it, by that of the two
 * models that favours it.
 */
double
logOdds(const ScoredPose& pose, const ScoredPose& other, const PosteriorModel& model);

/** \brief The posterior of distinct poses.
 *
 * The average of two models. How sure one is that one of them is right follows from the evidence of its most probable
 * one alone.
 * \param[in] poses distinct, of one pair of scans, any order
 */
Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorModel& model);

/// Most probable first; equally probable poses keep their order.
void
sortByProbability(std::vector<ScoredPose>& poses, const PosteriorModel& model);

/// The pose that explains most first, with what is known beforehand: the most exact one of those at one place.
void
sortByScore(std::vector<ScoredPose>& poses, const PosteriorModel& model);

} // namespace pcl_ssfr
