// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/judged_pose.h"
#include "refinement/refinement.h"

#include <pcl_ssfr/result.h>

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// What is known of two scans, beside the poses found, when the answer is judged.
struct DecisionContext {
  double min_confidence = 0.7; ///< Options::min_confidence
  double scale = 1;            ///< of the scene: lengths in the decision are for scale 1
  double noise_floor = 0.001;  ///< least standard deviation of plane distances [m]
  bool free_space = true;      ///< both sensors are known: contradictions can be seen, both ways
  Eigen::Vector3d source_viewpoint = Eigen::Vector3d::Zero(); ///< inner frame [m]: poses are compared there
  Eigen::Vector3d target_viewpoint = Eigen::Vector3d::Zero(); ///< inner frame [m]; read where there is free space
  /// What a gravity prior and the tolerance of a guess tell of the rotation: information [1/rad^2], target frame, in
  /// the currency of the matches, which claim more than they know.
  Eigen::Matrix3d rotation_prior = Eigen::Matrix3d::Zero();
  bool guess_decides = false; ///< the guess has told the best pose from those that explain the scans as well
  std::string few_directions; ///< which scan has planes in fewer than two directions; empty: neither
};

/// Whether the best pose is accepted, and if not, why not.
struct Decision {
  Status status = Status::NotRun;
  std::string message;                             ///< one sentence, for people
  double confidence = 0;                           ///< estimated probability that the best pose is right, [0, 1]
  std::vector<UnobservableDirection> unobservable; ///< target frame; filled whatever the status
  std::size_t equals = 1; ///< poses that explain the scans about as well as the best one, itself included
};

/** \brief Decide on the best of some distinct poses (METHOD, "decision"): never a confident wrong pose.
 *
 * In this order: too little surface in common; a motion that the scene does not tell; other poses that explain the
 * scans as well; the confidence. \param[in] poses distinct, best first, at least one \param[in] polish the last
 * refinement of the first of them; without matches: it was not polished yet, and nothing is said of what the scene
 * tells
 */
Decision
decide(const std::vector<JudgedPose>& poses, const Refinement& polish, const DecisionContext& context);

} // namespace pcl_ssfr
