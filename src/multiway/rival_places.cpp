// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/rival_places.h"

#include "common/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Where links put a scan.
struct ProposedPlaces {
  double agree = 0;                                         ///< sum of the beliefs of those that agree with where it is
  std::vector<std::pair<double, Eigen::Isometry3d>> rivals; ///< other places: sum of the probabilities, pose in the map
};

class RivalSearch {
public:
  RivalSearch(const PlacedScans& placed,
              const EvidenceFunction& evidence,
              const Decisions& decisions,
              const MultiwayOptions& options)
      : placed_(placed), evidence_(evidence), decisions_(decisions), options_(options)
  {}

  /// \param[in] members of its part
  /// \param[in] pile with it in it, or empty
  bool
  hasRival(int scan, std::vector<int> members, const std::vector<int>& pile) const
  {
    const auto is_of_pile = [&](int other) { return std::binary_search(pile.begin(), pile.end(), other); };
    members.erase(std::remove_if(members.begin(), members.end(), is_of_pile), members.end());
    if (hasAcceptedLink(decisions_, scan))
      return false;
    const ProposedPlaces places = placesOf(scan, pile);
    if (members.empty())
      return hasOthersToSee(scan);
    if (places.rivals.empty())
      return false;
    const bool by_surfaces = !pile.empty();
    const PlaceOdds here{by_surfaces ? 1 : places.agree, scoreAt(scan, pose(scan), members)};
    return std::any_of(places.rivals.begin(), places.rivals.end(), [&](const auto& rival) {
      return !isClear(here, {by_surfaces ? 1 : rival.first, scoreAt(scan, rival.second, members)}, options_);
    });
  }

private:
  double
  scoreAt(int scan, const Eigen::Isometry3d& at, const std::vector<int>& members) const
  {
    return scoreOf(surfacesAt(scan, at, members, placed_.assembly, evidence_, options_), contradictionWeight(options_));
  }
  const Eigen::Isometry3d&
  pose(int scan) const
  {
    return placed_.assembly.poses[static_cast<std::size_t>(scan)];
  }

  /// What its links to scans of its part say, but not to those of its pile.
  ProposedPlaces
  placesOf(int scan, const std::vector<int>& pile) const
  {
    const auto i = static_cast<std::size_t>(scan);
    const Eigen::Vector3d& place = placed_.places[i];
    ProposedPlaces found;
    for (const ProposedPose& proposed : proposedPoses(scan, placed_)) {
      if (placed_.assembly.part[static_cast<std::size_t>(proposed.other)] != placed_.assembly.part[i] ||
          std::binary_search(pile.begin(), pile.end(), proposed.other))
        continue;
      if (!areDistinct(pose(scan), proposed.T_part_scan, place, options_.choice))
        found.agree += proposed.belief;
      else if (pile.empty() ? proposed.prior >= options_.choice.rival : proposed.prior > 0)
        addRival(found, proposed.prior, proposed.T_part_scan, place);
    }
    return found;
  }

  /// Whether it was compared with a scan of another part.
  bool
  hasOthersToSee(int scan) const
  {
    const std::vector<std::size_t>& links = placed_.links_of[static_cast<std::size_t>(scan)];
    return std::any_of(links.begin(), links.end(), [&](std::size_t k) {
      const auto s = static_cast<std::size_t>(placed_.links[k].source);
      const auto t = static_cast<std::size_t>(placed_.links[k].target);
      return placed_.assembly.part[s] != placed_.assembly.part[t];
    });
  }

  void
  addRival(ProposedPlaces& found, double prior, const Eigen::Isometry3d& proposed, const Eigen::Vector3d& place) const
  {
    const auto same = std::find_if(found.rivals.begin(), found.rivals.end(), [&](const auto& rival) {
      return !areDistinct(rival.second, proposed, place, options_.choice);
    });
    if (same != found.rivals.end())
      same->first += prior;
    else
      found.rivals.emplace_back(prior, proposed);
  }

  const PlacedScans& placed_;
  const EvidenceFunction& evidence_;
  const Decisions& decisions_;
  const MultiwayOptions& options_;
};

} // namespace

PlacedScans::PlacedScans(const Assembly& its_assembly,
                         const std::vector<PairLink>& its_links,
                         const HypothesisGraph& its_graph,
                         const std::vector<Eigen::Vector3d>& its_places)
    : assembly(its_assembly), links(its_links), graph(its_graph), places(its_places), links_of(its_places.size())
{
  for (std::size_t k = 0; k < links.size(); ++k)
    for (const int scan : {links[k].source, links[k].target})
      links_of[static_cast<std::size_t>(scan)].push_back(k);
}

PlacementEvidence
surfacesAt(int scan,
           const Eigen::Isometry3d& at,
           const std::vector<int>& others,
           const Assembly& assembly,
           const EvidenceFunction& evidence,
           const MultiwayOptions& options)
{
  PlacementEvidence sum;
  for (const int other : others)
    if (other != scan)
      sum +=
          evidence(scan, other, assembly.poses[static_cast<std::size_t>(other)].inverse() * at, options.choice.loose);
  return sum;
}

double
logOdds(const PlaceOdds& chosen, const PlaceOdds& rival, double most_by_links, const ChoiceConfig& config)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!(rival.score > 0))
    return kInfinity;
  if (!(chosen.score > 0) || !(chosen.belief + rival.belief > 0))
    return -kInfinity;
  return std::min(std::log(chosen.belief / rival.belief), most_by_links) +
         config.score_power * std::log(chosen.score / rival.score);
}

bool
isClear(const PlaceOdds& chosen, const PlaceOdds& rival, const MultiwayOptions& options)
{
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  return rival.score <= chosen.score &&
         logOdds(chosen, rival, kUnbounded, options.choice) >= std::log(options.choice.clear_odds);
}

std::vector<ProposedPose>
proposedPoses(int scan, const PlacedScans& placed)
{
  std::vector<ProposedPose> proposed;
  for (const std::size_t k : placed.links_of[static_cast<std::size_t>(scan)]) {
    const PairLink& link = placed.links[k];
    const int other = link.source == scan ? link.target : link.source;
    const Eigen::Isometry3d& T_part_other = placed.assembly.poses[static_cast<std::size_t>(other)];
    for (std::size_t h = placed.graph.first[k]; h < placed.graph.first[k + 1]; ++h) {
      const WeighedHypothesis& w = placed.graph.hypotheses[h];
      const Eigen::Isometry3d& T = link.hypotheses[w.rank].T_target_source;
      proposed.push_back({other,
                          {link.source, link.target, T},
                          T_part_other * (link.source == scan ? T : T.inverse()),
                          w.prior,
                          w.belief});
    }
  }
  return proposed;
}

std::vector<int>
findScansWithRivals(const std::vector<int>& asked,
                    const PlacedScans& placed,
                    const EvidenceFunction& evidence,
                    const Piles& piles,
                    const Decisions& decisions,
                    const MultiwayOptions& options)
{
  const auto threads = static_cast<int>(options.threads);
  const RivalSearch search(placed, evidence, decisions, options);
  const auto parts = membersOf(placed.assembly);
  std::vector<char> has_rival(asked.size(), 0);
  forEachInParallel(static_cast<std::int64_t>(asked.size()), 1, threads, [&](std::int64_t index) {
    const int scan = asked[static_cast<std::size_t>(index)];
    const std::vector<int>& members = parts.at(placed.assembly.part[static_cast<std::size_t>(scan)]);
    const auto pile = piles.find(scan);
    if (members.size() > 2 && search.hasRival(scan, members, pile != piles.end() ? pile->second : std::vector<int>()))
      has_rival[static_cast<std::size_t>(index)] = 1;
  });
  std::vector<int> found;
  for (std::size_t k = 0; k < asked.size(); ++k)
    if (has_rival[k])
      found.push_back(asked[k]);
  return found;
}

} // namespace pcl_ssfr
