// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/same_place.h"

#include "common/parallel.h"
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

class RivalAlikeSearch {
public:
  RivalAlikeSearch(const PlacedScans& placed,
                   SamePlaceOdds& odds,
                   const EvidenceFunction& evidence,
                   double most_by_links,
                   const Decisions& decisions,
                   const MultiwayOptions& options)
      : placed_(placed), odds_(odds), evidence_(evidence), most_by_links_(most_by_links), decisions_(decisions),
        options_(options), parts_(membersOf(placed.assembly))
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
      const bool competes = there == part ? !isClearOf(scan, rival) : oddsAt(scan, there, rival) > std::max(here, 0.0);
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

  /// Of a rival in its part: by what distinguishes places, by its links, and by all surfaces of the others; not by
  /// those that stand where it does, which would confirm each other anywhere.
  bool
  isClearOf(int scan, const Eigen::Isometry3d& rival)
  {
    const std::vector<int>& members = parts_.at(partOf(scan));
    const std::vector<int> at_same_place = standingAt(scan, pose(scan)); // in the order of the members
    std::vector<int> others;
    std::set_difference(
        members.begin(), members.end(), at_same_place.begin(), at_same_place.end(), std::back_inserter(others));
    PlaceOdds here, there;
    for (const ProposedPose& proposed : proposedPoses(scan, placed_)) {
      if (!std::binary_search(others.begin(), others.end(), proposed.other))
        continue;
      if (!isDistinct(scan, pose(scan), proposed.T_part_scan))
        here.belief += proposed.belief;
      else if (!isDistinct(scan, rival, proposed.T_part_scan))
        there.belief += proposed.prior;
    }
    here.score = scoreAt(scan, pose(scan), others, placed_.assembly, evidence_, options_);
    there.score = scoreAt(scan, rival, others, placed_.assembly, evidence_, options_);
    return oddsAgainst(scan, rival) + logOdds(here, there, most_by_links_, options_.choice) >=
           std::log(options_.choice.clear_odds);
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
  const EvidenceFunction& evidence_;
  double most_by_links_;
  const Decisions& decisions_;
  const MultiwayOptions& options_;
  std::map<int, std::vector<int>> parts_;
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
SamePlaceOdds::of(const std::vector<PlacedPair>& pairs)
{
  std::vector<PlacedPair> ordered;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(ordered), [&](const PlacedPair& pair) {
    return !are_unrelated_ || !are_unrelated_(pair);
  });
  std::vector<double> found(ordered.size());
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < ordered.size(); ++k) {
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

std::vector<int>
findScansWithRivalsAlike(const std::vector<int>& asked,
                         const PlacedScans& placed,
                         SamePlaceOdds& odds,
                         const EvidenceFunction& evidence,
                         double most_by_links,
                         const Decisions& decisions,
                         const MultiwayOptions& options)
{
  RivalAlikeSearch search(placed, odds, evidence, most_by_links, decisions, options);
  std::vector<int> found;
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(found), [&](int scan) { return search.hasRival(scan); });
  return found;
}

} // namespace pcl_ssfr
