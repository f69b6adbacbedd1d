// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/scored_pose.h"

#include "common/rotation_math.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace pcl_ssfr {

namespace {

double
scoreOf(const WeightedEvidence& evidence, double contradiction_weight)
{
  return (evidence.matched - contradiction_weight * evidence.contradicted) / std::max(evidence.total, 1e-12);
}

} // namespace

HeldSurface
heldSurface(const SurfaceEvidence& evidence)
{
  if (!(evidence.matched_normals.trace() > 0))
    return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(evidence.matched_normals, Eigen::EigenvaluesOnly);
  return {std::max(0.0, solver.eigenvalues()[1]), std::max(0.0, solver.eigenvalues()[0])};
}

void
rate(ScoredPose& pose, const SurfaceEvidence& evidence, double contradiction_weight)
{
  pose.evidence = evidence;
  pose.held = heldSurface(evidence);
  pose.score = scoreOf(evidence.patches, contradiction_weight);
  pose.facing_score = scoreOf(evidence.facing, contradiction_weight);
}

double
translationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place)
{
  return (a * place - b * place).norm();
}

double
rotationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return angleBetween(a.linear(), b.linear());
}

Candidate
describe(const ScoredPose& pose)
{
  Candidate candidate;
  candidate.score = pose.score;
  candidate.from_guess = pose.from_guess;
  candidate.rmse = pose.polish ? pose.polish->rms : 0;
  const SurfaceEvidence& seen = pose.evidence;
  if (!(seen.total > 0))
    return candidate;
  candidate.overlap = seen.matched / seen.total;
  candidate.contradiction = seen.contradicted / seen.total;
  candidate.evidence.patches_matched = seen.patches.matched / seen.patches.total;
  candidate.evidence.patches_contradicted = seen.patches.contradicted / seen.patches.total;
  candidate.evidence.facing_matched = seen.facing.matched / std::max(seen.facing.total, 1e-12);
  candidate.evidence.beyond_planes = seen.facing.beyond / std::max(seen.facing.total, 1e-12);
  candidate.evidence.facing_score = pose.facing_score;
  candidate.evidence.unmatched = seen.unmatched / seen.total;
  candidate.evidence.third_direction = pose.held.third / seen.total;
  candidate.evidence.held_second = pose.held.second;
  candidate.evidence.held_third = pose.held.third;
  candidate.evidence.clutter = pose.evidence.clutter;
  candidate.evidence.patches = seen.patches.total;
  candidate.evidence.facing_patches = seen.facing.total;
  return candidate;
}

} // namespace pcl_ssfr
