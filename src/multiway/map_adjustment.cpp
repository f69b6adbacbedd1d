// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/map_adjustment.h"

#include "multiway/parts.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace pcl_ssfr {

struct MapAdjustment::Network {
  std::vector<int> members;
  std::vector<std::pair<int, int>> pairs;    ///< of scans
  std::vector<std::pair<int, int>> numbered; ///< the same, of their places among the members
  std::vector<int> fixed;                    ///< likewise
  std::vector<Eigen::Vector3d> places;       ///< of the sensors of the members [m]
  std::vector<KnownEquations*> known;        ///< of each pair
  AdjustmentConfig config;

  std::vector<Eigen::Isometry3d>
  posesOf(const std::vector<Eigen::Isometry3d>& all) const
  {
    std::vector<Eigen::Isometry3d> poses;
    for (const int i : members)
      poses.push_back(all[static_cast<std::size_t>(i)]);
    return poses;
  }
};

std::vector<int>
fixedScans(const Assembly& assembly, const MapInput& input)
{
  std::vector<int> fixed;
  const std::vector<int>& pins = input.decisions.pinned;
  for (const auto& [part, members] : membersOf(assembly)) {
    const auto pinned = std::find_first_of(pins.begin(), pins.end(), members.begin(), members.end());
    const auto known = std::find_if(
        members.begin(), members.end(), [&](int i) { return input.priors[static_cast<std::size_t>(i)].has_value(); });
    fixed.push_back(pinned != pins.end() ? *pinned : known != members.end() ? *known : members.front());
  }
  return fixed;
}

MapAdjustment::MapAdjustment(const MapInput& input,
                             const std::vector<PairLink>& links,
                             const std::vector<Eigen::Vector3d>& places,
                             PlacedEvidence& evidence,
                             const MultiwayRegistration::Progress& progress)
    : input_(input), links_(links), places_(places), evidence_(evidence), progress_(progress),
      threads_(static_cast<int>(input.options.threads))
{}

MapAdjustment::Network
MapAdjustment::networkOf(const Assembly& assembly, const std::vector<int>& members, const std::vector<int>& fixed)
{
  Network network;
  network.members = members;
  network.config = input_.options.adjustment;
  network.config.damping = dampingOf(network.config, members.size());
  std::vector<int> number(places_.size(), -1);
  for (const int i : members) {
    const auto next = static_cast<int>(network.places.size());
    number[static_cast<std::size_t>(i)] = next;
    if (std::find(fixed.begin(), fixed.end(), i) != fixed.end())
      network.fixed.push_back(next);
    network.places.push_back(places_[static_cast<std::size_t>(i)]);
  }
  std::set<std::pair<int, int>> linked;
  for (std::size_t k = 0; k < links_.size(); ++k)
    if (assembly.used[k] >= 0)
      linked.emplace(links_[k].source, links_[k].target);
  const auto pairs = pairsOf(members);
  const std::vector<PlacementEvidence>& evidence = evidence_.of(assembly, members, pairs);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PlacementEvidence& e = evidence[k];
    const bool overlaps =
        e.matched >= network.config.least_matched * e.total && scoreOf(e, contradictionWeight(input_.options)) > 0;
    if (!overlaps && linked.count(pairs[k]) == 0)
      continue;
    network.pairs.push_back(pairs[k]);
    network.known.push_back(&known_[pairs[k]]);
    network.numbered.emplace_back(number[static_cast<std::size_t>(pairs[k].first)],
                                  number[static_cast<std::size_t>(pairs[k].second)]);
  }
  return network;
}

EquationsFunction
MapAdjustment::equationsOf(const Network& network) const
{
  return [&](std::size_t k, const Eigen::Isometry3d& T) {
    const auto source = static_cast<std::size_t>(network.pairs[k].first);
    const auto target = static_cast<std::size_t>(network.pairs[k].second);
    const Eigen::Isometry3d T_graph = graph_poses_[target].inverse() * graph_poses_[source];
    KnownEquations& known = *network.known[k];
    auto& there = T.matrix() == T_graph.matrix() ? known.graph : known.latest;
    if (!there || there->T_target_source.matrix() != T.matrix())
      there = {T, equationsAt(input_.prepared[source], input_.prepared[target], T, input_.options)};
    return there->equations;
  };
}

PatchGradientsFunction
MapAdjustment::gradientsOf(const Network& network) const
{
  return [&](std::size_t k, const Eigen::Isometry3d& T, bool of_source) {
    const auto& [source, target] = network.pairs[k];
    return patchGradientsAt(input_.prepared[static_cast<std::size_t>(source)],
                            input_.prepared[static_cast<std::size_t>(target)],
                            T,
                            input_.options,
                            of_source);
  };
}

template <typename Adjust>
void
MapAdjustment::forEachPart(const Assembly& assembly, const Adjust& adjust)
{
  const std::vector<int> fixed = fixedScans(assembly, input_);
  const auto parts = membersOf(assembly);
  std::size_t done = 0;
  for (const auto& [part, members] : parts) {
    if (progress_)
      progress_("adjust", done++, parts.size());
    if (members.size() > 1)
      adjust(networkOf(assembly, members, fixed));
  }
  if (progress_)
    progress_("adjust", parts.size(), parts.size());
}

void
MapAdjustment::startFrom(const std::vector<Eigen::Isometry3d>& graph_poses)
{
  graph_poses_ = graph_poses;
  known_.clear();
}

void
MapAdjustment::adjustRoughly(Assembly& assembly)
{
  forEachPart(assembly, [&](Network network) {
    network.config.last_step =
        std::max(network.config.last_step, input_.options.registration.patch_profile.refinement.match_noise);
    const JointAdjustment adjusted = adjustJointly(network.posesOf(assembly.poses),
                                                   network.numbered,
                                                   network.fixed,
                                                   network.places,
                                                   equationsOf(network),
                                                   {},
                                                   network.config,
                                                   threads_);
    for (std::size_t m = 0; m < network.members.size(); ++m)
      assembly.poses[static_cast<std::size_t>(network.members[m])] = adjusted.poses[m];
  });
}

MapExactness
MapAdjustment::adjustExactly(Assembly& assembly)
{
  MapExactness exactness;
  exactness.covariances.assign(places_.size(), Eigen::Matrix<double, 6, 6>::Zero());
  double squares_before = 0, squares = 0, weight = 0;
  forEachPart(assembly, [&](const Network& network) {
    const EquationsFunction equations = equationsOf(network);
    const double before =
        rmsOfPairs(network.posesOf(graph_poses_), network.numbered, network.places, equations, threads_);
    const JointAdjustment adjusted = adjustJointly(network.posesOf(assembly.poses),
                                                   network.numbered,
                                                   network.fixed,
                                                   network.places,
                                                   equations,
                                                   gradientsOf(network),
                                                   network.config,
                                                   threads_);
    for (std::size_t m = 0; m < network.members.size(); ++m) {
      const auto i = static_cast<std::size_t>(network.members[m]);
      assembly.poses[i] = adjusted.poses[m];
      exactness.covariances[i] = adjusted.covariances[m];
    }
    const auto count = static_cast<double>(network.pairs.size());
    weight += count;
    squares_before += count * before * before;
    squares += count * adjusted.rms * adjusted.rms;
  });
  exactness.graph_error = weight > 0 ? std::sqrt(squares_before / weight) : 0;
  exactness.bundle_error = weight > 0 ? std::sqrt(squares / weight) : 0;
  return exactness;
}

} // namespace pcl_ssfr
