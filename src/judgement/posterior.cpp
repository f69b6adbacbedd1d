// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/posterior.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr double kLeastShare = 0.001; // logarithms are taken of at least this share: less is no evidence

/// Log odds that the truth is among the poses of which \p best is the most probable one.
double
logOddsOfAny(const ScoredPose& best, const PosteriorConfig& config)
{
  const WeightedEvidence& facing = best.evidence.facing;
  const double clear = best.facing_score * facing.total / std::max(facing.matched, kLeastShare);
  return config.known + config.clear * std::log(std::clamp(clear, kLeastShare, 1.0)) +
         config.third * std::log(thirdDirection(best.evidence) + kLeastShare) +
         config.matches * std::log(facing.matched + 1);
}

} // namespace

double
logWeight(const ScoredPose& pose, const PosteriorConfig& config)
{
  return config.significance * pose.score * std::sqrt(pose.evidence.patches.total) +
         config.lead * std::log(std::max(pose.score, kLeastShare)) + pose.log_prior;
}

Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorConfig& config)
{
  Posterior posterior;
  if (poses.empty())
    return posterior;
  std::vector<double> weights;
  weights.reserve(poses.size());
  for (const ScoredPose& pose : poses)
    weights.push_back(logWeight(pose, config));
  const auto best = std::max_element(weights.begin(), weights.end());
  const ScoredPose& leader = poses[static_cast<std::size_t>(best - weights.begin())];
  const double largest = *best;
  double sum = 0;
  for (double& weight : weights)
    sum += weight = std::exp(weight - largest);
  const double any = leader.score > 0 ? 1 / (1 + std::exp(-logOddsOfAny(leader, config))) : 0;
  posterior.none = 1 - any;
  for (const double weight : weights)
    posterior.poses.push_back(any * weight / sum);
  return posterior;
}

void
sortByWeight(std::vector<ScoredPose>& poses, const PosteriorConfig& config)
{
  std::stable_sort(poses.begin(), poses.end(), [&](const ScoredPose& a, const ScoredPose& b) {
    return logWeight(a, config) > logWeight(b, config);
  });
}

} // namespace pcl_ssfr
