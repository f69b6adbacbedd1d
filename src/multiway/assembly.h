// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/hypothesis_graph.h"
#include "multiway/scan_pair.h"

#include <functional>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// What the surfaces of two scans say of a pose that maps the first one's points into the second one's frame.
using EvidenceFunction = std::function<PlacementEvidence(
    int source, int target, const Eigen::Isometry3d& T_target_source, double looseness)>;

/// Two scans at a pose.
struct PlacedPair {
  int source = 0;
  int target = 0;
  Eigen::Isometry3d T_target_source;
};
/// Why the pairs of scans of two parts may not stand so, for people; empty: they may.
using JoinTest = std::function<std::string(const std::vector<PlacedPair>& pairs)>;

/// Scans put together: parts that do not move to each other any more.
struct Assembly {
  std::vector<int> part;                ///< of each scan, numbers in no order
  std::vector<Eigen::Isometry3d> poses; ///< of each scan in the frame of its part
  std::vector<int> used;                ///< of each link: rank of the hypothesis that the assembly keeps, -1: none
  std::vector<std::string> refusal;     ///< of each link: why it joins nothing, empty when it was not refused
  double false_share = 0;               ///< of sure links that the assembly contradicts: how misleading the building is
};

/** \brief Put scans together by their links, the surest first.
 *
 * Two parts are joined at a pose when the links between them that agree with it outweigh those that do not, and when
 * the surfaces of all scans of the one do not hang in the free space of all scans of the other. A single link joins
 * parts only when a loop closes with it, or, in the end, when it is sure even among the links of this building: the
 * share of sure links that are false here is taken off.
 * \param[in] places of the sensors in the scans' frames [m]
 * \param[in] join_test nullptr: none
 * \throw std::invalid_argument when accepted links do not agree: the text names scans by \p names
 */
Assembly
assemble(const std::vector<PairLink>& links,
         const HypothesisGraph& graph,
         const std::vector<Eigen::Vector3d>& places,
         const EvidenceFunction& evidence,
         const Decisions& decisions,
         const std::vector<std::string>& names,
         const MultiwayOptions& options,
         const JoinTest& join_test = nullptr);

/// Links that agree with the poses are used, others are not: of pairs within one part.
void
chooseLinks(Assembly& assembly,
            const std::vector<PairLink>& links,
            const HypothesisGraph& graph,
            const std::vector<Eigen::Vector3d>& places,
            const ChoiceConfig& config);

/// Links that alone hold two pieces of their part together: by used links.
std::vector<char>
findBridges(const Assembly& assembly, const std::vector<PairLink>& links);

} // namespace pcl_ssfr
