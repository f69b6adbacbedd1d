// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/assembly.h"

#include "common/logit.h"
#include "multiway/growing_parts.h"
#include "multiway/same_place.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace pcl_ssfr {

namespace {

using PartPair = std::pair<int, int>; // of parts, the lower number first

/// Log odds against a join that others never made up for. Two large parts are proposed to each other by many false
/// links, each of which lays hundreds of scans onto hundreds.
constexpr double kHopeless = -100;

/// One part laid into the frame of another one.
struct Join {
  Eigen::Isometry3d T_b_a;
  double link = 0;     ///< probability by the surest link that says so
  double links = 0;    ///< log odds by all links that say so
  double odds = 0;     ///< by SamePlaceOdds of all scans of the one with all scans of the other, and by the links
  std::string refusal; ///< of the join test
};

class Assembler {
public:
  Assembler(const std::vector<PairLink>& links,
            const HypothesisGraph& graph,
            const std::vector<Eigen::Vector3d>& places,
            SamePlaceOdds& odds,
            const JoinRule& rule,
            const Decisions& decisions,
            const std::vector<std::string>& names,
            const MultiwayOptions& options,
            const JoinTest& join_test)
      : links_(links), graph_(graph), places_(places), odds_(odds), rule_(rule), decisions_(decisions), names_(names),
        options_(options), join_test_(join_test), parts_(links, graph, places, options.choice)
  {}

  Assembly
  run()
  {
    joinAccepted();
    for (findJoins(); joinBest(); findJoins()) {
    }
    explainRefusals();
    parts_.adjustAll();
    chooseLinks(parts_.assembly(), links_, graph_, places_, options_.choice);
    return std::move(parts_.assembly());
  }

private:
  PartPair
  partsOf(const PairLink& link) const
  {
    return std::minmax({parts_.partOf(link.source), parts_.partOf(link.target)});
  }
  /// Where a pose of a pair lays the first of its parts in the frame of the second one.
  Eigen::Isometry3d
  joinPose(const PairLink& link, const Eigen::Isometry3d& T_target_source) const
  {
    const Eigen::Isometry3d there = parts_.partPose(link, T_target_source);
    return parts_.partOf(link.source) < parts_.partOf(link.target) ? there : there.inverse();
  }

  void
  joinAccepted()
  {
    for (const PairLink& link : links_) {
      if (!isAccepted(decisions_, link.source, link.target) || link.hypotheses.empty())
        continue;
      const Eigen::Isometry3d& T_target_source = link.hypotheses.front().T_target_source;
      const auto [a, b] = partsOf(link);
      if (a != b)
        parts_.merge(a, b, joinPose(link, T_target_source));
      else if (!agree(T_target_source,
                      parts_.pose(link.target).inverse() * parts_.pose(link.source),
                      places_[static_cast<std::size_t>(link.source)],
                      options_.choice))
        throw DecisionError(
            "the accepted link " + name(link.source) + ", " + name(link.target) +
            " does not agree with the other accepted links between them: " + loopOf(link.source, link.target));
    }
  }

  /// The accepted links that lead from one scan to the other, for people.
  std::string
  loopOf(int from, int to) const
  {
    std::vector<int> before(places_.size(), -1);
    std::vector<int> queue = {from};
    before[static_cast<std::size_t>(from)] = from;
    for (std::size_t q = 0; q < queue.size(); ++q)
      for (const auto& [i, j] : decisions_.accepted)
        for (const auto& [x, y] : {std::pair(i, j), std::pair(j, i)})
          if (x == queue[q] && before[static_cast<std::size_t>(y)] < 0 && !(x == from && y == to)) {
            before[static_cast<std::size_t>(y)] = x;
            queue.push_back(y);
          }
    std::string text = name(to);
    for (int at = to; at != from;) {
      at = before[static_cast<std::size_t>(at)];
      text.insert(0, name(at) + " - ");
    }
    return "the loop " + text + " - " + name(from) + " does not close";
  }

  /// The joins of all pairs of parts that are not known yet, by sure hypotheses.
  void
  findJoins()
  {
    std::map<PartPair, std::vector<Join>> found;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const PartPair pair = partsOf(links_[k]);
      if (pair.first == pair.second || joins_.count(pair) > 0)
        continue;
      std::vector<Join>& joins = found[pair];
      const Eigen::Vector3d place = parts_.placeOf(pair.first);
      for (std::size_t h = graph_.first[k]; h < graph_.first[k + 1]; ++h) {
        const WeighedHypothesis& w = graph_.hypotheses[h];
        const double probability = rule_.by_loops ? w.belief : w.prior;
        if (probability < options_.choice.sure)
          continue;
        const double links = std::min(logit(probability), std::log(options_.choice.clear_odds));
        const Join join{joinPose(links_[k], links_[k].hypotheses[w.rank].T_target_source), probability, links, 0, ""};
        const auto same = std::find_if(joins.begin(), joins.end(), [&](const Join& other) {
          return !areDistinct(join.T_b_a, other.T_b_a, place, options_.choice);
        });
        if (same == joins.end()) {
          joins.push_back(join);
          continue;
        }
        if (join.link > same->link) {
          same->T_b_a = join.T_b_a;
          same->link = join.link;
        }
        same->links += join.links;
      }
    }
    for (auto& [pair, joins] : found) {
      for (Join& join : joins) {
        if (join_test_)
          join.refusal = join_test_(parts_.pairsAt(pair.first, pair.second, join.T_b_a));
        if (join.refusal.empty())
          join.odds = odds_.of(parts_.pairsAt(pair.first, pair.second, join.T_b_a, odds_.areUnrelated()), kHopeless) +
                      std::min(join.links, rule_.most_by_links);
      }
      joins_[pair] = std::move(joins);
    }
  }

  /// \return whether any join has odds enough
  bool
  joinBest()
  {
    PartPair parts;
    const Join* best = nullptr;
    double most = 0;
    for (const auto& [pair, joins] : joins_)
      for (const Join& join : joins) {
        const double evidence = std::log(join.link) + join.odds; // of equal odds the surer link
        if (join.refusal.empty() && isEnough(join.odds) && (!best || evidence > most)) {
          parts = pair;
          best = &join;
          most = evidence;
        }
      }
    if (!best)
      return false;
    parts_.merge(parts.first, parts.second, best->T_b_a);
    for (auto it = joins_.begin(); it != joins_.end();) {
      const auto touches = [&](int part) { return it->first.first == part || it->first.second == part; };
      it = touches(parts.first) || touches(parts.second) ? joins_.erase(it) : std::next(it);
    }
    return true;
  }

  void
  explainRefusals()
  {
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const auto joins = joins_.find(partsOf(links_[k]));
      if (joins == joins_.end() || joins->second.empty())
        continue;
      const Join& best = *std::max_element(
          joins->second.begin(), joins->second.end(), [](const Join& a, const Join& b) { return a.odds < b.odds; });
      parts_.assembly().refusal[k] = !best.refusal.empty() ? best.refusal
                                     : best.odds < 0       ? "what is in view of both parts is not the same"
                                     : rule_.least_odds > 0
                                         ? "it alone would join two parts, and is not sure enough for that"
                                         : "places here look alike, and nothing in view of both distinguishes them";
    }
  }

  bool
  isEnough(double odds) const
  {
    return odds > 0 && odds >= rule_.least_odds;
  }
  const std::string&
  name(int scan) const
  {
    return names_[static_cast<std::size_t>(scan)];
  }

  const std::vector<PairLink>& links_;
  const HypothesisGraph& graph_;
  const std::vector<Eigen::Vector3d>& places_;
  SamePlaceOdds& odds_;
  const JoinRule& rule_;
  const Decisions& decisions_;
  const std::vector<std::string>& names_;
  const MultiwayOptions& options_;
  const JoinTest& join_test_;
  GrowingParts parts_;
  std::map<PartPair, std::vector<Join>> joins_; ///< of each two parts
};

} // namespace

double
mostLogOddsByLinks(double false_share, const ChoiceConfig& config)
{
  return std::clamp(-logit(false_share), 0.0, std::log(config.clear_odds));
}

Assembly
assemble(const std::vector<PairLink>& links,
         const HypothesisGraph& graph,
         const std::vector<Eigen::Vector3d>& places,
         SamePlaceOdds& odds,
         const JoinRule& rule,
         const Decisions& decisions,
         const std::vector<std::string>& names,
         const MultiwayOptions& options,
         const JoinTest& join_test)
{
  return Assembler(links, graph, places, odds, rule, decisions, names, options, join_test).run();
}

void
chooseLinks(Assembly& assembly,
            const std::vector<PairLink>& links,
            const HypothesisGraph& graph,
            const std::vector<Eigen::Vector3d>& places,
            const ChoiceConfig& config)
{
  for (std::size_t k = 0; k < links.size(); ++k) {
    assembly.used[k] = -1;
    const auto source = static_cast<std::size_t>(links[k].source);
    const auto target = static_cast<std::size_t>(links[k].target);
    if (assembly.part[source] != assembly.part[target])
      continue;
    const Eigen::Isometry3d T = assembly.poses[target].inverse() * assembly.poses[source];
    double most = 0;
    for (std::size_t h = graph.first[k]; h < graph.first[k + 1]; ++h) {
      const WeighedHypothesis& w = graph.hypotheses[h];
      // A bent chain may have strayed from a link that two others of its part support.
      if (w.belief > most && agree(links[k].hypotheses[w.rank].T_target_source, T, places[source], config)) {
        most = w.belief;
        assembly.used[k] = static_cast<int>(w.rank);
      }
    }
  }
}

std::vector<char>
findBridges(const Assembly& assembly, const std::vector<PairLink>& links)
{
  // A link is a bridge when without it its scans are not connected: a search for each used link of a sparse graph is
  // cheap enough, as a part with many links has few bridges and a search ends soon.
  const std::size_t n = assembly.part.size();
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> neighbours(n); // scan, link
  for (std::size_t k = 0; k < links.size(); ++k)
    if (assembly.used[k] >= 0) {
      neighbours[static_cast<std::size_t>(links[k].source)].emplace_back(static_cast<std::size_t>(links[k].target), k);
      neighbours[static_cast<std::size_t>(links[k].target)].emplace_back(static_cast<std::size_t>(links[k].source), k);
    }
  std::vector<char> bridges(links.size(), 0);
  for (std::size_t k = 0; k < links.size(); ++k) {
    if (assembly.used[k] < 0)
      continue;
    std::vector<char> seen(n, 0);
    std::vector<std::size_t> stack = {static_cast<std::size_t>(links[k].source)};
    seen[stack.front()] = 1;
    const auto goal = static_cast<std::size_t>(links[k].target);
    while (!stack.empty() && !seen[goal]) {
      const std::size_t at = stack.back();
      stack.pop_back();
      for (const auto& [next, by] : neighbours[at])
        if (by != k && !seen[next]) {
          seen[next] = 1;
          stack.push_back(next);
        }
    }
    bridges[k] = seen[goal] ? 0 : 1;
  }
  return bridges;
}

} // namespace pcl_ssfr
