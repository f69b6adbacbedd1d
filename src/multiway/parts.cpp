// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace pcl_ssfr {

std::map<int, std::vector<int>>
membersOf(const Assembly& assembly)
{
  std::map<int, std::vector<int>> members;
  for (std::size_t i = 0; i < assembly.part.size(); ++i)
    members[assembly.part[i]].push_back(static_cast<int>(i));
  return members;
}

std::vector<std::pair<int, int>>
pairsOf(const std::vector<int>& members)
{
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t a = 0; a < members.size(); ++a)
    for (std::size_t b = a + 1; b < members.size(); ++b)
      pairs.emplace_back(members[a], members[b]);
  return pairs;
}

int
nextPart(const Assembly& assembly)
{
  return *std::max_element(assembly.part.begin(), assembly.part.end()) + 1;
}

void
splitUnconnected(Assembly& assembly, const std::vector<PairLink>& links)
{
  std::vector<int> root(assembly.part.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i)
      i = root[static_cast<std::size_t>(i)];
    return i;
  };
  for (std::size_t k = 0; k < links.size(); ++k)
    if (assembly.used[k] >= 0) {
      const int a = find(links[k].source), b = find(links[k].target);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (std::size_t i = 0; i < root.size(); ++i)
    assembly.part[i] = find(static_cast<int>(i));
}

std::vector<int>
findHanging(const std::vector<int>& members,
            const std::vector<std::pair<int, int>>& pairs,
            const std::vector<PlacementEvidence>& evidence,
            double contradiction_weight)
{
  std::map<int, PlacementEvidence> sums; // of the scans that are left
  for (const int i : members)
    sums[i];
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    sums[pairs[k].first] += evidence[k];
    sums[pairs[k].second] += evidence[k];
  }
  const auto score = [&](const PlacementEvidence& e) {
    return (e.matched - contradiction_weight * e.contradicted) / std::max(e.total, 1e-9);
  };
  std::vector<int> hanging;
  while (sums.size() > 1) {
    const auto worst = std::min_element(
        sums.begin(), sums.end(), [&](const auto& a, const auto& b) { return score(a.second) < score(b.second); });
    if (score(worst->second) > 0)
      break;
    const int out = worst->first;
    hanging.push_back(out);
    sums.erase(worst);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [a, b] = pairs[k];
      const auto other = a == out ? sums.find(b) : b == out ? sums.find(a) : sums.end();
      if (other != sums.end())
        other->second -= evidence[k];
    }
  }
  std::sort(hanging.begin(), hanging.end());
  return hanging;
}

bool
isClear(const PlaceOdds& chosen, const PlaceOdds& rival, const ChoiceConfig& config)
{
  if (rival.score > chosen.score)
    return false;
  if (!(rival.score > 0))
    return true;
  return chosen.belief * std::pow(chosen.score / rival.score, config.score_power) >= config.clear_odds * rival.belief;
}

SureLinks
countSureLinks(const Assembly& assembly,
               const std::vector<PairLink>& links,
               const HypothesisGraph& graph,
               int part,
               SureBy by,
               const ChoiceConfig& config)
{
  SureLinks count;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const PairLink& link = links[k];
    if (assembly.part[static_cast<std::size_t>(link.source)] != part &&
        assembly.part[static_cast<std::size_t>(link.target)] != part)
      continue;
    const auto first = graph.hypotheses.begin();
    if (std::none_of(first + static_cast<std::ptrdiff_t>(graph.first[k]),
                     first + static_cast<std::ptrdiff_t>(graph.first[k + 1]),
                     [](const WeighedHypothesis& h) { return h.prior > 0; }))
      continue; // a person rejected it
    std::size_t rank = 0;
    bool is_sure = link.status == Status::Converged && link.confidence >= config.lone;
    if (by == SureBy::Loops) {
      double belief = 0;
      for (std::size_t h = graph.first[k]; h < graph.first[k + 1]; ++h)
        if (graph.hypotheses[h].belief > belief) {
          belief = graph.hypotheses[h].belief;
          rank = graph.hypotheses[h].rank;
        }
      is_sure = belief > 0 && belief >= config.clear_odds * (1 - belief);
    }
    if (!is_sure)
      continue;
    ++count.all;
    count.contradicted += assembly.used[k] == static_cast<int>(rank) ? 0 : 1;
  }
  return count;
}

bool
isRefuted(const SureLinks& links, SureBy by, const ChoiceConfig& config)
{
  const double wrong = by == SureBy::Pair ? 1 - config.lone : 1 / (1 + config.clear_odds);
  // The upper tail of the binomial distribution: all but its first terms.
  double term = std::pow(1 - wrong, links.all);
  double fewer = 0;
  for (int k = 0; k < links.contradicted; ++k) {
    fewer += term;
    term *= wrong / (1 - wrong) * (links.all - k) / (k + 1);
  }
  return 1 - fewer < 1 / config.clear_odds;
}

} // namespace pcl_ssfr
