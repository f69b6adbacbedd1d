// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/parts.h"

#include "multiway/pose_graph.h"
#include "refinement/plane_equations.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

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

std::vector<PlacedPair>
pairsBetween(const std::vector<int>& sources,
             const std::vector<int>& targets,
             const Eigen::Isometry3d& T,
             const std::vector<Eigen::Isometry3d>& poses,
             const std::vector<Eigen::Vector3d>& places,
             const PairTest& left_out)
{
  const auto placeOf = [&](int scan) -> Eigen::Vector3d {
    return poses[static_cast<std::size_t>(scan)] * places[static_cast<std::size_t>(scan)];
  };
  std::vector<Eigen::Vector3d> places_of_targets;
  std::transform(targets.begin(), targets.end(), std::back_inserter(places_of_targets), placeOf);
  std::vector<PlacedPair> pairs;
  for (const int i : sources) {
    const Eigen::Vector3d place = T * placeOf(i);
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const int j = targets[k];
      if (!left_out || !left_out(i, j, (place - places_of_targets[k]).norm()))
        pairs.push_back({i, j, poses[static_cast<std::size_t>(j)].inverse() * T * poses[static_cast<std::size_t>(i)]});
    }
  }
  return pairs;
}

int
nextPart(const Assembly& assembly)
{
  return *std::max_element(assembly.part.begin(), assembly.part.end()) + 1;
}

void
adjustPart(Assembly& assembly, int part, const std::vector<PairLink>& links, const std::vector<Eigen::Vector3d>& places)
{
  const std::vector<int> members = membersOf(assembly).at(part);
  std::vector<int> numbers(assembly.part.size(), -1);
  std::vector<Eigen::Isometry3d> poses;
  poses.reserve(members.size());
  for (const int member : members) {
    const auto i = static_cast<std::size_t>(member);
    numbers[i] = static_cast<int>(poses.size());
    poses.push_back(assembly.poses[i] * Eigen::Translation3d(places[i]));
  }
  std::vector<PoseGraphEdge> edges;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto source = static_cast<std::size_t>(links[k].source);
    const auto target = static_cast<std::size_t>(links[k].target);
    if (assembly.used[k] < 0 || numbers[source] < 0 || numbers[target] < 0)
      continue;
    const PairHypothesis& h = links[k].hypotheses[static_cast<std::size_t>(assembly.used[k])];
    // Between frames whose origins are the sensors: what edges can know at best is known there.
    const PlaneEquations::Matrix6 a = aboutOrigin(-places[target]);
    edges.push_back({numbers[source],
                     numbers[target],
                     Eigen::Translation3d(-places[target]) * h.T_target_source * Eigen::Translation3d(places[source]),
                     a * h.information * a.transpose()});
  }
  poses = solvePoseGraph(std::move(poses), edges);
  for (std::size_t m = 0; m < members.size(); ++m) {
    const auto i = static_cast<std::size_t>(members[m]);
    assembly.poses[i] = poses[m] * Eigen::Translation3d(-places[i]);
  }
}

void
splitUnconnected(Assembly& assembly,
                 const std::vector<PairLink>& links,
                 const HypothesisGraph& graph,
                 const ChoiceConfig& config)
{
  std::vector<int> root(assembly.part.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i)
      i = root[static_cast<std::size_t>(i)];
    return i;
  };
  for (std::size_t k = 0; k < links.size(); ++k)
    if (assembly.used[k] >= 0 &&
        graph.hypotheses[graph.first[k] + static_cast<std::size_t>(assembly.used[k])].belief >= config.sure) {
      const int a = find(links[k].source), b = find(links[k].target);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (std::size_t i = 0; i < root.size(); ++i)
    assembly.part[i] = find(static_cast<int>(i));
  for (std::size_t k = 0; k < links.size(); ++k)
    if (find(links[k].source) != find(links[k].target))
      assembly.used[k] = -1;
}

std::vector<std::vector<int>>
weakestCuts(const std::vector<int>& members, const std::vector<WeightedEdge>& edges)
{
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const std::size_t n = members.size();
  const auto number = [&](int scan) {
    return static_cast<std::size_t>(std::lower_bound(members.begin(), members.end(), scan) - members.begin());
  };
  std::vector<std::vector<std::pair<std::size_t, double>>> neighbours(n);
  for (const WeightedEdge& e : edges) {
    neighbours[number(e.a)].emplace_back(number(e.b), e.weight);
    neighbours[number(e.b)].emplace_back(number(e.a), e.weight);
  }
  // Prim's algorithm, from the first member.
  std::vector<std::size_t> parent(n, 0), order;
  std::vector<double> weight(n, kNone);
  std::vector<char> is_in(n, 0);
  for (std::size_t at = 0; order.size() < n;) {
    is_in[at] = 1;
    order.push_back(at);
    for (const auto& [next, w] : neighbours[at])
      if (!is_in[next] && w > weight[next]) {
        weight[next] = w;
        parent[next] = at;
      }
    double most = kNone;
    for (std::size_t i = 0; i < n; ++i)
      if (!is_in[i] && weight[i] > most) {
        most = weight[i];
        at = i;
      }
    if (!(most > kNone))
      break;
  }
  std::vector<std::vector<int>> below(n); // of each member, itself and what hangs on it
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    below[*it].push_back(members[*it]);
    std::sort(below[*it].begin(), below[*it].end());
    if (*it != order.front())
      below[parent[*it]].insert(below[parent[*it]].end(), below[*it].begin(), below[*it].end());
  }
  std::stable_sort(order.begin() + 1, order.end(), [&](std::size_t a, std::size_t b) { return weight[a] < weight[b]; });
  std::vector<std::vector<int>> cuts;
  for (auto it = order.begin() + 1; it != order.end(); ++it) {
    std::vector<int>& side = below[*it];
    std::vector<int> rest;
    std::set_difference(members.begin(), members.end(), side.begin(), side.end(), std::back_inserter(rest));
    cuts.push_back(side.size() <= rest.size() ? std::move(side) : std::move(rest));
  }
  return cuts;
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
  const auto score = [&](const PlacementEvidence& e) { return scoreOf(e, contradiction_weight); };
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

Piles
findPiles(const std::vector<int>& members,
          const std::vector<Eigen::Vector3d>& stations,
          double within,
          const std::vector<std::pair<int, int>>& pairs,
          const std::vector<PlacementEvidence>& evidence,
          const std::function<bool(const PlacementEvidence&)>& counts,
          std::size_t least)
{
  std::map<int, Eigen::Vector3d> station;
  for (std::size_t m = 0; m < members.size(); ++m)
    station[members[m]] = stations[m];
  std::map<int, std::set<int>> same;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    if (!counts(evidence[k]) || (station[i] - station[j]).norm() >= within)
      continue;
    same[i].insert({i, j});
    same[j].insert({i, j});
  }
  Piles piles;
  for (const auto& [i, scans] : same)
    if (scans.size() >= least)
      piles[i].assign(scans.begin(), scans.end());
  return piles;
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
    std::size_t rank = 0;
    double sureness = link.status == Status::Converged && link.confidence >= config.lone ? link.confidence : 0;
    if (by == SureBy::Loops) {
      double belief = 0;
      for (std::size_t h = graph.first[k]; h < graph.first[k + 1]; ++h)
        if (graph.hypotheses[h].belief > belief) {
          belief = graph.hypotheses[h].belief;
          rank = graph.hypotheses[h].rank;
        }
      sureness = belief >= config.clear_odds * (1 - belief) ? belief : 0;
    }
    if (!(sureness > 0) || link.hypotheses.empty() || !(graph.hypotheses[graph.first[k] + rank].prior > 0))
      continue;
    count.wrong.push_back(std::max(1 - sureness, 1 / (1 + config.clear_odds)));
    count.contradicted += assembly.used[k] == static_cast<int>(rank) ? 0 : 1;
  }
  return count;
}

bool
isRefuted(const SureLinks& links, const ChoiceConfig& config)
{
  std::vector<double> chance = {1}; // of each number of wrong links
  for (const double wrong : links.wrong) {
    chance.push_back(0);
    for (std::size_t n = chance.size() - 1; n > 0; --n)
      chance[n] = chance[n] * (1 - wrong) + chance[n - 1] * wrong;
    chance[0] *= 1 - wrong;
  }
  const auto from = chance.begin() + links.contradicted;
  return links.contradicted > 0 && std::accumulate(from, chance.end(), 0.0) < 1 / config.clear_odds;
}

} // namespace pcl_ssfr
