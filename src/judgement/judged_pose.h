// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/visibility_score.h"
#include "refinement/refinement.h"

#include <pcl_ssfr/result.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <vector>

namespace pcl_ssfr {

/// A pose with what speaks for and against it.
struct JudgedPose {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< between the inner, centred frames
  SurfaceEvidence evidence;                                          ///< of both scans, each laid into the other
  double score = 0;
  double facing_score = 0; ///< of the patches that face their own sensor
  bool from_guess = false;
  std::optional<Refinement> polish; ///< last step of the polish, at this pose; none: it was not polished
};

/// Fill in \p evidence and the scores that follow from it: what speaks for a pose less kContradictionWeight times what
/// speaks against it, as shares of all voices.
void
rate(JudgedPose& pose, const SurfaceEvidence& evidence);

/// Best score first, from the pose \p first on; equal scores keep their order.
void
sortByScore(std::vector<JudgedPose>& poses, std::size_t first = 0);

/// How far one pose lies from another: at \p place of the source [m].
double
shiftBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place);

/// ... and how far it is turned against it [rad].
double
turnBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// What users are told of a pose; T_target_source is left to the caller, who knows the frames.
Candidate
describe(const JudgedPose& pose);

} // namespace pcl_ssfr
