// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/map_report.h"

#include "common/angles.h"
#include "common/parallel.h"
#include "judgement/scored_pose.h"
#include "multiway/scan_pair.h"
#include "profiles/prepared_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace pcl_ssfr {

namespace {

constexpr std::size_t kListedLoops = 20;

template <typename... Values>
std::string
formatted(const char* pattern, Values... values)
{
  char text[400];
  std::snprintf(text, sizeof(text), pattern, values...);
  return text;
}

Eigen::Isometry3d
relative(const std::vector<Eigen::Isometry3d>& poses, const PairLink& link)
{
  return poses[static_cast<std::size_t>(link.target)].inverse() * poses[static_cast<std::size_t>(link.source)];
}

bool
isCopy(std::size_t scan, const MapInput& input)
{
  return input.original[scan] != static_cast<int>(scan);
}

/// Components by size, then by their first scan; scans that cannot be used come last. Copies say nothing of where they
/// are: they do not count, and go with their originals.
/// \return the size of each component
std::vector<std::size_t>
numberComponents(const ChosenMap& chosen, const MapInput& input, MultiwayMap& map)
{
  std::map<int, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    if (!isCopy(i, input))
      members[chosen.assembly.part[i]].push_back(i);
  std::vector<const std::vector<std::size_t>*> order;
  order.reserve(members.size());
  for (const auto& [part, scans] : members)
    order.push_back(&scans);
  const auto isUsable = [&](const std::vector<std::size_t>* part) { return map.scans[part->front()].usable; };
  std::sort(order.begin(), order.end(), [&](const auto* a, const auto* b) {
    if (a->size() != b->size())
      return a->size() > b->size();
    return isUsable(a) != isUsable(b) ? isUsable(a) : a->front() < b->front();
  });
  std::vector<std::size_t> sizes;
  for (const auto* part : order) {
    for (const std::size_t i : *part)
      map.scans[i].component = static_cast<int>(sizes.size());
    sizes.push_back(part->size());
  }
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    map.scans[i].component = map.scans[static_cast<std::size_t>(input.original[i])].component;
    map.placed += sizes[static_cast<std::size_t>(map.scans[i].component)] > 1 ? 1 : 0;
  }
  map.components = static_cast<int>(sizes.size());
  return sizes;
}

/// The pose of a scan that holds a frame.
Eigen::Isometry3d
heldPose(std::size_t scan, const MapInput& input)
{
  return input.priors[scan] ? input.priors[scan]->T_map_scan : Eigen::Isometry3d::Identity();
}

/// Of each scan: from the frame of the assembly's part to that of the component.
std::vector<Eigen::Isometry3d>
framesOf(const ChosenMap& chosen, const MapInput& input)
{
  std::map<int, Eigen::Isometry3d> frames;
  for (const int i : chosen.fixed) {
    const auto index = static_cast<std::size_t>(i);
    frames[chosen.assembly.part[index]] = heldPose(index, input) * chosen.assembly.poses[index].inverse();
  }
  std::vector<Eigen::Isometry3d> result;
  for (const int part : chosen.assembly.part)
    result.push_back(frames.at(part));
  return result;
}

void
describeScans(const ChosenMap& chosen,
              const MapInput& input,
              const std::vector<std::size_t>& sizes,
              const std::vector<Eigen::Isometry3d>& frames,
              MultiwayMap& map)
{
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    MapScan& scan = map.scans[i];
    if (sizes[static_cast<std::size_t>(scan.component)] == 1) {
      if (scan.reason.empty())
        scan.reason = chosen.reasons[i];
      continue;
    }
    scan.T_map_scan = frames[i] * chosen.assembly.poses[i];
    if (std::find(chosen.fixed.begin(), chosen.fixed.end(), static_cast<int>(i)) != chosen.fixed.end())
      scan.T_map_scan = heldPose(i, input); // to the bit
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = frames[i].linear();
    scan.covariance = turn * chosen.covariances[i] * turn.transpose();
    scan.sigma_rotation = std::sqrt(std::max(0.0, scan.covariance.topLeftCorner<3, 3>().trace()));
    scan.sigma_translation = std::sqrt(std::max(0.0, scan.covariance.bottomRightCorner<3, 3>().trace()));
  }
}

/// Status, reason and figures of a link.
MapLink
describeLink(std::size_t k, const ChosenMap& chosen, const MapInput& input, const MultiwayMap& map)
{
  const PairLink& pair = chosen.links[k];
  const auto source = static_cast<std::size_t>(pair.source);
  const auto target = static_cast<std::size_t>(pair.target);
  MapLink link;
  link.source = pair.source;
  link.target = pair.target;
  link.reason = pair.message;
  if (pair.hypotheses.empty())
    return link;
  const int used = chosen.assembly.used[k];
  const auto rank = static_cast<std::size_t>(std::max(0, used));
  const PairHypothesis& h = pair.hypotheses[rank];
  const WeighedHypothesis& weighed = chosen.graph.hypotheses[chosen.graph.first[k] + rank];
  link.confidence = std::min(1.0, weighed.belief);
  link.T_target_source = h.T_target_source;
  link.overlap = h.overlap;
  link.rmse = h.rmse;
  const bool is_one = map.scans[source].component == map.scans[target].component;
  if (is_one) {
    const Eigen::Isometry3d T = relative(chosen.assembly.poses, pair);
    link.residual_rotation = rotationBetween(h.T_target_source, T);
    link.residual_translation = translationBetween(h.T_target_source, T, chosen.places[source]);
  }
  const std::pair<int, int> key(pair.source, pair.target);
  if (used >= 0) {
    link.status = LinkStatus::Used;
    link.reason.clear();
    if (chosen.decisions.accepted.count(key) > 0) {
      link.reason = "accepted by a person";
      link.confidence = h.probability; // weighed, it is sure
    }
    const LinkFigures figures =
        figuresAt(input.prepared[source], input.prepared[target], relative(chosen.assembly.poses, pair), input.options);
    link.overlap = figures.overlap;
    link.rmse = figures.rmse;
    link.strength = figures.strength;
    link.below_6mm = figures.below_6mm;
  }
  else if (chosen.decisions.rejected.count(key) > 0) {
    link.status = LinkStatus::Rejected;
    link.reason = "rejected by a person";
  }
  else if (is_one && weighed.prior >= input.options.choice.sure) {
    link.status = LinkStatus::Rejected;
    link.reason = formatted("the other links put the scans %.2f m and %.1f degrees elsewhere",
                            link.residual_translation,
                            link.residual_rotation / kDegree);
  }
  else if (!is_one && weighed.prior >= input.options.choice.sure) {
    const std::string& refusal = chosen.assembly.refusal[k];
    const bool is_out = !chosen.reasons[source].empty() || !chosen.reasons[target].empty();
    link.status = weighed.belief >= input.options.choice.sure ? LinkStatus::Ambiguous : LinkStatus::Rejected;
    link.reason = is_out            ? (chosen.reasons[source].empty() ? chosen.reasons[target] : chosen.reasons[source])
                  : refusal.empty() ? "loops of links do not close with it"
                                    : refusal;
  }
  return link;
}

/// The worst loop first; as many as are listed.
void
keepWorstLoops(MultiwayMap& map)
{
  std::stable_sort(map.loops.begin(), map.loops.end(), [](const LoopClosure& a, const LoopClosure& b) {
    return a.translation > b.translation;
  });
  map.loops.resize(std::min(map.loops.size(), kListedLoops));
}

/// Triangles of used links: how they close.
void
closeLoops(const ChosenMap& chosen, MultiwayMap& map)
{
  const std::size_t n = map.scans.size();
  std::map<std::pair<int, int>, std::size_t> used;
  std::vector<std::vector<int>> next(n);
  for (std::size_t k = 0; k < chosen.links.size(); ++k)
    if (chosen.assembly.used[k] >= 0) {
      used[{chosen.links[k].source, chosen.links[k].target}] = k;
      next[static_cast<std::size_t>(chosen.links[k].source)].push_back(chosen.links[k].target);
    }
  const auto pose = [&](std::size_t k) -> const Eigen::Isometry3d& {
    return chosen.links[k].hypotheses[static_cast<std::size_t>(chosen.assembly.used[k])].T_target_source;
  };
  std::vector<double> misclosures;
  for (std::size_t a = 0; a < n; ++a)
    for (const int b : next[a])
      for (const int c : next[static_cast<std::size_t>(b)]) {
        const auto direct = used.find({static_cast<int>(a), c});
        if (direct == used.end())
          continue;
        const Eigen::Isometry3d T = pose(used.at({b, c})) * pose(used.at({static_cast<int>(a), b}));
        LoopClosure loop;
        loop.scans = {static_cast<int>(a), b, c};
        loop.rotation = rotationBetween(T, pose(direct->second));
        loop.translation = translationBetween(T, pose(direct->second), chosen.places[a]);
        misclosures.push_back(loop.translation);
        map.loops.push_back(loop);
        if (map.loops.size() > kListedLoops * kListedLoops) // where all scans overlap there are n^3 / 6
          keepWorstLoops(map);
      }
  if (misclosures.empty())
    return;
  const auto middle = misclosures.begin() + static_cast<std::ptrdiff_t>(misclosures.size() / 2);
  std::nth_element(misclosures.begin(), middle, misclosures.end());
  map.median_misclosure = *middle;
  map.largest_misclosure = *std::max_element(misclosures.begin(), misclosures.end());
  keepWorstLoops(map);
}

/// What a scan that stands alone is short of.
void
explainUnplaced(const MapInput& input, const std::vector<std::size_t>& sizes, MultiwayMap& map)
{
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    MapScan& scan = map.scans[i];
    if (!scan.usable || isCopy(i, input) || sizes[static_cast<std::size_t>(scan.component)] > 1 || !scan.reason.empty())
      continue;
    const MapLink* best = nullptr;
    for (const MapLink& link : map.links)
      if ((link.source == static_cast<int>(i) || link.target == static_cast<int>(i)) &&
          (!best || link.confidence > best->confidence))
        best = &link;
    if (!best || best->status == LinkStatus::None) {
      scan.reason = std::string("no other scan shares enough with it") +
                    (input.priors[i]         ? " near its approximate pose (--poses, --pose-tolerance)"
                     : input.options.gravity ? " by the given vertical (--gravity)"
                                             : "");
      if (best && best->confidence > 0)
        scan.reason +=
            ": the likeliest is " +
            map.scans[static_cast<std::size_t>(best->source == static_cast<int>(i) ? best->target : best->source)]
                .name +
            formatted(" (%.2f)", best->confidence);
      continue;
    }
    scan.reason =
        "its best link, to " +
        map.scans[static_cast<std::size_t>(best->source == static_cast<int>(i) ? best->target : best->source)].name +
        formatted(" (%.2f): ", best->confidence) + best->reason;
  }
}

/// The poses along a maximum spanning tree of the used links, from the first scan of each part: what a chain gives.
std::vector<Eigen::Isometry3d>
chainPoses(const ChosenMap& chosen)
{
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < chosen.links.size(); ++k)
    if (chosen.assembly.used[k] >= 0)
      order.push_back(k);
  const auto hypothesis = [&](std::size_t k) -> const PairHypothesis& {
    return chosen.links[k].hypotheses[static_cast<std::size_t>(chosen.assembly.used[k])];
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return hypothesis(a).overlap > hypothesis(b).overlap;
  });
  const std::size_t n = chosen.assembly.part.size();
  std::vector<Eigen::Isometry3d> poses = chosen.graph_poses;
  std::vector<char> is_done(n, 0);
  for (const int i : chosen.fixed)
    is_done[static_cast<std::size_t>(i)] = 1;
  // Prim's algorithm: the link of most overlap that leads out of what is reached.
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const std::size_t k : order) {
      const auto s = static_cast<std::size_t>(chosen.links[k].source);
      const auto t = static_cast<std::size_t>(chosen.links[k].target);
      if (is_done[s] == is_done[t])
        continue;
      const Eigen::Isometry3d& T = hypothesis(k).T_target_source;
      if (is_done[s])
        poses[t] = poses[s] * T.inverse();
      else
        poses[s] = poses[t] * T;
      is_done[s] = is_done[t] = 1;
      has_grown = true;
      break;
    }
  }
  return poses;
}

/// Scans so large that their coordinates may be in another unit are noted.
void
noteUnits(const MapInput& input, MultiwayMap& map)
{
  std::vector<std::size_t> large;
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    if (map.scans[i].usable && patchesOf(input.prepared[i]).scale > kUnlikelyScale)
      large.push_back(i);
  if (large.empty())
    return;
  const double radius = patchesOf(input.prepared[large.front()]).extent.radius;
  map.notes.push_back(map.scans[large.front()].name + formatted(" reaches %.0f m", radius) +
                      (large.size() > 1 ? formatted(", and %zu other scans reach as far", large.size() - 1) : "") +
                      ": are coordinates in metres?");
}

/// Pins that count for nothing are noted: one scan holds the frame of a component.
void
noteIdlePins(const ChosenMap& chosen, MultiwayMap& map)
{
  const std::vector<int>& part = chosen.assembly.part;
  const auto name = [&](int scan) { return map.scans[static_cast<std::size_t>(scan)].name; };
  for (const int pinned : chosen.decisions.pinned)
    for (const int holder : chosen.fixed)
      if (holder != pinned && part[static_cast<std::size_t>(holder)] == part[static_cast<std::size_t>(pinned)])
        map.notes.push_back(name(pinned) + " is pinned, but " + name(holder) +
                            ", pinned before it, holds the frame of their component");
}

} // namespace

void
describeMap(const ChosenMap& chosen, const MapInput& input, MultiwayMap& map)
{
  const std::vector<std::size_t> sizes = numberComponents(chosen, input, map);
  const std::vector<Eigen::Isometry3d> frames = framesOf(chosen, input);
  describeScans(chosen, input, sizes, frames, map);
  map.links.resize(chosen.links.size());
  forEachInParallel(
      static_cast<std::int64_t>(map.links.size()), 1, static_cast<int>(input.options.threads), [&](std::int64_t k) {
        map.links[static_cast<std::size_t>(k)] = describeLink(static_cast<std::size_t>(k), chosen, input, map);
      });
  const std::vector<char> bridges = findBridges(chosen.assembly, chosen.links);
  for (std::size_t k = 0; k < map.links.size(); ++k) {
    MapLink& link = map.links[k];
    link.bridge = bridges[k] != 0;
    if (link.status != LinkStatus::Used)
      continue;
    ++map.scans[static_cast<std::size_t>(link.source)].links;
    ++map.scans[static_cast<std::size_t>(link.target)].links;
  }
  closeLoops(chosen, map);
  explainUnplaced(input, sizes, map);
  noteUnits(input, map);
  noteIdlePins(chosen, map);
  const std::vector<Eigen::Isometry3d> chain = chainPoses(chosen);
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    map.graph_poses.push_back(frames[i] * chosen.graph_poses[i]);
    map.chain_poses.push_back(frames[i] * chain[i]);
  }
  // Scans that were given twice stand where the first one stands, if it does.
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    if (!isCopy(i, input))
      continue;
    const auto first = static_cast<std::size_t>(input.original[i]);
    MapScan& scan = map.scans[i];
    const MapScan& other = map.scans[first];
    scan.T_map_scan = other.T_map_scan;
    scan.covariance = other.covariance;
    scan.sigma_rotation = other.sigma_rotation;
    scan.sigma_translation = other.sigma_translation;
    scan.reason = "it holds the same points as " + other.name +
                  (other.reason.empty() ? ", and stands where that stands" : ", which is not placed");
  }
}

} // namespace pcl_ssfr
