// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/candidate_pairs.h"

#include "common/parallel.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace pcl_ssfr {

namespace {

ScanPair
ordered(int a, int b)
{
  return {std::min(a, b), std::max(a, b)};
}

/// A pair that was linked and leads to others.
struct Way {
  int to;
  Eigen::Isometry3d T_to_from;
  double weight;
  bool is_new;
};

/// How much a link is trusted on the way to others: by its best pose.
double
weightOf(const PairLink& link)
{
  return (1 - link.probability_of_none) * link.hypotheses.front().overlap;
}

bool
isLikely(const PairLink& link, double least)
{
  return !link.hypotheses.empty() && 1 - link.probability_of_none >= least;
}

} // namespace

CandidatePairs::CandidatePairs(CandidateScans scans, OverlapFunction overlap, const MultiwayOptions& options)
    : scans_(std::move(scans)), overlap_(std::move(overlap)), options_(options), likeness_(scans_.signatures),
      partners_(scans_.usable.size(), 0)
{}

std::vector<ScanPair>
CandidatePairs::next(const Links& links)
{
  std::set<ScanPair> pairs;
  if (given_.empty())
    pairs = alikeOnes();
  else
    pairs = neighboursOfNeighbours(links);
  if (pairs.empty())
    pairs = nearOnes(links);
  if (pairs.empty())
    pairs = betweenParts(links);
  given_.insert(pairs.begin(), pairs.end());
  return {pairs.begin(), pairs.end()};
}

bool
CandidatePairs::isOpen(int a, int b) const
{
  return a != b && scans_.usable[static_cast<std::size_t>(a)] && scans_.usable[static_cast<std::size_t>(b)] &&
         given_.count(ordered(a, b)) == 0;
}

std::vector<int>
CandidatePairs::mostAlike(int scan, std::size_t count, const std::function<bool(int)>& isWanted) const
{
  std::vector<int> others;
  for (int other = 0; other < static_cast<int>(scans_.usable.size()); ++other)
    if (isWanted(other) && isOpen(scan, other))
      others.push_back(other);
  if (others.empty())
    return others;
  const Eigen::VectorXf likeness = likeness_.of(static_cast<std::size_t>(scan));
  const auto middle = others.begin() + static_cast<std::ptrdiff_t>(std::min(count, others.size()));
  std::partial_sort(others.begin(), middle, others.end(), [&](int a, int b) {
    return likeness[a] != likeness[b] ? likeness[a] > likeness[b] : a < b;
  });
  others.erase(middle, others.end());
  return others;
}

std::set<ScanPair>
CandidatePairs::alikeOnes() const
{
  std::set<ScanPair> pairs;
  for (const ScanPair& pair : scans_.wanted)
    if (isOpen(pair.first, pair.second))
      pairs.insert(pair);
  const std::size_t n = scans_.usable.size();
  std::vector<std::vector<int>> partners(n);
  forEachInParallel(static_cast<std::int64_t>(n), 1, static_cast<int>(options_.threads), [&](std::int64_t i) {
    partners[static_cast<std::size_t>(i)] =
        mostAlike(static_cast<int>(i), options_.candidates.alike, [](int) { return true; });
  });
  for (std::size_t i = 0; i < n; ++i)
    for (const int k : partners[i])
      pairs.insert(ordered(static_cast<int>(i), k));
  Part known;
  for (std::size_t i = 0; i < n; ++i)
    if (scans_.T_map_scan[i]) {
      known.scans.push_back(static_cast<int>(i));
      known.poses.push_back(*scans_.T_map_scan[i]);
    }
  forEachNear(known, [&](std::size_t a, std::size_t b) { pairs.insert(ordered(known.scans[a], known.scans[b])); });
  return pairs;
}

std::set<ScanPair>
CandidatePairs::neighboursOfNeighbours(const Links& links)
{
  std::vector<std::vector<Way>> ways(scans_.usable.size());
  for (const PairLink& link : links) {
    if (!isLikely(link, options_.choice.sure))
      continue;
    const Eigen::Isometry3d& T = link.hypotheses.front().T_target_source;
    const bool is_new = seen_.insert({link.source, link.target}).second;
    ways[static_cast<std::size_t>(link.source)].push_back({link.target, T, weightOf(link), is_new});
    ways[static_cast<std::size_t>(link.target)].push_back({link.source, T.inverse(), weightOf(link), is_new});
  }
  Proposals proposals;
  for (const std::vector<Way>& from : ways)
    for (std::size_t a = 0; a < from.size(); ++a)
      for (std::size_t b = a + 1; b < from.size(); ++b)
        if ((from[a].is_new || from[b].is_new) && isOpen(from[a].to, from[b].to))
          propose(from[a].to,
                  from[b].to,
                  from[b].T_to_from * from[a].T_to_from.inverse(),
                  from[a].weight * from[b].weight,
                  proposals);
  return worthIt(proposals);
}

void
CandidatePairs::propose(int a, int b, const Eigen::Isometry3d& T_b_a, double weight, Proposals& proposals) const
{
  Proposal& best = proposals[ordered(a, b)];
  if (weight > best.weight)
    best = {a < b ? T_b_a : T_b_a.inverse(), weight};
}

std::set<ScanPair>
CandidatePairs::worthIt(const Proposals& proposals)
{
  std::vector<const Proposals::value_type*> all;
  all.reserve(proposals.size());
  for (const auto& proposal : proposals)
    all.push_back(&proposal);
  std::vector<double> meets(all.size());
  forEachInParallel(
      static_cast<std::int64_t>(all.size()), 1, static_cast<int>(options_.threads), [&](std::int64_t index) {
        const auto k = static_cast<std::size_t>(index);
        meets[k] = overlap_(all[k]->first.first, all[k]->first.second, all[k]->second.T_target_source);
      });
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return meets[a] > meets[b]; });
  // A pose by way of others is inexact: what is worth it meets in twice as much as takes part in the adjustment.
  const double least = 2 * options_.adjustment.least_matched;
  std::set<ScanPair> pairs;
  for (const std::size_t k : order) {
    const ScanPair& pair = all[k]->first;
    std::size_t& of_source = partners_[static_cast<std::size_t>(pair.first)];
    std::size_t& of_target = partners_[static_cast<std::size_t>(pair.second)];
    if (meets[k] < least || of_source >= options_.candidates.most || of_target >= options_.candidates.most)
      continue;
    ++of_source;
    ++of_target;
    pairs.insert(pair);
  }
  return pairs;
}

std::set<ScanPair>
CandidatePairs::nearOnes(const Links& links)
{
  Proposals proposals;
  for (const Part& part : partsOf(links))
    forEachNear(part, [&](std::size_t a, std::size_t b) {
      propose(part.scans[a], part.scans[b], part.poses[b].inverse() * part.poses[a], 1, proposals);
    });
  return worthIt(proposals);
}

void
CandidatePairs::forEachNear(const Part& part, const std::function<void(std::size_t, std::size_t)>& visit) const
{
  const std::size_t n = part.scans.size();
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i)
    places.col(static_cast<Eigen::Index>(i)) = part.poses[i] * scans_.places[static_cast<std::size_t>(part.scans[i])];
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::pair<double, std::size_t>> others; // distance
    for (std::size_t k = 0; k < n; ++k)
      if (isOpen(part.scans[i], part.scans[k]))
        others.emplace_back(
            (places.col(static_cast<Eigen::Index>(k)) - places.col(static_cast<Eigen::Index>(i))).squaredNorm(), k);
    const auto middle = others.begin() + static_cast<std::ptrdiff_t>(std::min(options_.candidates.near, others.size()));
    std::partial_sort(others.begin(), middle, others.end());
    for (auto other = others.begin(); other != middle; ++other)
      visit(i, other->second);
  }
}

std::vector<CandidatePairs::Part>
CandidatePairs::partsOf(const Links& links) const
{
  // A spanning forest of the heaviest sure links, as Kruskal makes it: the smaller part moves into the larger one.
  std::vector<const PairLink*> sure;
  for (const PairLink& link : links)
    if (isLikely(link, options_.choice.lone))
      sure.push_back(&link);
  std::sort(sure.begin(), sure.end(), [](const PairLink* a, const PairLink* b) {
    const double weight_a = weightOf(*a), weight_b = weightOf(*b);
    return weight_a != weight_b ? weight_a > weight_b
                                : std::pair(a->source, a->target) < std::pair(b->source, b->target);
  });
  const std::size_t n = scans_.usable.size();
  std::vector<std::size_t> part(n);
  std::iota(part.begin(), part.end(), std::size_t{0});
  std::vector<std::vector<int>> members(n);
  std::vector<Eigen::Isometry3d> poses(n, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < n; ++i)
    if (scans_.usable[i])
      members[i].push_back(static_cast<int>(i));
  for (const PairLink* link : sure) {
    const auto source = static_cast<std::size_t>(link->source), target = static_cast<std::size_t>(link->target);
    std::size_t from = part[source], into = part[target];
    if (from == into)
      continue;
    Eigen::Isometry3d T = poses[target] * link->hypotheses.front().T_target_source * poses[source].inverse();
    if (members[from].size() > members[into].size()) {
      std::swap(from, into);
      T = T.inverse();
    }
    for (const int scan : members[from]) {
      auto& pose = poses[static_cast<std::size_t>(scan)];
      pose = T * pose;
      part[static_cast<std::size_t>(scan)] = into;
    }
    members[into].insert(members[into].end(), members[from].begin(), members[from].end());
    members[from].clear();
  }
  std::vector<Part> parts;
  for (std::vector<int>& scans : members) {
    if (scans.empty())
      continue;
    std::sort(scans.begin(), scans.end());
    Part found;
    for (const int scan : scans)
      found.poses.push_back(poses[static_cast<std::size_t>(scan)]);
    found.scans = std::move(scans);
    parts.push_back(std::move(found));
  }
  return parts;
}

std::set<ScanPair>
CandidatePairs::betweenParts(const Links& links)
{
  const CandidateConfig& config = options_.candidates;
  std::set<ScanPair> pairs;
  const std::vector<Part> parts = partsOf(links);
  if (parts.size() < 2 || parts.size() == parts_ || apart_rounds_ >= config.apart_rounds)
    return pairs;
  parts_ = parts.size();
  ++apart_rounds_;
  std::vector<std::size_t> part(scans_.usable.size());
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (const int scan : parts[p].scans)
      part[static_cast<std::size_t>(scan)] = p;
  // As many for each scan: few of a part see another part, and those are not the ones that are most like something.
  for (const Part& from : parts) {
    const std::size_t in_all = config.apart / from.scans.size() + (config.apart % from.scans.size() > 0);
    const std::size_t count = std::max(config.apart_of_scan, in_all);
    for (const int scan : from.scans) {
      const auto is_elsewhere = [&](int other) {
        return part[static_cast<std::size_t>(other)] != part[static_cast<std::size_t>(scan)];
      };
      for (const int other : mostAlike(scan, count, is_elsewhere))
        pairs.insert(ordered(scan, other));
    }
  }
  return pairs;
}

} // namespace pcl_ssfr
