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

/** \brief Log weight of a pose among the other poses of its pair: what its evidence and its prior say for it.
 *
 * Sums of matches differ between poses by about the square root of their number when nothing but chance differs, so the
 * score counts in units of that, and its logarithm besides: a pose that explains twice as much as any other stands out
 * even where little is explained at all.
 */
double
logWeight(const ScoredPose& pose, const PosteriorConfig& config);

/** \brief The posterior of distinct poses, from one model (PosteriorConfig).
 *
 * How sure it is that one of them is right follows from the evidence of the most probable one alone; it is shared among
 * them by logWeight().
 * \param[in] poses distinct, of one pair of scans, any order
 */
Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorConfig& config);

/// Most probable first; equally probable poses keep their order.
void
sortByWeight(std::vector<ScoredPose>& poses, const PosteriorConfig& config);

} // namespace pcl_ssfr
