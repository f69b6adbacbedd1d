// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/patch_pair.h"

#include "profiles/patch_constants.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pcl_ssfr {

namespace {

// Lengths at scale 1 [m]; the scale of the scene multiplies them.
constexpr double kCoarseReach = 0.5;  // plane distance at the start of the coarse refinement ...
constexpr double kCoarseFinal = 0.15; // ... and at its end
constexpr double kFineReach = 0.2;    // of the fine refinement
constexpr double kFineFinal = 0.05;
constexpr double kFineStep = 0.0005; // the polish does the rest
constexpr double kPolishReach = 0.3; // of the polish
constexpr double kPolishFinal = 0.1;
constexpr double kLooseMatch = 0.2; // plane distance of a match after the coarse refinement ...
constexpr double kMatch = 0.1;      // ... after the fine one ...
constexpr double kLateral = 0.3;    // beyond the edge of a patch
constexpr double kFreeMargin = 0.3; // of the free space

// Angles [rad].
constexpr double kLooseNormals = 0.5; // normals of a match: in the search ...
constexpr double kNormals = 0.35;     // ... after the fine refinement
constexpr double kDistinctAngle = 0.05;

constexpr int kCoarseSteps = 6;
constexpr int kFineSteps = 15;
constexpr double kKeptScore = 0.9; // share of the score that a refinement, which makes the pose more exact, may cost

const RangeImage*
freeSpace(const PatchScan& scan)
{
  return scan.range_image.empty() ? nullptr : &scan.range_image;
}

std::optional<Eigen::Isometry3d>
betweenInnerFrames(const PatchScan& source, const PatchScan& target, const Eigen::Isometry3d* T_target_source)
{
  if (!T_target_source)
    return std::nullopt;
  return Eigen::Translation3d(-target.origin) * *T_target_source * Eigen::Translation3d(source.origin);
}

} // namespace

PatchPair::PatchPair(const PatchScan& source,
                     const PatchScan& target,
                     const Options& options,
                     const Eigen::Isometry3d* guess,
                     const Deadline& deadline)
    : source_(source), target_(target), options_(options), deadline_(deadline),
      scale_(std::max(source.scale, target.scale)),
      noise_(std::max(source.thickness, target.thickness) / (kThickness * scale_)),
      either_side_(!(source.patches.samples.oriented && target.patches.samples.oriented &&
                     source.viewpoint_used == target.viewpoint_used)),
      threads_(static_cast<int>(threadCount(options))),
      priors_(options, betweenInnerFrames(source, target, guess), source.viewpoint, scale_)
{}

const RangeImage*
PatchPair::targetImage() const
{
  return freeSpace(target_);
}

bool
PatchPair::seesFreeSpace() const
{
  return freeSpace(source_) && freeSpace(target_);
}

VisibilityOptions
PatchPair::searchTolerances() const
{
  return tolerances(kFreeMargin, kLooseNormals);
}

VisibilityOptions
PatchPair::fineTolerances() const
{
  return tolerances(matchDistance(), kNormals);
}

void
PatchPair::judgeCoarsely(JudgedPose& pose) const
{
  judge(pose, tolerances(kLooseMatch, kLooseNormals));
}

void
PatchPair::judgeFinely(JudgedPose& pose) const
{
  judge(pose, fineTolerances());
}

Eigen::Isometry3d
PatchPair::refinedCoarsely(const Eigen::Isometry3d& T_target_source) const
{
  const RefinementOptions options = refinement(kCoarseReach, kCoarseFinal, kLooseNormals, kCoarseSteps);
  return refinePatches(source_.coarse, target_.index, T_target_source, options).T_target_source;
}

Eigen::Isometry3d
PatchPair::refinedFinely(const Eigen::Isometry3d& T_target_source) const
{
  RefinementOptions options = refinement(kFineReach, kFineFinal, kNormals, kFineSteps);
  options.min_step = kFineStep * scale_;
  return refinePatches(source_.patches, target_.index, T_target_source, options).T_target_source;
}

void
PatchPair::polish(JudgedPose& pose) const
{
  RefinementOptions options = refinement(kPolishReach, kPolishFinal, kNormals, options_.max_refinement_steps);
  options.threads = threads_;
  if (options.vertical) // the errors of points on one patch are not independent
    options.vertical->deviation /= std::sqrt(kAlikePoints);
  const auto run = [&] {
    return refineMutual(source_.surface, source_.index, target_.surface, target_.index, pose.T_target_source, options);
  };
  if (options_.refine && !outOfTime()) {
    const Refinement refined = run();
    const Eigen::Isometry3d& T = refined.T_target_source;
    const bool near = isSamePlace(T, pose.T_target_source) && priors_.allow(T, Exactness::Refined);
    if (near && moveUnlessWorse(pose, T)) {
      pose.polish = refined;
      return;
    }
  }
  // What is told of the pose must be told of the one that is returned.
  options.steps = 1;
  options.match.distance = static_cast<float>(options.final_distance);
  pose.polish = run();
}

bool
PatchPair::moveUnlessWorse(JudgedPose& pose, const Eigen::Isometry3d& T_refined) const
{
  JudgedPose refined = pose;
  refined.T_target_source = T_refined;
  refined.polish.reset();
  judgeFinely(refined);
  if (refined.score < std::min(kKeptScore * pose.score, pose.score))
    return false;
  pose = refined;
  return true;
}

bool
PatchPair::isSamePlace(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const
{
  return shiftBetween(a, b, source_.viewpoint) < kDistinctDistance * scale_ && turnBetween(a, b) < kDistinctAngle;
}

Eigen::Isometry3d
PatchPair::toInner(const Eigen::Isometry3d& T_target_source) const
{
  return *betweenInnerFrames(source_, target_, &T_target_source);
}

Eigen::Isometry3d
PatchPair::toOuter(const Eigen::Isometry3d& T_target_source) const
{
  return Eigen::Translation3d(target_.origin) * T_target_source * Eigen::Translation3d(-source_.origin);
}

VisibilityOptions
PatchPair::tolerances(double distance, double angle) const
{
  VisibilityOptions options;
  options.match.either_side = either_side_;
  options.match.min_cos = static_cast<float>(std::cos(angle));
  options.match.distance = static_cast<float>(distance * scale_ * noise_);
  options.match.lateral = static_cast<float>(kLateral * scale_);
  options.free_margin = options.hidden_margin = static_cast<float>(kFreeMargin * scale_);
  return options;
}

/// Tolerance of a match that the caller may have set (Options::overlap_radius).
double
PatchPair::matchDistance() const
{
  // Callers of ICP are used to generous radii; beyond the coarse tolerance the evidence would tell nothing.
  return options_.overlap_radius > 0 ? std::min(options_.overlap_radius / (scale_ * noise_), kLooseMatch) : kMatch;
}

/// By the evidence of both scans, each laid into the other.
void
PatchPair::judge(JudgedPose& pose, const VisibilityOptions& options) const
{
  const Eigen::Isometry3d& T = pose.T_target_source;
  SurfaceEvidence both = collectEvidence(source_.patches.samples, target_.index, freeSpace(target_), T, options);
  SurfaceEvidence back =
      collectEvidence(target_.patches.samples, source_.index, freeSpace(source_), T.inverse(), options);
  back.matched_normals = (T.linear() * back.matched_normals * T.linear().transpose()).eval();
  back.visible_normals = (T.linear() * back.visible_normals * T.linear().transpose()).eval();
  rate(pose, both += back);
}

RefinementOptions
PatchPair::refinement(double reach, double final_distance, double angle, int steps) const
{
  RefinementOptions options;
  options.match = tolerances(reach, angle).match;
  options.final_distance = final_distance * scale_ * noise_;
  options.steps = steps;
  options.deadline = deadline_;
  options.vertical = priors_.vertical();
  return options;
}

} // namespace pcl_ssfr
