// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/places_alike.h"

#include "common/parallel.h"
#include "multiway/parts.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
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

std::vector<int>
PlacesAlike::undecidedScans(const Assembly& assembly) const
{
  std::vector<int> scans;
  for (const std::vector<int>& members : undecidedParts(assembly, 1))
    scans.insert(scans.end(), members.begin(), members.end());
  return scans;
}

FurnitureFindings
PlacesAlike::findFurniture(const HypothesisGraph& graph)
{
  FurnitureFindings findings;
  if (!input_.options.alias.check)
    return findings;
  furniture_.resize(input_.prepared.size());
  const FurnitureConfig& config = input_.options.furniture;
  const auto threads = static_cast<int>(input_.options.threads);
  forEachInParallel(static_cast<std::int64_t>(furniture_.size()), 1, threads, [&](std::int64_t index) {
    const auto i = static_cast<std::size_t>(index);
    if (map_.scans[i].usable)
      furniture_[i] = furnitureOf(input_.prepared[i], input_.options);
  });
  std::vector<PlacedPair> sure;
  for (const WeighedHypothesis& w : graph.hypotheses) {
    const PairLink& link = links_[w.link];
    if (w.prior >= input_.options.choice.sure && !isDecided({link.source, link.target}))
      sure.push_back({link.source, link.target, link.hypotheses[w.rank].T_target_source});
  }
  std::vector<FurnitureEvidence> evidence(sure.size());
  forEachInParallel(static_cast<std::int64_t>(sure.size()), 1, threads, [&](std::int64_t index) {
    const auto k = static_cast<std::size_t>(index);
    evidence[k] = furniture(sure[k].source, sure[k].target, sure[k].T_target_source);
  });
  std::vector<FurnitureEvidence> walled;
  for (std::size_t k = 0; k < sure.size(); ++k)
    if (isOfWalled(sure[k].source) && isOfWalled(sure[k].target))
      walled.push_back(evidence[k]);
  findings.false_share = shareOfPlacesAlike(evidence, config);
  findings.false_share_of_walled = shareOfPlacesAlike(walled, config);
  return findings;
}

bool
PlacesAlike::isOfWalled(int scan) const
{
  const auto i = static_cast<std::size_t>(scan);
  return isWalled(input_.prepared[i], furniture_[i]);
}

FurnitureEvidence
PlacesAlike::furniture(int source, int target, const Eigen::Isometry3d& T_target_source) const
{
  const auto s = static_cast<std::size_t>(source), t = static_cast<std::size_t>(target);
  return furnitureAt(
      input_.prepared[s], furniture_[s], input_.prepared[t], furniture_[t], T_target_source, input_.options);
}

double
PlacesAlike::samePlaceLogOdds(const PlacedPair& pair, FurnitureOf whose) const
{
  if (furniture_.empty())
    return 0;
  if (whose == FurnitureOf::Walled)
    return isOfWalled(pair.source) && isOfWalled(pair.target)
               ? logOddsAmongMany(furniture(pair.source, pair.target, pair.T_target_source), input_.options.furniture)
               : 0;
  if (isDecided({pair.source, pair.target}))
    return std::log(input_.options.choice.clear_odds);
  const Eigen::Vector3d& place = places_[static_cast<std::size_t>(pair.source)];
  const Eigen::Vector3d& other = places_[static_cast<std::size_t>(pair.target)];
  const ChoiceConfig& choice = input_.options.choice;
  const bool is_one_station = (pair.T_target_source * place - other).norm() < choice.same_translation;
  const FurnitureEvidence e = furniture(pair.source, pair.target, pair.T_target_source);
  return logOddsAmongMany(e, input_.options.furniture) - (is_one_station ? std::log(choice.clear_odds) : 0);
}

bool
PlacesAlike::areUnrelated(int source, int target, double distance) const
{
  return tied_[static_cast<std::size_t>(source)] != tied_[static_cast<std::size_t>(target)] &&
         evidence_.areTooFar(source, target, distance);
}

double
PlacesAlike::refutedShare(const Assembly& assembly, const HypothesisGraph& graph) const
{
  double largest = 0;
  if (!input_.options.alias.check)
    return largest;
  const ChoiceConfig& config = input_.options.choice;
  for (const std::vector<int>& members : undecidedParts(assembly, 2)) {
    const int part = assembly.part[static_cast<std::size_t>(members.front())];
    for (const SureBy by : {SureBy::Pair, SureBy::Loops}) {
      const SureLinks sure = countSureLinks(assembly, links_, graph, part, by, config);
      if (isRefuted(sure, config))
        largest = std::max(largest, sure.contradicted / static_cast<double>(sure.wrong.size()));
    }
  }
  return largest;
}

Piles
PlacesAlike::piles(const Assembly& assembly) const
{
  Piles piles;
  if (!input_.options.alias.check)
    return piles;
  for (const std::vector<int>& members : undecidedParts(assembly, input_.options.alias.least_scans)) {
    const Piles there = pilesOf(assembly, members, SeenInPile::Anything);
    for (const auto& [i, alike] : pilesOf(assembly, members, SeenInPile::TheSame))
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
    const std::vector<int> found = scansOf(pilesOf(assembly, members, SeenInPile::TheSame));
    if (!isDecided(found))
      notes.push_back(inWords(found) +
                      " stand where others do and see the same: if they were not taken there, places look alike and "
                      "are laid onto one another (--reject or approximate --poses decide)");
  }
  return notes;
}

Piles
PlacesAlike::pilesOf(const Assembly& assembly, const std::vector<int>& members, SeenInPile seen) const
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
                   input_.options.choice.same_translation,
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
