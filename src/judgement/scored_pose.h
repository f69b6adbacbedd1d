// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/visibility_score.h"
#include "refinement/refinement.h"

#include <pcl_ssfr/result.h>

#include <Eigen/Geometry>

#include <optional>

namespace pcl_ssfr {

/// Surface that holds a pose, by the directions that the matched surface faces: what faces one direction only may
/// slide. All in square metres.
struct HeldSurface {
  double second = 0; ///< matched, that faces the direction which the second largest share of it faces
  double third = 0;  ///< ... and which the least of it faces
};

/// The surface that holds a pose by its evidence; zeros where nothing matches.
HeldSurface
heldSurface(const SurfaceEvidence& evidence);

/// A pose with the evidence for and against it.
struct ScoredPose {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< between the inner, centred frames
  SurfaceEvidence evidence;                                          ///< of both scans, each in the other
  HeldSurface held;                                                  ///< heldSurface() of it
  double score = 0;
  double facing_score = 0; ///< of the patches that face their own sensor
  double log_prior = 0;    ///< of what is known beforehand, up to a constant of the pair
  bool from_guess = false;
  std::optional<Refinement> polish; ///< last step of the polish, at this pose; none: it was not polished
};

/// Fill in \p evidence, the surface that holds the pose and the scores that follow from it: matches less \p
/// contradiction_weight times contradictions, as shares of all patches.
void
rate(ScoredPose& pose, const SurfaceEvidence& evidence, double contradiction_weight);

/// The distance between where two poses put a \p place of the source [m].
double
translationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place);

/// The angle between their rotations [rad].
double
rotationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// A pose as users see it; T_target_source and the probability are left to the caller.
Candidate
describe(const ScoredPose& pose);

} // namespace pcl_ssfr
