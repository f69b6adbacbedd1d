// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/posterior.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr double kLeastShare = 0.001; // logarithms are taken of at least this share: less is no evidence

/// Probability that the truth is among the poses of which \p best is the most probable one.
double
probabilityOfAny(const ScoredPose& best, const PosteriorModel& model)
{
  const SurfaceEvidence& evidence = best.evidence;
  if (!(evidence.matched > 0))
    return 0;
  const double third = best.held.third / evidence.total;
  double log_odds = model.surface.known + model.surface.any_third * std::log(third + kLeastShare) +
                    model.surface.any_matches * std::log1p(evidence.facing.beyond);
  if (model.space)
    log_odds += std::log1p(evidence.clutter) - std::log1p(evidence.facing.contradicted);
  return 1 / (1 + std::exp(-log_odds));
}

/** \brief Log weight of a pose among those of its pair.
 *
 * How much evidence there is of a place depends on what the sensors saw of it, so an amount counts by its logarithm.
 * Some of each may be chance: one match, one point, a square of surface; a share of contradictions, added in squares.
 */
double
logWeight(const ScoredPose& pose, const PosteriorModel& model)
{
  const SurfaceEvidence& evidence = pose.evidence;
  const auto times = [&](double surface) { return std::log1p(surface / model.chance_surface); };
  double weight = model.surface.matches * std::log1p(evidence.facing.beyond) +
                  model.surface.second * times(pose.held.second) + model.surface.third * times(pose.held.third) +
                  pose.log_prior;
  if (model.space) {
    const double chance = std::max(model.chance_contradictions * evidence.patches.total, kLeastShare);
    weight += model.space->clutter * std::log1p(evidence.clutter) -
              model.space->contradictions * std::log(std::hypot(1, evidence.patches.contradicted / chance));
  }
  return weight;
}

} // namespace

PosteriorModel
makePosteriorModel(const JudgementConfig& config, bool sees_free_space, double scale)
{
  const double chance_surface = scale * scale;
  if (sees_free_space)
    return {config.posterior, config.free_space, chance_surface, config.chance_contradictions};
  // Where one sensor's place is known, what it alone saw through counts for nothing.
  return {config.posterior_blind, std::nullopt, chance_surface, config.chance_contradictions};
}

double
logOdds(const ScoredPose& pose, const ScoredPose& other, const PosteriorModel& model)
{
  return logWeight(pose, model) - logWeight(other, model);
}

Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  if (poses.empty())
    return {};
  Posterior posterior;
  posterior.poses.reserve(poses.size());
  for (const ScoredPose& pose : poses)
    posterior.poses.push_back(logWeight(pose, model));
  const double largest = *std::max_element(posterior.poses.begin(), posterior.poses.end());
  double right = 0, sum = 0;
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (posterior.poses[k] == largest) // whichever comes first
      right = std::max(right, probabilityOfAny(poses[k], model));
  for (double& weight : posterior.poses)
    sum += weight = std::exp(weight - largest);
  for (double& weight : posterior.poses)
    weight *= right / sum;
  posterior.none = 1 - right;
  return posterior;
}

void
sortByProbability(std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  const std::vector<double> probabilities = computePosterior(poses, model).poses;
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return probabilities[a] > probabilities[b]; });
  std::vector<ScoredPose> sorted;
  sorted.reserve(poses.size());
  for (const std::size_t k : order)
    sorted.push_back(std::move(poses[k]));
  poses = std::move(sorted);
}

void
sortByScore(std::vector<ScoredPose>& poses)
{
  std::stable_sort(
      poses.begin(), poses.end(), [](const ScoredPose& a, const ScoredPose& b) { return a.score > b.score; });
}

} // namespace pcl_ssfr
