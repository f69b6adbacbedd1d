// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/decisions.h"

#include "common/angles.h"

#include <algorithm>
#include <numeric>

namespace pcl_ssfr {

namespace {

const std::string&
nameOf(const std::vector<MapScan>& scans, int scan)
{
  return scans[static_cast<std::size_t>(scan)].name;
}

/// Pairs of the scans that are linked.
std::set<std::pair<int, int>>
pairsOfOriginals(const std::set<std::pair<int, int>>& pairs,
                 const std::vector<int>& original,
                 const char* kind,
                 const std::vector<MapScan>& scans)
{
  std::set<std::pair<int, int>> found;
  for (const auto& [a, b] : pairs) {
    const auto pair = std::minmax({original[static_cast<std::size_t>(a)], original[static_cast<std::size_t>(b)]});
    if (pair.first == pair.second)
      throw DecisionError(std::string("the ") + kind + " link of " + nameOf(scans, pair.first) +
                          " is of a scan with itself");
    found.insert(pair);
  }
  return found;
}

} // namespace

bool
isAccepted(const Decisions& decisions, int source, int target)
{
  return decisions.accepted.count({source, target}) > 0;
}

bool
isRejected(const Decisions& decisions, int source, int target)
{
  return decisions.rejected.count({source, target}) > 0;
}

bool
hasAcceptedLink(const Decisions& decisions, int scan)
{
  return std::any_of(decisions.accepted.begin(), decisions.accepted.end(), [scan](const auto& pair) {
    return pair.first == scan || pair.second == scan;
  });
}

Decisions
onOriginals(const Decisions& given, const std::vector<int>& original, const std::vector<MapScan>& scans)
{
  Decisions decisions;
  decisions.accepted = pairsOfOriginals(given.accepted, original, "accepted", scans);
  decisions.rejected = pairsOfOriginals(given.rejected, original, "rejected", scans);
  for (const auto& [a, b] : decisions.accepted)
    if (decisions.rejected.count({a, b}) > 0)
      throw DecisionError("the link " + nameOf(scans, a) + ", " + nameOf(scans, b) + " is both accepted and rejected");
  for (const int scan : given.pinned)
    decisions.pinned.push_back(original[static_cast<std::size_t>(scan)]);
  return decisions;
}

std::vector<int>
tiedScans(const Decisions& decisions, const std::vector<int>& placed, std::size_t count)
{
  std::vector<int> tied(count);
  std::iota(tied.begin(), tied.end(), 0);
  const auto tie = [&](int a, int b) {
    const int of_a = tied[static_cast<std::size_t>(a)], of_b = tied[static_cast<std::size_t>(b)];
    std::replace(tied.begin(), tied.end(), of_b, of_a);
  };
  for (const auto& [a, b] : decisions.accepted)
    tie(a, b);
  for (const int i : placed)
    tie(placed.front(), i);
  return tied;
}

bool
areTiedToOthers(const std::vector<int>& group, const std::vector<int>& members, const std::vector<int>& tied)
{
  std::set<int> ties;
  for (const int scan : group)
    ties.insert(tied[static_cast<std::size_t>(scan)]);
  return std::any_of(members.begin(), members.end(), [&](int scan) {
    return ties.count(tied[static_cast<std::size_t>(scan)]) > 0 &&
           !std::binary_search(group.begin(), group.end(), scan);
  });
}

PairGuess
guessOf(const PosePrior& source,
        const PosePrior& target,
        const Eigen::Vector3d& source_place,
        const Eigen::Vector3d& target_place)
{
  const double distance = (source.T_map_scan * source_place - target.T_map_scan * target_place).norm();
  PairGuess guess;
  guess.T_target_source = target.T_map_scan.inverse() * source.T_map_scan;
  guess.tolerance.rotation = std::min(kPi, source.rotation + target.rotation);
  guess.tolerance.translation = source.translation + target.translation + distance * target.rotation;
  return guess;
}

std::vector<std::pair<std::string, std::string>>
inWords(const Decisions& given, const std::vector<MapScan>& scans)
{
  std::vector<std::pair<std::string, std::string>> words;
  for (const auto& [kind, pairs] : {std::pair("accept", &given.accepted), {"reject", &given.rejected}})
    for (const auto& [a, b] : *pairs)
      words.emplace_back(kind, nameOf(scans, a) + "," + nameOf(scans, b));
  for (const int scan : given.pinned)
    words.emplace_back("pin", nameOf(scans, scan));
  return words;
}

} // namespace pcl_ssfr
