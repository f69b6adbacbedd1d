// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/plan_search.h"

#include "common/angles.h"
#include "common/parallel.h"
#include "search/vote_count.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace pcl_ssfr {

namespace {

/// All that a pose between two plan views needs.
struct Plans {
  PlanView source;
  PlanView target;
  double offset = 0; ///< of the source along the axis [m]
};

std::vector<MainNormal>
bestSupported(const std::vector<MainNormal>& normals, int most)
{
  std::vector<MainNormal> best = normals;
  std::stable_sort(
      best.begin(), best.end(), [](const MainNormal& a, const MainNormal& b) { return a.support > b.support; });
  best.resize(std::min(best.size(), static_cast<std::size_t>(most)));
  return best;
}

/// The best matches of all rotations, none of which is next to a better one.
std::vector<PlanMatch>
findMatches(const Plans& plans, const PlanSearchOptions& options)
{
  PlanCorrelationOptions correlation;
  correlation.cell = correlation.height = options.cell;
  correlation.reach = options.reach;
  const double step = 2 * kPi / options.rotations;
  std::vector<std::vector<PlanMatch>> found(static_cast<std::size_t>(options.rotations));
  forEachInParallel(options.rotations, 1, options.threads, [&](std::int64_t i) {
    if (options.voting.deadline.hasPassed())
      return;
    std::vector<PlanMatch>& matches = found[static_cast<std::size_t>(i)];
    matches = correlatePlanViews(plans.source,
                                 plans.target,
                                 static_cast<double>(i) * step,
                                 plans.offset,
                                 correlation,
                                 options.is_allowed ? std::numeric_limits<int>::max() : options.matches);
    if (options.is_allowed)
      matches.erase(std::remove_if(matches.begin(),
                                   matches.end(),
                                   [&](const PlanMatch& m) {
                                     return !options.is_allowed(poseOf(plans.source, plans.target, m, plans.offset));
                                   }),
                    matches.end());
  });
  std::vector<PlanMatch> all;
  for (const std::vector<PlanMatch>& some : found)
    all.insert(all.end(), some.begin(), some.end());
  std::stable_sort(all.begin(), all.end(), [](const PlanMatch& a, const PlanMatch& b) { return a.score > b.score; });
  std::vector<PlanMatch> best;
  for (const PlanMatch& match : all) {
    if (best.size() >= static_cast<std::size_t>(options.matches))
      break;
    const bool is_next_to_better = std::any_of(best.begin(), best.end(), [&](const PlanMatch& other) {
      return std::abs(std::remainder(match.angle - other.angle, 2 * kPi)) < 1.5 * step &&
             (match.shift - other.shift).norm() < 1.5 * options.cell;
    });
    if (!is_next_to_better)
      best.push_back(match);
  }
  return best;
}

} // namespace

std::vector<AxisPair>
pairAxes(const std::vector<MainNormal>& source, const std::vector<MainNormal>& target, const SearchConfig& config)
{
  const std::vector<MainNormal> best_source = bestSupported(source, config.sweep_axes);
  const std::vector<MainNormal> best_target = bestSupported(target, config.sweep_axes);
  const double opposite = -std::cos(config.direction_error);
  std::vector<AxisPair> pairs;
  for (const MainNormal& s : best_source)
    for (const MainNormal& t : best_target) {
      const bool is_known = std::any_of(pairs.begin(), pairs.end(), [&](const AxisPair& other) {
        return other.source.dot(s.direction) < opposite && other.target.dot(t.direction) < opposite;
      });
      if (!is_known)
        pairs.push_back({s.direction, t.direction});
    }
  return pairs;
}

std::vector<PoseHypothesis>
searchPlans(const PlanScan& source,
            const VotingSamples& votes,
            const PlanScan& target,
            const PatchIndex& target_index,
            const RangeImage* target_image,
            const AxisPair& axes,
            const PlanSearchOptions& options)
{
  Plans plans;
  plans.source = drawPlanView(source, axes.source, options.elements);
  plans.target = drawPlanView(target, axes.target, options.elements);
  const std::vector<ShiftPeak> offsets =
      findPeaks(correlateAlongAxis(source.samples, target.samples, axes.source, axes.target, options.voting).sum,
                searchPeakOptions(options.voting, 1));
  if (!offsets.empty())
    plans.offset = offsets.front().shift;
  const std::vector<PlanMatch> matches = findMatches(plans, options);

  // A match is known to a cell and a step of the rotation; votes need it better.
  const double step = options.voting.step;
  const double angle_step = 2 * kPi / options.rotations / 3;
  const int lines = static_cast<int>(std::ceil(options.cell / (2 * step)));
  const Eigen::Vector3d along = plans.target.frame.col(0);
  const Eigen::Vector3d across = plans.target.frame.col(1);
  std::vector<PoseHypothesis> found(matches.size());
  forEachInParallel(static_cast<std::int64_t>(matches.size()), 1, options.threads, [&](std::int64_t i) {
    PoseHypothesis& best = found[static_cast<std::size_t>(i)];
    if (options.voting.deadline.hasPassed())
      return;
    for (const int k : {0, -1, 1}) {
      PlanMatch match = matches[static_cast<std::size_t>(i)];
      match.angle += k * angle_step;
      const Eigen::Isometry3d T = poseOf(plans.source, plans.target, match, plans.offset);
      const VoteCounter counter(votes, target_index, target_image, T.linear(), options.voting.visibility);
      std::vector<VotedTranslation> voted;
      for (int line = -lines; line <= lines; ++line) {
        const Eigen::Vector3d start = T.translation() + 2 * line * step * across - 2 * lines * step * along;
        findLeastContradicted(
            counter,
            {start.cast<float>(), (step * along).cast<float>(), static_cast<std::size_t>(4 * lines + 1)},
            options.voting.config,
            best.score,
            voted);
      }
      for (const VotedTranslation& candidate : voted) {
        const double score = candidate.score / static_cast<double>(std::max<Eigen::Index>(1, counter.size()));
        if (best.votes > 0 && score <= best.score)
          continue;
        best.T_target_source.linear() = T.linear();
        best.T_target_source.translation() = candidate.translation.cast<double>();
        best.score = score;
        best.votes = candidate.votes;
      }
    }
  });
  const auto is_nothing = [&](const PoseHypothesis& h) {
    return h.votes == 0 || (options.is_allowed && !options.is_allowed(h.T_target_source));
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_nothing), found.end());
  std::stable_sort(
      found.begin(), found.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  return found;
}

} // namespace pcl_ssfr
