// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/hypothesis_graph.h"

#include "common/parallel.h"
#include "judgement/scored_pose.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr int kLoopRounds = 4;
constexpr double kSmallest = 1e-6; // probability that is still distinguished from none

/// Hypotheses of a pair as seen from one scan to the other.
class Directed {
public:
  /// \param[in] least_belief of a hypothesis below which its loops are not looked at
  Directed(const std::vector<PairLink>& links, const HypothesisGraph& graph, std::size_t scans, double least_belief)
      : links_(links), graph_(graph), least_belief_(least_belief), partners_(scans)
  {
    for (std::size_t k = 0; k < links.size(); ++k) {
      const auto i = static_cast<std::size_t>(links[k].source);
      const auto j = static_cast<std::size_t>(links[k].target);
      partners_[i].emplace_back(j, k);
      partners_[j].emplace_back(i, k);
    }
    for (auto& partners : partners_)
      std::sort(partners.begin(), partners.end());
  }

  /// Call \p visit(c, link of a and c, link of c and b) for all scans that have links with both, in ascending order.
  template <typename Visit>
  void
  forEachBetween(std::size_t a, std::size_t b, const Visit& visit) const
  {
    auto from_a = partners_[a].begin(), from_b = partners_[b].begin();
    while (from_a != partners_[a].end() && from_b != partners_[b].end()) {
      if (from_a->first < from_b->first)
        ++from_a;
      else if (from_b->first < from_a->first)
        ++from_b;
      else {
        visit(from_a->first, from_a->second, from_b->second);
        ++from_a;
        ++from_b;
      }
    }
  }
  /// The pose of hypothesis \p h, mapping points of \p from.
  Eigen::Isometry3d
  pose(const WeighedHypothesis& h, std::size_t from) const
  {
    const PairLink& link = links_[h.link];
    const Eigen::Isometry3d& T = link.hypotheses[h.rank].T_target_source;
    return static_cast<std::size_t>(link.source) == from ? T : T.inverse();
  }
  /// Call \p visit for the hypotheses of a link that matter.
  template <typename Visit>
  void
  forEach(std::size_t link, const Visit& visit) const
  {
    for (std::size_t h = graph_.first[link]; h < graph_.first[link + 1]; ++h)
      if (graph_.hypotheses[h].belief >= least_belief_)
        visit(graph_.hypotheses[h]);
  }

private:
  const std::vector<PairLink>& links_;
  const HypothesisGraph& graph_;
  double least_belief_;
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> partners_; ///< of each scan: the other one, their link
};

/// Sure loops that close with each hypothesis of a link, less those that do not.
std::vector<double>
countLoops(std::size_t k,
           const std::vector<PairLink>& links,
           const HypothesisGraph& graph,
           const Directed& directed,
           const std::vector<Eigen::Vector3d>& places,
           const ChoiceConfig& config)
{
  const auto i = static_cast<std::size_t>(links[k].source);
  const auto j = static_cast<std::size_t>(links[k].target);
  const std::size_t count = graph.first[k + 1] - graph.first[k];
  std::vector<double> loops(count, 0.0);
  std::vector<double> closing(count);
  directed.forEachBetween(i, j, [&](std::size_t c, std::size_t to_c, std::size_t from_c) {
    std::fill(closing.begin(), closing.end(), 0.0);
    double strongest = 0;
    directed.forEach(to_c, [&](const WeighedHypothesis& first) {
      directed.forEach(from_c, [&](const WeighedHypothesis& second) {
        const double weight = first.belief * second.belief;
        strongest = std::max(strongest, weight);
        const Eigen::Isometry3d T = directed.pose(second, c) * directed.pose(first, i);
        for (std::size_t m = 0; m < count; ++m)
          if (weight > closing[m] && agree(T, links[k].hypotheses[m].T_target_source, places[i], config))
            closing[m] = weight;
      });
    });
    for (std::size_t m = 0; m < count; ++m)
      loops[m] += closing[m] - (strongest - closing[m]);
  });
  return loops;
}

} // namespace

bool
agree(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place, const ChoiceConfig& config)
{
  return translationBetween(a, b, place) < config.same_translation && rotationBetween(a, b) < config.same_rotation;
}

bool
areDistinct(const Eigen::Isometry3d& a,
            const Eigen::Isometry3d& b,
            const Eigen::Vector3d& place,
            const ChoiceConfig& config)
{
  return translationBetween(a, b, place) > config.loose * config.same_translation ||
         rotationBetween(a, b) > config.loose * config.same_rotation;
}

HypothesisGraph
weighHypotheses(const std::vector<PairLink>& links,
                const std::vector<Eigen::Vector3d>& places,
                const Decisions& decisions,
                const MultiwayOptions& options)
{
  std::vector<double> none(links.size());
  HypothesisGraph graph;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const PairLink& link = links[k];
    const bool is_accepted = isAccepted(decisions, link.source, link.target);
    const bool is_rejected = isRejected(decisions, link.source, link.target);
    graph.first.push_back(graph.hypotheses.size());
    for (std::size_t rank = 0; rank < link.hypotheses.size(); ++rank) {
      WeighedHypothesis h;
      h.link = k;
      h.rank = rank;
      h.prior = is_accepted ? (rank == 0 ? 1 : 0) : is_rejected ? 0 : link.hypotheses[rank].probability;
      h.belief = h.prior;
      graph.hypotheses.push_back(h);
    }
    none[k] = is_accepted && !link.hypotheses.empty() ? 0 : link.probability_of_none;
  }
  graph.first.push_back(graph.hypotheses.size());

  const auto threads = static_cast<int>(options.threads);
  for (int round = 0; round < kLoopRounds; ++round) {
    const Directed directed(links, graph, places.size(), options.link.least_probability);
    std::vector<std::vector<double>> loops(links.size());
    forEachInParallel(static_cast<std::int64_t>(links.size()), 16, threads, [&](std::int64_t k) {
      const auto link = static_cast<std::size_t>(k);
      if (!links[link].hypotheses.empty())
        loops[link] = countLoops(link, links, graph, directed, places, options.choice);
    });
    for (std::size_t k = 0; k < links.size(); ++k) {
      const auto [source, target] = std::pair(links[k].source, links[k].target);
      if (isAccepted(decisions, source, target) || isRejected(decisions, source, target))
        continue;
      double sum = std::max(none[k], kSmallest);
      for (std::size_t m = 0; m < loops[k].size(); ++m) {
        WeighedHypothesis& h = graph.hypotheses[graph.first[k] + m];
        const double gain =
            std::clamp(options.choice.loop_weight * loops[k][m], -options.choice.loop_bound, options.choice.loop_bound);
        sum += h.belief = std::max(h.prior, kSmallest) * std::exp(gain);
      }
      for (std::size_t m = 0; m < loops[k].size(); ++m)
        graph.hypotheses[graph.first[k] + m].belief /= sum;
    }
  }
  return graph;
}

} // namespace pcl_ssfr
