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

/// Probability that the truth is among the poses of which \p best is the most probable one, with \p log_odds of what
/// its model alone looks at.
double
probabilityOfAny(const ScoredPose& best, double log_odds, const PosteriorConfig& config)
{
  const double third = best.evidence.total > 0 ? best.held.third / best.evidence.total : 0;
  return 1 / (1 + std::exp(-(config.known + log_odds + config.third * std::log(third + kLeastShare) +
                             config.matches * std::log(best.evidence.facing.matched + 1))));
}

/// The same by the model that asks how far a pose leads: by what contradictions, weighted as in the score, leave.
double
probabilityOfAny(const ScoredPose& best, const PosteriorConfig& config)
{
  if (!(best.score > 0))
    return 0;
  const WeightedEvidence& facing = best.evidence.facing;
  const double clear = best.facing_score * facing.total / std::max(facing.matched, kLeastShare);
  return probabilityOfAny(best, config.clear * std::log(std::clamp(clear, kLeastShare, 1.0)), config);
}

/// ... and by the one of ratios: by how many times as many patches contradict, and points stand where they were seen.
double
probabilityOfAny(const ScoredPose& best, const PosteriorConfig& config, const RatioModelConfig& ratios)
{
  if (!(best.evidence.matched > 0))
    return 0;
  const double log_odds = ratios.known + ratios.any_clutter * std::log1p(best.evidence.clutter) -
                          ratios.any_contradictions * std::log1p(best.evidence.facing.contradicted);
  return probabilityOfAny(best, log_odds, config);
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

/** \brief Log weight of a pose by how many times as much evidence it has.
 *
 * How much evidence there is of a place depends on what the sensors saw of it. So an amount counts by its logarithm,
 * and the first of the directions not at all: ground laid on ground matches wherever it is laid. One patch may be
 * chance.
 */
double
logWeight(const ScoredPose& pose, const RatioModelConfig& config, double chance_surface)
{
  const auto times = [&](double surface) { return std::log1p(surface / chance_surface); };
  return config.second * times(pose.held.second) + config.third * times(pose.held.third) +
         config.clutter * std::log1p(pose.evidence.clutter) -
         config.contradictions * std::log1p(pose.evidence.patches.contradicted) + pose.log_prior;
}

/// The posterior over poses, at least one, by a model that gives each a log weight, and the best the probability that
/// it or another one is right.
template <typename LogWeight, typename Any>
Posterior
posteriorBy(const std::vector<ScoredPose>& poses, const LogWeight& log_weight, const Any& any)
{
  Posterior posterior;
  posterior.poses.reserve(poses.size());
  for (const ScoredPose& pose : poses)
    posterior.poses.push_back(log_weight(pose));
  const double largest = *std::max_element(posterior.poses.begin(), posterior.poses.end());
  double right = 0, sum = 0;
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (posterior.poses[k] == largest) // whichever comes first
      right = std::max(right, any(poses[k]));
  for (double& weight : posterior.poses)
    sum += weight = std::exp(weight - largest);
  for (double& weight : posterior.poses)
    weight *= right / sum;
  posterior.none = 1 - right;
  return posterior;
}

} // namespace

PosteriorModel
makePosteriorModel(const JudgementConfig& config, bool sees_free_space)
{
  const double chance_surface = config.chance_edge * config.chance_edge;
  if (sees_free_space)
    return {config.posterior, config.ratios, chance_surface};
  // Where one sensor's place is known, what it alone saw through counts for nothing.
  RatioModelConfig blind = config.ratios;
  blind.known = blind.any_clutter = blind.any_contradictions = 0;
  blind.second = blind.clutter = blind.contradictions = 0;
  blind.third = config.ratios.blind_third;
  return {config.posterior_blind, blind, chance_surface};
}

double
logOdds(const ScoredPose& pose, const ScoredPose& other, const PosteriorModel& model)
{
  return std::max(logWeight(pose, model.lead) - logWeight(other, model.lead),
                  logWeight(pose, model.ratios, model.chance_surface) -
                      logWeight(other, model.ratios, model.chance_surface));
}

Posterior
computePosterior(const std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  if (poses.empty())
    return {};
  Posterior posterior = posteriorBy(
      poses,
      [&](const ScoredPose& pose) { return logWeight(pose, model.lead); },
      [&](const ScoredPose& best) { return probabilityOfAny(best, model.lead); });
  const Posterior ratios = posteriorBy(
      poses,
      [&](const ScoredPose& pose) { return logWeight(pose, model.ratios, model.chance_surface); },
      [&](const ScoredPose& best) { return probabilityOfAny(best, model.lead, model.ratios); });
  for (std::size_t k = 0; k < poses.size(); ++k)
    posterior.poses[k] += model.trust * (ratios.poses[k] - posterior.poses[k]);
  posterior.none += model.trust * (ratios.none - posterior.none);
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
sortByScore(std::vector<ScoredPose>& poses, const PosteriorModel& model)
{
  std::stable_sort(poses.begin(), poses.end(), [&](const ScoredPose& a, const ScoredPose& b) {
    return logWeight(a, model.lead) > logWeight(b, model.lead);
  });
}

} // namespace pcl_ssfr
