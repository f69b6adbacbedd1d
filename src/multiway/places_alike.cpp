// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/places_alike.h"

#include "common/parallel.h"
#include "multiway/parts.h"
#include "multiway/rival_places.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace pcl_ssfr {

namespace {

std::vector<int>
scansOf(const Piles& piles)
{
  std::set<int> scans;
  for (const auto& [i, pile] : piles)
    scans.insert(pile.begin(), pile.end());
  return {scans.begin(), scans.end()};
}

} // namespace

PlacesAlike::PlacesAlike(const MapInput& input,
                         const std::vector<PairLink>& links,
                         const MultiwayMap& map,
                         const std::vector<Eigen::Vector3d>& places,
                         PlacedEvidence& evidence)
    : input_(input), links_(links), map_(map), places_(places), evidence_(evidence)
{
  std::vector<int> placed;
  for (std::size_t i = 0; i < input.priors.size(); ++i)
    if (input.priors[i])
      placed.push_back(static_cast<int>(i));
  tied_ = tiedScans(input.decisions, placed, input.priors.size());
}

std::set<int>
PlacesAlike::inDoubt(const Assembly& assembly, const HypothesisGraph& graph) const
{
  const std::vector<int> by_links = refuted(assembly, graph);
  std::set<int> scans(by_links.begin(), by_links.end());
  for (const Doubt& doubt : rivalGroups(assembly))
    scans.insert(doubt.scans.begin(), doubt.scans.end());
  return scans;
}

template <typename Test>
ExcludedHypotheses
PlacesAlike::excludedBy(const std::set<int>& in_doubt, const Test& is_out) const
{
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (std::size_t k = 0; k < links_.size(); ++k)
    if (in_doubt.count(links_[k].source) + in_doubt.count(links_[k].target) > 0 &&
        !isDecided({links_[k].source, links_[k].target}))
      for (std::size_t rank = 0; rank < links_[k].hypotheses.size(); ++rank)
        all.emplace_back(k, rank);
  std::vector<char> found(all.size(), 0);
  const auto threads = static_cast<int>(input_.options.threads);
  forEachInParallel(static_cast<std::int64_t>(all.size()), 1, threads, [&](std::int64_t index) {
    const auto [k, rank] = all[static_cast<std::size_t>(index)];
    const PairLink& link = links_[k];
    if (is_out({link.source, link.target, link.hypotheses[rank].T_target_source}))
      found[static_cast<std::size_t>(index)] = 1;
  });
  ExcludedHypotheses out;
  for (std::size_t n = 0; n < all.size(); ++n)
    if (found[n])
      out.insert(all[n]);
  return out;
}

ExcludedHypotheses
PlacesAlike::contradicting(const std::set<int>& in_doubt) const
{
  return excludedBy(in_doubt, [&](const PlacedPair& pair) {
    const PlacementEvidence e = evidence_.at(pair.source, pair.target, pair.T_target_source, 1);
    return e.seen_through > input_.options.rival_groups.seen_through * e.in_view;
  });
}

void
PlacesAlike::findFurniture()
{
  furniture_.resize(input_.prepared.size());
  const auto threads = static_cast<int>(input_.options.threads);
  forEachInParallel(static_cast<std::int64_t>(furniture_.size()), 1, threads, [&](std::int64_t index) {
    const auto i = static_cast<std::size_t>(index);
    if (map_.scans[i].usable)
      furniture_[i] = furnitureOf(input_.prepared[i], input_.options.furniture);
  });
}

PlacementEvidence
PlacesAlike::furniture(int source, int target, const Eigen::Isometry3d& T_target_source) const
{
  const auto s = static_cast<std::size_t>(source), t = static_cast<std::size_t>(target);
  return furnitureAt(
      input_.prepared[s], furniture_[s], input_.prepared[t], furniture_[t], T_target_source, input_.options);
}

bool
PlacesAlike::mayStand(std::vector<PlacedPair> pairs) const
{
  const auto is_decided = [&](const PlacedPair& pair) { return isDecided({pair.source, pair.target}); };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_decided), pairs.end());
  const auto isOneStation = [&](const PlacedPair& pair) {
    const Eigen::Vector3d& place = places_[static_cast<std::size_t>(pair.source)];
    const Eigen::Vector3d& other = places_[static_cast<std::size_t>(pair.target)];
    return (pair.T_target_source * place - other).norm() < input_.options.choice.same_translation;
  };
  if (std::any_of(pairs.begin(), pairs.end(), isOneStation))
    return false;
  std::vector<PlacementEvidence> found(pairs.size());
  const int threads = pairs.size() > 1 ? static_cast<int>(input_.options.threads) : 1;
  forEachInParallel(static_cast<std::int64_t>(pairs.size()), 1, threads, [&](std::int64_t index) {
    const PlacedPair& pair = pairs[static_cast<std::size_t>(index)];
    found[static_cast<std::size_t>(index)] = furniture(pair.source, pair.target, pair.T_target_source);
  });
  PlacementEvidence sum;
  for (const PlacementEvidence& e : found)
    sum += e;
  return sum.seen_through <= input_.options.furniture.seen_through * sum.in_view;
}

ExcludedHypotheses
PlacesAlike::excluded(const std::set<int>& in_doubt) const
{
  return excludedBy(in_doubt, [&](const PlacedPair& pair) { return !mayStand({pair}); });
}

std::optional<RivalGroups>
PlacesAlike::rivalsOf(const Assembly& assembly, const std::vector<int>& members) const
{
  if (auto groups = rivalsByFurniture(assembly, members))
    return groups;
  const auto pairs = pairsOf(members);
  return findRivalGroups(members, pairs, evidence_.of(assembly, members, pairs), input_.options.rival_groups, tied_);
}

std::optional<RivalGroups>
PlacesAlike::rivalsByFurniture(const Assembly& assembly, const std::vector<int>& members) const
{
  if (furniture_.empty())
    return std::nullopt;
  const auto pairs = pairsOf(members);
  std::vector<PlacementEvidence> evidence(pairs.size());
  const auto threads = static_cast<int>(input_.options.threads);
  forEachInParallel(static_cast<std::int64_t>(pairs.size()), 1, threads, [&](std::int64_t index) {
    const auto [s, t] = pairs[static_cast<std::size_t>(index)];
    const PlacementEvidence e = furniture(
        s, t, assembly.poses[static_cast<std::size_t>(t)].inverse() * assembly.poses[static_cast<std::size_t>(s)]);
    if (e.in_view >= input_.options.furniture.least_seen)
      evidence[static_cast<std::size_t>(index)] = e;
  });
  RivalGroupsConfig config = input_.options.rival_groups;
  config.seen_through = input_.options.furniture.seen_through / 2; // the median of wrong groups is about that
  return findRivalGroups(members, pairs, evidence, config, tied_);
}

ExcludedHypotheses
PlacesAlike::betweenRivals(const Assembly& assembly) const
{
  ExcludedHypotheses out;
  for (const std::vector<int>& members : undecidedParts(assembly, 4)) {
    const auto groups = rivalsOf(assembly, members);
    if (!groups)
      continue;
    const std::set<int> first(groups->first.begin(), groups->first.end());
    const std::set<int> second(groups->second.begin(), groups->second.end());
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const PairLink& link = links_[k];
      if (!(first.count(link.source) > 0 && second.count(link.target) > 0) &&
          !(second.count(link.source) > 0 && first.count(link.target) > 0))
        continue;
      const auto s = static_cast<std::size_t>(link.source), t = static_cast<std::size_t>(link.target);
      const Eigen::Isometry3d T = assembly.poses[t].inverse() * assembly.poses[s];
      for (std::size_t rank = 0; rank < link.hypotheses.size(); ++rank)
        if (!areDistinct(link.hypotheses[rank].T_target_source, T, places_[s], input_.options.choice))
          out.insert({k, rank});
    }
  }
  return out;
}

std::vector<int>
PlacesAlike::refuted(const Assembly& assembly, const HypothesisGraph& graph) const
{
  std::vector<int> scans;
  if (!input_.options.alias.check)
    return scans;
  const ChoiceConfig& config = input_.options.choice;
  for (const std::vector<int>& members : undecidedParts(assembly, 2)) {
    const int part = assembly.part[static_cast<std::size_t>(members.front())];
    SureLinks sure = countSureLinks(assembly, links_, graph, part, SureBy::Pair, config);
    if (!isRefuted(sure, config))
      sure = countSureLinks(assembly, links_, graph, part, SureBy::Loops, config);
    if (isRefuted(sure, config))
      scans.insert(scans.end(), members.begin(), members.end());
  }
  return scans;
}

std::vector<int>
PlacesAlike::misled(const Assembly& assembly, const std::vector<int>& with_rivals) const
{
  if (!input_.options.alias.check)
    return {};
  return scansOfMisledParts(undecidedParts(assembly, 2), with_rivals);
}

std::vector<Doubt>
PlacesAlike::rivalGroups(const Assembly& assembly) const
{
  std::vector<Doubt> doubts;
  if (!input_.options.alias.check)
    return doubts;
  for (const std::vector<int>& members : undecidedParts(assembly, 4)) {
    const auto groups = rivalsOf(assembly, members);
    if (groups)
      doubts.push_back({members,
                        std::to_string(groups->first.size()) + " and " + std::to_string(groups->second.size()) +
                            " scans (with " + name(groups->first.front()) + " and " + name(groups->second.front()) +
                            ") contradict each other more than among themselves: places look alike there, or changed "
                            "between the scans, so all scans of that part are kept apart (approximate --poses or "
                            "--accept decide)"});
  }
  return doubts;
}

std::vector<Doubt>
PlacesAlike::sameStations(const Assembly& assembly, const std::set<int>& in_doubt) const
{
  std::vector<Doubt> doubts;
  for (const std::vector<int>& members : undecidedParts(assembly, 1)) {
    if (std::none_of(members.begin(), members.end(), [&](int i) { return in_doubt.count(i) > 0; }))
      continue;
    const ChoiceConfig& choice = input_.options.choice;
    const std::vector<int> found =
        scansOf(pilesOf(assembly, members, choice.loose * choice.same_translation, SeenInPile::TheSame));
    if (!isDecided(found))
      doubts.push_back({found,
                        inWords(found) +
                            " would stand at one place and see the same, where places look alike: they are kept "
                            "apart (approximate --poses or --accept decide)"});
  }
  return doubts;
}

std::vector<Doubt>
PlacesAlike::contradictingStations(const Assembly& assembly) const
{
  std::vector<Doubt> doubts;
  if (!input_.options.alias.check)
    return doubts;
  const AliasConfig& config = input_.options.alias;
  for (const std::vector<int>& members : undecidedParts(assembly, config.least_scans)) {
    Piles piles = pilesOf(assembly, members, input_.options.choice.same_translation, SeenInPile::Anything);
    const auto pairs = pairsOf(members);
    const std::vector<PlacementEvidence>& evidence = evidence_.of(assembly, members, pairs);
    Piles contradicting;
    for (auto& [i, pile] : piles) {
      PlacementEvidence sum;
      for (const auto& pair : pairsOf(pile)) // in the order of all pairs, which is ascending
        sum += evidence[static_cast<std::size_t>(std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin())];
      if (sum.contradicted > config.seen_through * sum.matched)
        contradicting[i] = std::move(pile);
    }
    const std::vector<int> found = scansOf(contradicting);
    if (!isDecided(found))
      doubts.push_back({found,
                        inWords(found) +
                            " would stand at one place and contradict each other: rooms that look alike; they are "
                            "kept apart (approximate --poses or --accept decide)"});
  }
  return doubts;
}

Piles
PlacesAlike::piles(const Assembly& assembly) const
{
  Piles piles;
  if (!input_.options.alias.check)
    return piles;
  const double within = input_.options.choice.same_translation;
  for (const std::vector<int>& members : undecidedParts(assembly, input_.options.alias.least_scans)) {
    const Piles there = pilesOf(assembly, members, within, SeenInPile::Anything);
    for (const auto& [i, alike] : pilesOf(assembly, members, within, SeenInPile::TheSame))
      for (const int j : there.at(i))
        if (there.count(j) > 0)
          piles[j] = there.at(j);
  }
  return piles;
}

std::vector<std::string>
PlacesAlike::repeatedStations(const Assembly& assembly) const
{
  std::vector<std::string> notes;
  if (!input_.options.alias.check)
    return notes;
  for (const std::vector<int>& members : undecidedParts(assembly, 1)) {
    const std::vector<int> found =
        scansOf(pilesOf(assembly, members, input_.options.choice.same_translation, SeenInPile::TheSame));
    if (!isDecided(found))
      notes.push_back(inWords(found) +
                      " stand where others do and see the same: if they were not taken there, places look alike and "
                      "are laid onto one another (--reject or approximate --poses decide)");
  }
  return notes;
}

Piles
PlacesAlike::pilesOf(const Assembly& assembly, const std::vector<int>& members, double within, SeenInPile seen) const
{
  std::vector<Eigen::Vector3d> stations;
  stations.reserve(members.size());
  for (const int i : members)
    stations.push_back(assembly.poses[static_cast<std::size_t>(i)] * places_[static_cast<std::size_t>(i)]);
  const auto pairs = pairsOf(members);
  const auto counts = [&](const PlacementEvidence& pair) {
    return seen == SeenInPile::Anything || pair.matched >= input_.options.alias.same_view * pair.total;
  };
  return findPiles(members,
                   stations,
                   within,
                   pairs,
                   evidence_.of(assembly, members, pairs),
                   counts,
                   input_.options.alias.least_scans);
}

std::vector<Doubt>
PlacesAlike::storeys(const Assembly& assembly) const
{
  std::vector<Doubt> doubts;
  if (!input_.options.alias.check)
    return doubts;
  std::size_t usable = 0;
  for (std::size_t i = 0; i < map_.scans.size(); ++i)
    usable += map_.scans[i].usable && input_.original[i] == static_cast<int>(i) ? 1 : 0;
  for (const std::vector<int>& members : undecidedParts(assembly, 2)) {
    std::vector<StoreyScan> scans;
    for (const int member : members) {
      const auto i = static_cast<std::size_t>(member);
      scans.push_back(storeyScan(input_.prepared[i], assembly.poses[i]));
    }
    const std::optional<Eigen::Vector3d> up = findUp(scans, input_.options.gravity, input_.options.alias);
    const double same_place = input_.options.choice.same_translation;
    const std::optional<StoreyDoubt> found =
        up ? findStoreyDoubt(scans, *up, members.size() < usable, same_place, input_.options.alias) : std::nullopt;
    std::vector<int> level;
    for (std::size_t k = 0; found && k < found->level.size(); ++k)
      level.push_back(members[found->level[k]]);
    if (isDecided(level))
      continue;
    Doubt doubt;
    doubt.note =
        "a storey of " + std::to_string(level.size()) +
        " scans may be several that look alike, laid onto one another: stairs lead from it to no other level, and no "
        "scan distinguishes the storeys; its scans are kept apart (approximate --poses or --accept decide)";
    for (const std::size_t k : scansInDoubt(scans, *found, same_place))
      doubt.scans.push_back(members[k]);
    doubts.push_back(std::move(doubt));
  }
  return doubts;
}

std::vector<std::vector<int>>
PlacesAlike::undecidedParts(const Assembly& assembly, std::size_t least) const
{
  std::vector<std::vector<int>> parts;
  for (auto& [part, members] : membersOf(assembly))
    if (members.size() >= least && !isDecided(members))
      parts.push_back(std::move(members));
  return parts;
}

bool
PlacesAlike::isDecided(const std::vector<int>& scans) const
{
  return std::all_of(scans.begin(), scans.end(), [&](int i) {
    return tied_[static_cast<std::size_t>(i)] == tied_[static_cast<std::size_t>(scans.front())];
  });
}

std::string
PlacesAlike::inWords(const std::vector<int>& scans) const
{
  return std::to_string(scans.size()) + " scans (with " + name(scans.front()) + ")";
}

const std::string&
PlacesAlike::name(int scan) const
{
  return map_.scans[static_cast<std::size_t>(scan)].name;
}

} // namespace pcl_ssfr
