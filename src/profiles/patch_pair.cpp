// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/patch_pair.h"

#include "common/config_numbers.h"
#include "judgement/pose_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pcl_ssfr {

namespace {

/// The numbers for a pair; the match distance is the radius of the options where that is given.
PatchProfileConfig
configFor(const PatchScan& source, const PatchScan& target, const Options& options, double scale)
{
  const double usual = options.patch_profile.preparation.thickness * scale;
  PatchProfileConfig config =
      scaledForPair(options.patch_profile, scale, std::max({1.0, source.thickness / usual, target.thickness / usual}));
  // Callers of ICP are used to generous radii; beyond the coarse tolerance the evidence would say nothing.
  if (options.overlap_radius > 0)
    config.preparation.match = std::min(options.overlap_radius, config.judgement.evidence.loose_match);
  return config;
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
      scale_(std::max(source.scale, target.scale)), config_(configFor(source, target, options, scale_)),
      either_side_(!(source.patches.samples.oriented && target.patches.samples.oriented &&
                     source.viewpoint_used == target.viewpoint_used)),
      threads_(static_cast<int>(threadCount(options))),
      priors_(options, betweenInnerFrames(source, target, guess), source.viewpoint, source.extent.radius, config_)
{}

bool
PatchPair::seesFreeSpace() const
{
  return source_.freeSpace() && target_.freeSpace();
}

VisibilityOptions
PatchPair::searchTolerances() const
{
  return tolerances(config_.judgement.evidence.loose_match, config_.preparation.loose_facing);
}

VisibilityOptions
PatchPair::fineTolerances() const
{
  return tolerances(config_.preparation.match, config_.preparation.same_facing);
}

SurfaceEvidence
PatchPair::evidenceAt(const Eigen::Isometry3d& T_target_source, const VisibilityOptions& tolerances) const
{
  const Eigen::Isometry3d& T = T_target_source;
  const Eigen::Isometry3d T_back = T.inverse();
  SurfaceEvidence both = collectEvidence(source_.patches.samples, target_.index, target_.freeSpace(), T, tolerances);
  SurfaceEvidence back =
      collectEvidence(target_.patches.samples, source_.index, source_.freeSpace(), T_back, tolerances);
  back.matched_normals = (T.linear() * back.matched_normals * T.linear().transpose()).eval();
  both += back;
  const float tolerance = tolerances.match.distance;
  both.clutter = static_cast<double>(countAtDepth(source_.clutter, target_.range_image, T, tolerance) +
                                     countAtDepth(target_.clutter, source_.range_image, T_back, tolerance));
  return both;
}

void
PatchPair::scoreCoarse(ScoredPose& pose) const
{
  score(pose, searchTolerances());
}

void
PatchPair::scoreFine(ScoredPose& pose) const
{
  score(pose, fineTolerances());
}

Eigen::Isometry3d
PatchPair::refinedCoarse(const Eigen::Isometry3d& T_target_source) const
{
  const RefinementConfig& c = config_.refinement;
  const double end = config_.judgement.evidence.loose_match;
  const RefinementOptions options = refinement(c.coarse_reach, end, config_.preparation.loose_facing, c.coarse_steps);
  return refinePatches(source_.coarse, target_.index, T_target_source, options).T_target_source;
}

Eigen::Isometry3d
PatchPair::refinedFine(const Eigen::Isometry3d& T_target_source) const
{
  const RefinementConfig& c = config_.refinement;
  const PreparationConfig& matches = config_.preparation;
  RefinementOptions options =
      refinement(config_.judgement.evidence.loose_match, matches.match, matches.same_facing, c.fine_steps);
  options.min_step = c.match_noise;
  return refinePatches(source_.patches, target_.index, T_target_source, options).T_target_source;
}

void
PatchPair::polish(ScoredPose& pose) const
{
  if (options_.refine && !outOfTime()) {
    RefinementOptions options = polishOptions();
    const auto refinedFrom = [&](const Eigen::Isometry3d& T) {
      return refineMutual(sourceSurface(), targetSurface(), T, options);
    };
    Refinement refined = refinedFrom(pose.T_target_source);
    const double distance = matchDistance(refined, refined.T_target_source);
    const int wide_steps = refined.steps;
    options.steps -= wide_steps;
    if (distance < options.final_distance && options.steps > 0) {
      options.match.distance = static_cast<float>(distance);
      refined = refinedFrom(refined.T_target_source);
      refined.steps += wide_steps;
    }
    const Eigen::Isometry3d& T = refined.T_target_source;
    const bool near = isSamePlace(T, pose.T_target_source) && priors_.allow(T, Exactness::Refined);
    if (near && moveUnlessWorse(pose, T)) {
      pose.polish = refined;
      return;
    }
  }
  // What is said of the pose must hold for the one that is returned.
  pose.polish = fitAt(pose.T_target_source);
}

Refinement
PatchPair::fitAt(const Eigen::Isometry3d& T_target_source) const
{
  RefinementOptions options = lastStep();
  Refinement wide = refineMutual(sourceSurface(), targetSurface(), T_target_source, options);
  const double distance = matchDistance(wide, T_target_source);
  if (distance >= config_.preparation.match)
    return wide;
  options.match.distance = static_cast<float>(distance);
  return refineMutual(sourceSurface(), targetSurface(), T_target_source, options);
}

MutualFit
PatchPair::fitInMap(const Eigen::Isometry3d& T_target_source) const
{
  RefinementOptions options = lastStep();
  options.threads = 1; // pairs of a map are worked on at once
  return fitMutual(sourceSurface(), targetSurface(), T_target_source, options, noiseRule());
}

NoiseRule
PatchPair::noiseRule() const
{
  NoiseRule rule;
  rule.deviations = config_.judgement.uncertainty.bound_deviations;
  rule.most = config_.preparation.match;
  rule.least = std::min(rule.most, 2 * rule.deviations * config_.refinement.match_noise);
  return rule;
}

double
PatchPair::matchDistance(const Refinement& wide, const Eigen::Isometry3d& T_target_source) const
{
  NoiseRule rule = noiseRule();
  const double floor = noiseFloor(config_.judgement.uncertainty, wide.rms);
  const std::vector<PrincipalMotion> motions = poseUncertainty(wide, floor).motions;
  rule.pose_deviation = motions.empty() ? rule.most : motions.front().deviation;
  return mutualMatchDistance(sourceSurface(), targetSurface(), T_target_source, lastStep(), rule);
}

RefinementOptions
PatchPair::lastStep() const
{
  const double match = config_.preparation.match;
  return refinement(match, match, config_.preparation.same_facing, 1);
}

bool
PatchPair::moveUnlessWorse(ScoredPose& pose, const Eigen::Isometry3d& T_refined) const
{
  ScoredPose refined = pose;
  refined.T_target_source = T_refined;
  refined.polish.reset();
  scoreFine(refined);
  if (refined.score < std::min(config_.refinement.kept_score * pose.score, pose.score))
    return false;
  pose = refined;
  return true;
}

bool
PatchPair::isSamePlace(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const
{
  return translationBetween(a, b, source_.viewpoint) < config_.refinement.distinct_distance &&
         rotationBetween(a, b) < config_.refinement.distinct_angle;
}

bool
PatchPair::laysSensorOnSensor(const Eigen::Isometry3d& T_target_source) const
{
  return seesFreeSpace() && (T_target_source * source_.viewpoint - target_.viewpoint).norm() < binWidth();
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

ScanSurface
PatchPair::sourceSurface() const
{
  return {source_.surface, source_.index};
}

ScanSurface
PatchPair::targetSurface() const
{
  return {target_.surface, target_.index};
}

RefinementOptions
PatchPair::polishOptions() const
{
  return refinement(
      polishReach(), config_.preparation.match, config_.preparation.same_facing, options_.max_refinement_steps);
}

VisibilityOptions
PatchPair::tolerances(double distance, double angle) const
{
  const double margin = config_.preparation.margin, range_margin = config_.judgement.evidence.range_margin;
  VisibilityOptions options;
  options.match.either_side = either_side_;
  options.match.min_cos = static_cast<float>(std::cos(angle));
  options.match.distance = static_cast<float>(distance);
  options.match.lateral = static_cast<float>(margin);
  options.free_margin = options.hidden_margin = static_cast<float>(margin);
  options.free_ratio = static_cast<float>(1 - range_margin);
  options.hidden_ratio = static_cast<float>(1 + range_margin);
  return options;
}

void
PatchPair::score(ScoredPose& pose, const VisibilityOptions& options) const
{
  const Eigen::Isometry3d& T = pose.T_target_source;
  SurfaceEvidence both = evidenceAt(T, options);
  // The fourth root of an area grows with the square root of the scale: the posterior counts patches at scale 1.
  both.patches *= 1 / std::sqrt(scale_);
  both.facing *= 1 / std::sqrt(scale_);
  rate(pose, both, config_.judgement.evidence.contradiction_weight);
  pose.log_prior =
      priors_.logPrior(T) + (laysSensorOnSensor(T) ? std::log(config_.judgement.prior.sensor_on_sensor) : 0.0);
}

RefinementOptions
PatchPair::refinement(double reach, double final_distance, double angle, int steps) const
{
  RefinementOptions options;
  options.match = tolerances(reach, angle).match;
  options.final_distance = final_distance;
  options.steps = steps;
  options.threads = threads_;
  options.least_rms = config_.refinement.match_noise;
  options.unseen_curvature = config_.judgement.uncertainty.unseen_curvature;
  options.deadline = deadline_;
  options.vertical = priors_.vertical();
  return options;
}

} // namespace pcl_ssfr
