// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/placed_evidence.h"

#include "common/parallel.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <cstdint>

namespace pcl_ssfr {

PlacedEvidence::PlacedEvidence(const MapInput& input,
                               const MultiwayMap& map,
                               const std::vector<Eigen::Vector3d>& places)
    : input_(input), places_(places)
{
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    sights_.push_back(map.scans[i].usable ? sightOf(input.prepared[i]) : SightOfScan());
}

bool
PlacedEvidence::areTooFar(int source, int target, double distance) const
{
  return distance > sights_[static_cast<std::size_t>(source)].reach + sights_[static_cast<std::size_t>(target)].reach;
}

PlacementEvidence
PlacedEvidence::at(int source, int target, const Eigen::Isometry3d& T_target_source, double looseness) const
{
  const auto s = static_cast<std::size_t>(source), t = static_cast<std::size_t>(target);
  if (areTooFar(source, target, (T_target_source * places_[s] - places_[t]).norm())) {
    PlacementEvidence nothing;
    nothing.total = sights_[s].total + sights_[t].total;
    return nothing;
  }
  return evidenceAt(input_.prepared[s], input_.prepared[t], T_target_source, input_.options, looseness);
}

const std::vector<PlacementEvidence>&
PlacedEvidence::of(const Assembly& assembly,
                   const std::vector<int>& members,
                   const std::vector<std::pair<int, int>>& pairs)
{
  Part& known = known_[members.front()];
  std::vector<Eigen::Isometry3d> poses;
  poses.reserve(members.size());
  for (const int i : members)
    poses.push_back(assembly.poses[static_cast<std::size_t>(i)]);
  const auto isSame = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) { return a.matrix() == b.matrix(); };
  if (known.members == members && std::equal(poses.begin(), poses.end(), known.poses.begin(), isSame))
    return known.evidence;
  known.members = members;
  known.poses = std::move(poses);
  known.evidence.assign(pairs.size(), {});
  const auto threads = static_cast<int>(input_.options.threads);
  forEachInParallel(static_cast<std::int64_t>(pairs.size()), 1, threads, [&](std::int64_t index) {
    const auto k = static_cast<std::size_t>(index);
    const auto [i, j] = pairs[k];
    const Eigen::Isometry3d T =
        assembly.poses[static_cast<std::size_t>(j)].inverse() * assembly.poses[static_cast<std::size_t>(i)];
    known.evidence[k] = at(i, j, T, 1);
  });
  return known.evidence;
}

} // namespace pcl_ssfr
