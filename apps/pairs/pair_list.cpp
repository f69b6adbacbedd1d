// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/pair_list.h>

#include <deque>
#include <map>
#include <set>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

using io::ScanPair;
using Poses = std::map<std::string, Eigen::Isometry3d>; ///< T_scan_source by scan

/// The listed pairs as links that can be walked in both directions.
class PairGraph {
public:
  explicit PairGraph(const std::vector<ScanPair>& pairs)
  {
    for (const ScanPair& pair : pairs) {
      links_[pair.source].push_back({pair.target, pair.T_target_source});
      links_[pair.target].push_back({pair.source, pair.T_target_source.inverse()});
    }
  }

  /// Poses of a scan in all scans that chains connect it to, by the shortest chain; its own included.
  Poses
  posesOf(const std::string& source) const
  {
    Poses found = {{source, Eigen::Isometry3d::Identity()}};
    std::deque<std::string> open = {source};
    while (!open.empty()) {
      const std::string scan = open.front();
      open.pop_front();
      for (const Link& link : links_.at(scan))
        if (found.emplace(link.target, link.T_target_source * found.at(scan)).second)
          open.push_back(link.target);
    }
    return found;
  }

  /// Names of all scans, sorted.
  std::vector<std::string>
  scans() const
  {
    std::vector<std::string> names;
    for (const auto& [name, links] : links_)
      names.push_back(name);
    return names;
  }

private:
  struct Link {
    std::string target;
    Eigen::Isometry3d T_target_source;
  };
  std::map<std::string, std::vector<Link>> links_;
};

std::set<std::pair<std::string, std::string>>
namesOf(const std::vector<ScanPair>& pairs)
{
  std::set<std::pair<std::string, std::string>> names;
  for (const ScanPair& pair : pairs)
    names.emplace(pair.source, pair.target);
  return names;
}

std::vector<ListedPair>
listedPairs(const std::vector<ScanPair>& pairs)
{
  std::vector<ListedPair> listed;
  listed.reserve(pairs.size());
  for (const ScanPair& pair : pairs)
    listed.push_back({pair.source, pair.target, pair.T_target_source});
  return listed;
}

std::vector<ListedPair>
unlistedPairs(const std::vector<ScanPair>& pairs)
{
  const PairGraph graph(pairs);
  const auto given = namesOf(pairs);
  std::vector<ListedPair> unlisted;
  for (const std::string& source : graph.scans())
    for (const auto& [target, T_target_source] : graph.posesOf(source))
      if (target != source && given.count({source, target}) == 0)
        unlisted.push_back({source, target, T_target_source});
  return unlisted;
}

/// A pair that is listed in one direction alone comes in that direction.
std::vector<ListedPair>
allPairs(const std::vector<ScanPair>& pairs)
{
  const PairGraph graph(pairs);
  const auto given = namesOf(pairs);
  const std::vector<std::string> scans = graph.scans();
  std::vector<ListedPair> all;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Poses poses = graph.posesOf(scans[i]);
    for (std::size_t k = i + 1; k < scans.size(); ++k) {
      const auto pose = poses.find(scans[k]);
      ListedPair pair{scans[i], scans[k], std::nullopt};
      if (pose != poses.end())
        pair.T_target_source = pose->second;
      if (given.count({scans[k], scans[i]}) > 0 && given.count({scans[i], scans[k]}) == 0) {
        std::swap(pair.source, pair.target);
        pair.T_target_source = pair.T_target_source->inverse();
      }
      all.push_back(pair);
    }
  }
  return all;
}

std::vector<ListedPair>
unrelatedPairs(const std::vector<ScanPair>& pairs, const std::vector<ScanPair>& others)
{
  std::vector<ListedPair> unrelated;
  for (std::size_t i = 0; i < pairs.size() && !others.empty(); ++i)
    unrelated.push_back({pairs[i].source, others[i % others.size()].target, std::nullopt});
  return unrelated;
}

} // namespace

PairList::PairList(const io::DatasetFolder& dataset, const io::DatasetFolder& targets, PairsFrom from)
    : name_(dataset.name), source_folder_(dataset.path), target_folder_(targets.path),
      sensor_at_origin_(dataset.sensor_at_origin && targets.sensor_at_origin)
{
  switch (from) {
  case PairsFrom::Listed:
    pairs_ = listedPairs(dataset.pairs);
    break;
  case PairsFrom::Unlisted:
    pairs_ = unlistedPairs(dataset.pairs);
    break;
  case PairsFrom::All:
    pairs_ = allPairs(dataset.pairs);
    break;
  case PairsFrom::Unrelated:
    pairs_ = unrelatedPairs(dataset.pairs, targets.pairs);
    merge_from_ = listedPairs(targets.pairs);
    break;
  }
}

std::optional<PosedScan>
PairList::otherInTarget(std::size_t i) const
{
  const std::vector<ListedPair>& among = merge_from_.empty() ? pairs_ : merge_from_;
  for (std::size_t k = 1; k <= among.size(); ++k) {
    const ListedPair& other = among[(i + k) % among.size()];
    const bool is_other = !merge_from_.empty() || other.source != pairs_[i].source;
    if (other.target == pairs_[i].target && is_other && other.T_target_source)
      return PosedScan{io::scanPath(target_folder_, other.source), *other.T_target_source};
  }
  return std::nullopt;
}

std::optional<PairRequest>
PairList::request(std::size_t i, const Variation& variation, std::uint64_t seed) const
{
  const ListedPair& pair = pairs_[i];
  PairRequest request;
  request.source = io::scanPath(source_folder_, pair.source);
  request.target = io::scanPath(target_folder_, pair.target);
  request.T_target_source = pair.T_target_source;
  request.sensor_at_origin = sensor_at_origin_;
  request.variation = variation;
  request.seed = pairSeed(seed, name_, pair.source, pair.target);
  if (variation.merge_target) {
    request.merged = otherInTarget(i);
    if (!request.merged)
      return std::nullopt;
  }
  return request;
}

} // namespace apps
} // namespace pcl_ssfr
