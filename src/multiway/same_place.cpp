// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/same_place.h"

#include "common/parallel.h"
#include "multiway/growing_parts.h"
#include "multiway/parts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr double kSameView = 0.1; // of what makes places distinct: within it scans see the same of each other

using PartPair = std::pair<int, int>; // of parts, the lower number first

/// One part laid into the frame of another one.
struct Join {
  Eigen::Isometry3d T_b_a;
  double link = 0;     ///< probability by the surest link that says so
  double odds = 0;     ///< SamePlaceOdds of all scans of the one with all scans of the other
  std::string refusal; ///< of the join test
};

class SamePlaceAssembler {
public:
  SamePlaceAssembler(const std::vector<PairLink>& links,
                     const HypothesisGraph& graph,
                     const std::vector<Eigen::Vector3d>& places,
                     SamePlaceOdds& odds,
                     const Decisions& decisions,
                     const MultiwayOptions& options,
                     const JoinTest& join_test)
      : links_(links), graph_(graph), places_(places), odds_(odds), decisions_(decisions), options_(options),
        join_test_(join_test), parts_(links, graph, places, options.choice)
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
      const auto [a, b] = partsOf(link);
      if (a != b && isAccepted(decisions_, link.source, link.target) && !link.hypotheses.empty())
        parts_.merge(a, b, joinPose(link, link.hypotheses.front().T_target_source));
    }
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
        if (w.prior < options_.choice.sure)
          continue;
        const Join join{joinPose(links_[k], links_[k].hypotheses[w.rank].T_target_source), w.prior, 0, ""};
        const auto same = std::find_if(joins.begin(), joins.end(), [&](const Join& other) {
          return !areDistinct(join.T_b_a, other.T_b_a, place, options_.choice);
        });
        if (same == joins.end())
          joins.push_back(join);
        else if (join.link > same->link)
          *same = join;
      }
    }
    for (auto& [pair, joins] : found) {
      for (Join& join : joins) {
        const std::vector<PlacedPair> pairs = parts_.pairsAt(pair.first, pair.second, join.T_b_a);
        join.refusal = join_test_ ? join_test_(pairs) : "";
        if (join.refusal.empty())
          join.odds = odds_.of(pairs);
      }
      joins_[pair] = std::move(joins);
    }
  }

  /// \return whether any join has odds for it
  bool
  joinBest()
  {
    PartPair parts;
    const Join* best = nullptr;
    double most = 0;
    for (const auto& [pair, joins] : joins_)
      for (const Join& join : joins) {
        const double evidence = std::log(join.link) + join.odds; // of equal odds the surer link
        if (join.refusal.empty() && join.odds > 0 && (!best || evidence > most)) {
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
                                     : best.odds < 0
                                         ? "places here look alike, and what is in them is not the same"
                                         : "places here look alike, and nothing in view of both distinguishes them";
    }
  }

  const std::vector<PairLink>& links_;
  const HypothesisGraph& graph_;
  const std::vector<Eigen::Vector3d>& places_;
  SamePlaceOdds& odds_;
  const Decisions& decisions_;
  const MultiwayOptions& options_;
  const JoinTest& join_test_;
  GrowingParts parts_;
  std::map<PartPair, std::vector<Join>> joins_; ///< of each two parts
};

class RivalAlikeSearch {
public:
  RivalAlikeSearch(const PlacedScans& placed,
                   SamePlaceOdds& odds,
                   const Decisions& decisions,
                   const MultiwayOptions& options)
      : placed_(placed), odds_(odds), decisions_(decisions), options_(options), parts_(membersOf(placed.assembly))
  {}

  bool
  hasRival(int scan)
  {
    const int part = partOf(scan);
    if (parts_.at(part).size() < 2 || hasAcceptedLink(decisions_, scan))
      return false;
    const double here = oddsAt(scan, part, pose(scan));
    std::map<int, std::vector<Eigen::Isometry3d>> looked_at; // of each part
    for (const ProposedPose& proposed : proposedPoses(scan, placed_)) {
      const int there = partOf(proposed.other);
      const Eigen::Isometry3d& rival = proposed.T_part_scan;
      const double least = there == part ? options_.choice.rival : options_.choice.sure;
      if (proposed.prior < least || (there == part && !isDistinct(scan, pose(scan), rival)))
        continue;
      auto& known = looked_at[there];
      const auto isKnown = [&](const Eigen::Isometry3d& at) { return !isDistinct(scan, at, rival); };
      if (std::any_of(known.begin(), known.end(), isKnown) || odds_.of({proposed.pair}) < 0)
        continue;
      known.push_back(rival);
      const bool competes = there == part ? !(oddsAgainst(scan, rival) >= std::log(options_.choice.clear_odds))
                                          : oddsAt(scan, there, rival) > std::max(here, 0.0);
      if (competes)
        return true;
    }
    return false;
  }

private:
  int
  partOf(int scan) const
  {
    return placed_.assembly.part[static_cast<std::size_t>(scan)];
  }
  const Eigen::Isometry3d&
  pose(int scan) const
  {
    return placed_.assembly.poses[static_cast<std::size_t>(scan)];
  }
  bool
  isDistinct(int scan, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const
  {
    return areDistinct(a, b, placed_.places[static_cast<std::size_t>(scan)], options_.choice);
  }

  /// Of a scan laid into a part.
  double
  oddsAt(int scan, int part, const Eigen::Isometry3d& at)
  {
    std::vector<PlacedPair> pairs;
    for (const int other : parts_.at(part))
      if (other != scan)
        pairs.push_back({scan, other, pose(other).inverse() * at});
    return odds_.of(pairs);
  }

  /// For where a scan is, against a rival in its part: one that stands there would go where this one is, and what the
  /// others, but for those displaced, say of that is added. Whom that one displaces is not asked.
  double
  oddsAgainst(int scan, const Eigen::Isometry3d& rival)
  {
    const std::vector<int> displaced = standingAt(scan, rival);
    std::vector<int> not_asked = displaced;
    double sum = oddsAgainst(scan, rival, not_asked);
    const Eigen::Isometry3d T_here_rival = pose(scan) * rival.inverse();
    for (const int other : displaced) {
      const Eigen::Isometry3d exchanged = T_here_rival * pose(other);
      const std::vector<int> standing = standingAt(other, exchanged);
      not_asked.insert(not_asked.end(), standing.begin(), standing.end());
      sum += oddsAgainst(other, exchanged, not_asked);
    }
    return sum;
  }
  double
  oddsAgainst(int scan, const Eigen::Isometry3d& rival, const std::vector<int>& not_asked)
  {
    std::vector<PlacedPair> here, there;
    for (const int other : parts_.at(partOf(scan))) {
      if (other == scan || std::find(not_asked.begin(), not_asked.end(), other) != not_asked.end())
        continue;
      here.push_back({scan, other, pose(other).inverse() * pose(scan)});
      there.push_back({scan, other, pose(other).inverse() * rival});
    }
    return odds_.of(here) - odds_.of(there);
  }

  /// The others of its part that stand where a scan would, at a pose.
  std::vector<int>
  standingAt(int scan, const Eigen::Isometry3d& at) const
  {
    const Eigen::Vector3d place = at * placed_.places[static_cast<std::size_t>(scan)];
    std::vector<int> found;
    for (const int other : parts_.at(partOf(scan)))
      if (other != scan && (place - pose(other) * placed_.places[static_cast<std::size_t>(other)]).norm() <
                               options_.choice.same_translation)
        found.push_back(other);
    return found;
  }

  const PlacedScans& placed_;
  SamePlaceOdds& odds_;
  const Decisions& decisions_;
  const MultiwayOptions& options_;
  std::map<int, std::vector<int>> parts_;
};

} // namespace

SamePlaceOdds::SamePlaceOdds(PairOddsFunction odds,
                             const std::vector<Eigen::Vector3d>& places,
                             const MultiwayOptions& options)
    : odds_(std::move(odds)), places_(places), config_(options.choice), threads_(static_cast<int>(options.threads))
{
  config_.same_translation *= kSameView;
  config_.same_rotation *= kSameView;
}

double
SamePlaceOdds::of(const std::vector<PlacedPair>& pairs)
{
  std::vector<double> found(pairs.size());
  std::vector<std::size_t> missing;
  std::vector<PlacedPair> ordered(pairs);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    PlacedPair& pair = ordered[k];
    if (pair.source > pair.target)
      pair = {pair.target, pair.source, pair.T_target_source.inverse()};
    const Eigen::Vector3d& place = places_[static_cast<std::size_t>(pair.source)];
    const auto& known = known_[{pair.source, pair.target}];
    const auto same = std::find_if(known.begin(), known.end(), [&](const Known& at) {
      return agree(at.T_target_source, pair.T_target_source, place, config_);
    });
    if (same != known.end())
      found[k] = same->odds;
    else
      missing.push_back(k);
  }
  forEachInParallel(static_cast<std::int64_t>(missing.size()), 1, threads_, [&](std::int64_t index) {
    const std::size_t k = missing[static_cast<std::size_t>(index)];
    found[k] = odds_(ordered[k]);
  });
  for (const std::size_t k : missing)
    known_[{ordered[k].source, ordered[k].target}].push_back({ordered[k].T_target_source, found[k]});
  double sum = 0;
  for (const double odds : found)
    sum += odds;
  return sum;
}

Assembly
assembleBySamePlace(const std::vector<PairLink>& links,
                    const HypothesisGraph& graph,
                    const std::vector<Eigen::Vector3d>& places,
                    SamePlaceOdds& odds,
                    const Decisions& decisions,
                    const MultiwayOptions& options,
                    const JoinTest& join_test)
{
  return SamePlaceAssembler(links, graph, places, odds, decisions, options, join_test).run();
}

std::vector<int>
findScansWithRivalsAlike(const std::vector<int>& asked,
                         const PlacedScans& placed,
                         SamePlaceOdds& odds,
                         const Decisions& decisions,
                         const MultiwayOptions& options)
{
  RivalAlikeSearch search(placed, odds, decisions, options);
  std::vector<int> found;
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(found), [&](int scan) { return search.hasRival(scan); });
  return found;
}

} // namespace pcl_ssfr
