// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/judged_pose.h"

#include "common/rotation_math.h"
#include "profiles/patch_constants.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace pcl_ssfr {

namespace {

double
scoreOf(const Voices& voices)
{
  return (voices.matched - kContradictionWeight * voices.contradicted) / std::max(voices.total, 1e-12);
}

} // namespace

void
rate(JudgedPose& pose, const SurfaceEvidence& evidence)
{
  pose.evidence = evidence;
  pose.score = scoreOf(evidence.voices);
  pose.facing_score = scoreOf(evidence.facing);
}

void
sortByScore(std::vector<JudgedPose>& poses, std::size_t first)
{
  std::stable_sort(poses.begin() + static_cast<std::ptrdiff_t>(first),
                   poses.end(),
                   [](const JudgedPose& a, const JudgedPose& b) { return a.score > b.score; });
}

double
shiftBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place)
{
  return (a * place - b * place).norm();
}

double
turnBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return angleBetween(a.linear(), b.linear());
}

Candidate
describe(const JudgedPose& pose)
{
  Candidate candidate;
  candidate.score = pose.score;
  candidate.from_guess = pose.from_guess;
  const SurfaceEvidence& seen = pose.evidence;
  if (!(seen.total > 0))
    return candidate;
  candidate.overlap = seen.matched / seen.total;
  candidate.contradiction = seen.contradicted / seen.total;
  candidate.evidence.patches_matched = seen.voices.matched / seen.voices.total;
  candidate.evidence.patches_contradicted = seen.voices.contradicted / seen.voices.total;
  candidate.evidence.facing_matched = seen.facing.matched / std::max(seen.facing.total, 1e-12);
  candidate.evidence.facing_score = pose.facing_score;
  candidate.evidence.unmatched = seen.unmatched / seen.total;
  candidate.evidence.weakest_direction = weakestMatchedShare(seen);
  candidate.evidence.third_direction =
      std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(seen.matched_normals).eigenvalues()[0]) / seen.total;
  return candidate;
}

} // namespace pcl_ssfr
