// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/map_stages.h"

#include <string>
#include <vector>

namespace pcl_ssfr {

/// What was chosen and adjusted.
struct ChosenMap {
  const std::vector<PairLink>& links;
  const HypothesisGraph& graph;
  const Assembly& assembly;                          ///< with adjusted poses
  const std::vector<Eigen::Isometry3d>& graph_poses; ///< before the joint adjustment
  const std::vector<Eigen::Matrix<double, 6, 6>>& covariances;
  std::vector<int> fixed;                  ///< the scan of each part that holds its frame
  const std::vector<std::string>& reasons; ///< why scans were taken out of their parts
  const std::vector<Eigen::Vector3d>& places;
  const Decisions& decisions;
};

/// Components by size, each in its frame, scans with covariances, links with their figures, loops and notes.
void
describeMap(const ChosenMap& chosen, const MapInput& input, MultiwayMap& map);

} // namespace pcl_ssfr
