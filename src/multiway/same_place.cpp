// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/same_place.h"

#include "common/parallel.h"
#include "multiway/parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr double kSameView = 0.1; // of what makes places distinct: within it scans see the same of each other

constexpr std::size_t kAskedAtOnce = 64; // pairs

/// Scans of a part that are moved together, ascending, and a motion of them in the frame of the part.
using Group = std::vector<int>;
using Motion = Eigen::Isometry3d;

class RivalAlikeSearch {
public:
  RivalAlikeSearch(const PlacedScans& placed,
                   SamePlaceOdds& odds,
                   const EvidenceFunction& evidence,
                   double most_by_links,
                   const MultiwayOptions& options)
      : placed_(placed), odds_(odds), evidence_(evidence), most_by_links_(most_by_links), options_(options),
        parts_(membersOf(placed.assembly))
  {}

  /// \param[in] group of one part
  bool
  hasRival(const Group& group)
  {
    const int part = partOf(group.front());
    const Group others = without(parts_.at(part), group);
    if (others.empty())
      return false;
    const double here = oddsAt(group, others, Motion::Identity());
    std::map<int, std::vector<Motion>> looked_at; // of each part
    for (const int scan : group)
      for (const ProposedPose& proposed : proposedPoses(scan, placed_)) {
        const int there = partOf(proposed.other);
        const double least = there == part ? options_.choice.rival : options_.choice.sure;
        if (isOf(group, proposed.other) || proposed.prior < least ||
            (there == part && !isDistinct(scan, pose(scan), proposed.T_part_scan)))
          continue;
        auto& known = looked_at[there];
        const auto isKnown = [&](const Motion& motion) {
          return !isDistinct(scan, motion * pose(scan), proposed.T_part_scan);
        };
        if (std::any_of(known.begin(), known.end(), isKnown) || odds_.of({proposed.pair}) < 0)
          continue;
        known.push_back(proposed.T_part_scan * pose(scan).inverse());
        const bool competes = there == part ? !isClearOf(group, others, known.back())
                                            : oddsAt(group, parts_.at(there), known.back()) > std::max(here, 0.0);
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
  static bool
  isOf(const Group& group, int scan)
  {
    return std::binary_search(group.begin(), group.end(), scan);
  }
  static Group
  without(const Group& scans, const Group& left_out)
  {
    Group rest;
    std::set_difference(scans.begin(), scans.end(), left_out.begin(), left_out.end(), std::back_inserter(rest));
    return rest;
  }

  /// Of a group moved, by what others distinguish.
  double
  oddsAt(const Group& group, const Group& others, const Motion& motion)
  {
    return odds_.of(pairsBetween(group, others, motion, placed_.assembly.poses, placed_.places, odds_.areUnrelated()));
  }

  /// Of a rival in its part: by what distinguishes places, by its links, and by all surfaces of the others; not by
  /// those that stand where it does, which would confirm each other anywhere.
  bool
  isClearOf(const Group& group, const Group& others, const Motion& motion)
  {
    const Group asked = without(others, standingAt(group, others, Motion::Identity()));
    PlaceOdds here, there;
    PlacementEvidence surfaces;
    for (const int scan : group) {
      for (const ProposedPose& proposed : proposedPoses(scan, placed_)) {
        if (!isOf(asked, proposed.other))
          continue;
        if (!isDistinct(scan, pose(scan), proposed.T_part_scan))
          here.belief += proposed.belief;
        else if (!isDistinct(scan, motion * pose(scan), proposed.T_part_scan))
          there.belief += proposed.prior;
      }
      for (const int other : asked)
        surfaces += surfacesHere(scan, other);
    }
    here.score = scoreOf(surfaces, contradictionWeight(options_));
    there.score = 1; // at most
    const double odds = oddsAgainst(group, others, motion);
    const double least = std::log(options_.choice.clear_odds);
    if (odds + logOdds(here, there, most_by_links_, options_.choice) >= least)
      return true;
    surfaces = {};
    for (const int scan : group)
      surfaces += surfacesAt(scan, motion * pose(scan), asked, placed_.assembly, evidence_, options_);
    there.score = scoreOf(surfaces, contradictionWeight(options_));
    return odds + logOdds(here, there, most_by_links_, options_.choice) >= least;
  }

  /// What two scans of a part see of each other as they are.
  const PlacementEvidence&
  surfacesHere(int scan, int other)
  {
    const auto [found, is_new] = surfaces_here_.try_emplace({scan, other});
    if (is_new)
      found->second = surfacesAt(scan, pose(scan), {other}, placed_.assembly, evidence_, options_);
    return found->second;
  }

  /// For where a group is, against a rival in its part: what stands there would go where the group is, and what the
  /// others, but for those displaced, say of that is added. Whom these displace is not asked.
  double
  oddsAgainst(const Group& group, const Group& others, const Motion& motion)
  {
    const Group displaced = standingAt(group, others, motion);
    Group asked = without(others, displaced);
    double sum = oddsAt(group, asked, Motion::Identity()) - oddsAt(group, asked, motion);
    if (!displaced.empty()) {
      asked = without(asked, standingAt(displaced, asked, motion.inverse()));
      sum += oddsAt(displaced, asked, Motion::Identity()) - oddsAt(displaced, asked, motion.inverse());
    }
    return sum;
  }

  /// Those of others that stand where scans of a group would, moved.
  Group
  standingAt(const Group& group, const Group& others, const Motion& motion) const
  {
    Group found;
    for (const int other : others) {
      const Eigen::Vector3d place = pose(other) * placed_.places[static_cast<std::size_t>(other)];
      const bool is_there = std::any_of(group.begin(), group.end(), [&](int scan) {
        return (place - motion * pose(scan) * placed_.places[static_cast<std::size_t>(scan)]).norm() <
               options_.choice.same_translation;
      });
      if (is_there)
        found.push_back(other);
    }
    return found;
  }

  const PlacedScans& placed_;
  SamePlaceOdds& odds_;
  const EvidenceFunction& evidence_;
  double most_by_links_;
  const MultiwayOptions& options_;
  std::map<int, std::vector<int>> parts_;
  std::map<std::pair<int, int>, PlacementEvidence> surfaces_here_;
};

} // namespace

SamePlaceOdds::SamePlaceOdds(PairOddsFunction odds,
                             const std::vector<Eigen::Vector3d>& places,
                             const MultiwayOptions& options,
                             PairTest are_unrelated)
    : odds_(std::move(odds)), are_unrelated_(std::move(are_unrelated)), places_(places), config_(options.choice),
      threads_(static_cast<int>(options.threads))
{
  config_.same_translation *= kSameView;
  config_.same_rotation *= kSameView;
}

double
SamePlaceOdds::of(const std::vector<PlacedPair>& pairs, double hopeless)
{
  double sum = 0;
  std::vector<PlacedPair> asked;
  for (auto next = pairs.begin(); next != pairs.end() && sum > hopeless;) {
    for (asked.clear(); next != pairs.end() && asked.size() < kAskedAtOnce; ++next)
      if (!isUnrelated(*next))
        asked.push_back(next->source < next->target
                            ? *next
                            : PlacedPair{next->target, next->source, next->T_target_source.inverse()});
    for (const double odds : ofEach(asked))
      sum += odds;
  }
  return sum;
}

bool
SamePlaceOdds::isUnrelated(const PlacedPair& pair) const
{
  const auto s = static_cast<std::size_t>(pair.source), t = static_cast<std::size_t>(pair.target);
  return are_unrelated_ &&
         are_unrelated_(pair.source, pair.target, (pair.T_target_source * places_[s] - places_[t]).norm());
}

std::vector<double>
SamePlaceOdds::ofEach(const std::vector<PlacedPair>& pairs)
{
  std::vector<double> found(pairs.size());
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PlacedPair& pair = pairs[k];
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
    found[k] = odds_(pairs[k]);
  });
  for (const std::size_t k : missing)
    known_[{pairs[k].source, pairs[k].target}].push_back({pairs[k].T_target_source, found[k]});
  return found;
}

std::vector<int>
findScansWithRivalsAlike(const std::vector<int>& asked,
                         const PlacedScans& placed,
                         SamePlaceOdds& odds,
                         const EvidenceFunction& evidence,
                         double most_by_links,
                         const Decisions& decisions,
                         const MultiwayOptions& options)
{
  RivalAlikeSearch search(placed, odds, evidence, most_by_links, options);
  std::vector<int> found;
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(found), [&](int scan) {
    return !hasAcceptedLink(decisions, scan) && search.hasRival({scan});
  });
  return found;
}

std::vector<std::vector<int>>
groupsOf(const std::vector<int>& members, const PlacedScans& placed, SamePlaceOdds& odds)
{
  std::vector<WeightedEdge> edges;
  for (const int source : members)
    for (const std::size_t k : placed.links_of[static_cast<std::size_t>(source)]) {
      const PairLink& link = placed.links[k];
      if (link.source != source || placed.assembly.used[k] < 0)
        continue;
      const Eigen::Isometry3d T = placed.assembly.poses[static_cast<std::size_t>(link.target)].inverse() *
                                  placed.assembly.poses[static_cast<std::size_t>(source)];
      edges.push_back({source, link.target, odds.of({{source, link.target, T}})});
    }
  std::vector<std::vector<int>> groups = weakestCuts(members, edges);
  groups.erase(std::remove_if(groups.begin(), groups.end(), [](const auto& group) { return group.size() < 2; }),
               groups.end());
  return groups;
}

std::vector<int>
findGroupWithRivalAlike(const std::vector<std::vector<int>>& asked,
                        const PlacedScans& placed,
                        SamePlaceOdds& odds,
                        const EvidenceFunction& evidence,
                        double most_by_links,
                        const MultiwayOptions& options)
{
  RivalAlikeSearch search(placed, odds, evidence, most_by_links, options);
  const auto found =
      std::find_if(asked.begin(), asked.end(), [&](const std::vector<int>& group) { return search.hasRival(group); });
  return found != asked.end() ? *found : std::vector<int>();
}

} // namespace pcl_ssfr
