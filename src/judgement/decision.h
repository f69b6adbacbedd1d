// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/pose_uncertainty.h"
#include "judgement/posterior.h"
#include "judgement/scored_pose.h"

#include <pcl_ssfr/patch_config.h>
#include <pcl_ssfr/result.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace pcl_ssfr {

/// What the decision goes by, besides the poses.
struct DecisionContext {
  Posterior posterior;                                             ///< of the poses
  PoseUncertainty uncertainty;                                     ///< of the first pose; empty: it was not polished
  JudgementConfig config;                                          ///< its numbers
  double min_confidence = 0.7;                                     ///< Options::min_confidence
  Eigen::Vector3d source_viewpoint = Eigen::Vector3d::Zero();      ///< inner frame [m]: poses are compared there
  double distinct_distance = RefinementConfig{}.distinct_distance; ///< poses nearer than this there [m] ...
  double distinct_angle = RefinementConfig{}.distinct_angle;       ///< ... and than this [rad] are one
  std::string few_directions; ///< which scan has planes in fewer than two directions; empty: neither
  bool is_cut_short = false;  ///< the search was not complete when the time ran out
};

/// What users read about the best pose.
struct Decision {
  Status status = Status::NotRun;
  std::string message;                             ///< one sentence, for people
  double confidence = 0;                           ///< estimated probability that the best pose is right, [0, 1]
  std::vector<UnobservableDirection> unobservable; ///< target frame; filled whatever the status
};

/** \brief Decide on the most probable of some distinct poses (METHOD, "Decision"): never a confident wrong pose.
 *
 * All follows from the posterior, the uncertainty and whether the search was complete, b being the confidence that is
 * asked for. The confidence is the probability of the first pose, JudgementConfig::unsettled at most where a direction
 * is not determined or the search was cut short. A direction that the scene does not determine, where the truth is
 * probably among the poses or much of the surface meets: unobservable. The truth is probably not among the poses (none
 * > 1 - b, or certainly not): contradicted or low overlap, whichever is the reason. Else the first pose is accepted
 * from b on; less than b, though the truth probably is among the poses, is ambiguous. Where poses that are one but for
 * a shift along a line have b together, that line is not determined, and all else is.
 * \param[in] poses distinct, most probable first, at least one
 */
Decision
decide(const std::vector<ScoredPose>& poses, const DecisionContext& context);

} // namespace pcl_ssfr
