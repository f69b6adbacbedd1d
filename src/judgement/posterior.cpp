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

/** \brief Log weight of a pose by how far it leads.
 *
 * Sums of matches differ between poses by about the square root of their number when nothing but chance differs, so the
 * score counts in units of that, and its logarithm besides: a pose that explains twice as much as any other stands out
 * even where little is explained at all.
 */
double
logWeight(const ScoredPose& pose, const PosteriorConfig& config)
{
  return config.significance * pose.score * std::sqrt(pose.evidence.patches.total) +
         config.lead * std::log(std::max(pose.score, kLeastShare)) + pose.log_prior;
}

/** \brief Log weight of a pose by how well it is held.
 *
 * Ground laid on ground matches wherever it is laid, so matches in two directions say less than a few in the third. One
 * patch may be chance, and enough of them are enough.
 */
double
logWeight(const ScoredPose& pose, const DirectionModelConfig& config)
{
  const double patches = thirdDirection(pose.evidence) * pose.evidence.patches.total;
  return config.significance * pose.score * std::sqrt(pose.evidence.patches.total) +
         config.third * std::log((patches + 1) / (patches + config.enough)) + pose.log_prior;
}

/// How the poses, at least one, share their probability by one model.
template <typename Config>
std::vector<double>
sharesBy(const Config& config, const std::vector<ScoredPose>& poses)
{
  std::vector<double> shares;
  shares.reserve(poses.size());
  for (const ScoredPose& pose : poses)
    shares.push_back(logWeight(pose, config));
  const double largest = *std::max_element(shares.begin(), shares.end());
  double sum = 0;
  for (double& share : shares)
    sum += share = std::exp(share - largest);
  for (double& share : shares)
    share /= sum;
  return shares;
}

/// How they share it by both.
std::vector<double>
sharesOf(const std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  std::vector<double> shares = sharesBy(model.lead, poses);
  const std::vector<double> others = sharesBy(model.directions, poses);
  for (std::size_t k = 0; k < shares.size(); ++k)
    shares[k] += model.directions.trust * (others[k] - shares[k]);
  return shares;
}

} // namespace

double
logOdds(const ScoredPose& pose, const ScoredPose& other, const PosteriorModel& model)
{
  return std::max(logWeight(pose, model.lead) - logWeight(other, model.lead),
                  logWeight(pose, model.directions) - logWeight(other, model.directions));
}

Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  Posterior posterior;
  if (poses.empty())
    return posterior;
  posterior.poses = sharesOf(poses, model);
  const auto best = std::max_element(posterior.poses.begin(), posterior.poses.end());
  const ScoredPose& leader = poses[static_cast<std::size_t>(best - posterior.poses.begin())];
  const double any = leader.score > 0 ? 1 / (1 + std::exp(-logOddsOfAny(leader, model.lead))) : 0;
  posterior.none = 1 - any;
  for (double& probability : posterior.poses)
    probability *= any;
  return posterior;
}

void
sortByProbability(std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  if (poses.empty())
    return;
  const std::vector<double> shares = sharesOf(poses, model);
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return shares[a] > shares[b]; });
  std::vector<ScoredPose> sorted;
  sorted.reserve(poses.size());
  for (const std::size_t k : order)
    sorted.push_back(std::move(poses[k]));
  poses = std::move(sorted);
}

void
sortByScore(std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  std::stable_sort(poses.begin(), poses.end(), [&](const ScoredPose& a, const ScoredPose& b) {
    return logWeight(a, model.lead) > logWeight(b, model.lead);
  });
}

} // namespace pcl_ssfr
