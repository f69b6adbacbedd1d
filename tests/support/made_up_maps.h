// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "synthetic_scene.h"

#include "refinement/refinement.h"

#include <pcl_ssfr/multiway/multiway_map.h>

#include <algorithm>
#include <string>
#include <vector>

// Links of made-up jobs, with known truth, for tests of what follows linking.
namespace pcl_ssfr::testing {

/// Poses of scans on a walk, and links between them.
struct MadeUpJob {
  std::vector<Eigen::Isometry3d> truth; ///< T_map_scan
  std::vector<Eigen::Vector3d> places;  ///< of the sensors in the scans' frames: their origins
  std::vector<std::string> names;
  std::vector<PairLink> links;

  explicit MadeUpJob(int scans, std::uint64_t seed = 1) : random_(seed)
  {
    for (int i = 0; i < scans; ++i) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = randomRotation(random_);
      T.translation() << 3.0 * i, random_.uniform(-1, 1), random_.uniform(-0.2, 0.2);
      truth.push_back(T);
      places.emplace_back(Eigen::Vector3d::Zero());
      names.push_back("s" + std::to_string(i));
    }
  }

  Eigen::Isometry3d
  relative(int source, int target) const
  {
    return truth[static_cast<std::size_t>(target)].inverse() * truth[static_cast<std::size_t>(source)];
  }

  /// A link at a pose, of a given probability.
  PairLink&
  add(int source, int target, const Eigen::Isometry3d& T_target_source, double probability)
  {
    PairLink link;
    link.source = source;
    link.target = target;
    link.status = probability >= 0.7 ? Status::Converged : Status::LowOverlap;
    link.confidence = probability;
    link.probability_of_none = 1 - probability;
    PairHypothesis hypothesis;
    hypothesis.T_target_source = T_target_source;
    hypothesis.probability = probability;
    hypothesis.score = 0.3;
    hypothesis.overlap = 0.5;
    hypothesis.information.setIdentity();
    hypothesis.information *= 1e6;
    link.hypotheses.push_back(hypothesis);
    links.push_back(link);
    std::sort(links.begin(), links.end(), [](const PairLink& a, const PairLink& b) {
      return a.source != b.source ? a.source < b.source : a.target < b.target;
    });
    return *std::find_if(
        links.begin(), links.end(), [&](const PairLink& l) { return l.source == source && l.target == target; });
  }
  /// A right link, off by \p sigma [rad], [m].
  PairLink&
  addTrue(int source, int target, double probability = 0.95, double sigma = 0.001)
  {
    Eigen::Matrix<double, 6, 1> motion;
    for (int i = 0; i < 6; ++i)
      motion[i] = sigma * random_.gaussian();
    return add(source, target, expSe3(motion) * relative(source, target), probability);
  }
  /// A false link: \p shift [m] off in the map.
  PairLink&
  addFalse(int source, int target, const Eigen::Vector3d& shift, double probability = 0.95)
  {
    const auto t = static_cast<std::size_t>(target);
    return add(source,
               target,
               truth[t].inverse() * Eigen::Translation3d(shift) * truth[static_cast<std::size_t>(source)],
               probability);
  }

private:
  Random random_;
};

} // namespace pcl_ssfr::testing
