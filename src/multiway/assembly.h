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
/// Whether two scans, whose sensors are so far apart [m], have nothing to say of each other.
using PairTest = std::function<bool(int source, int target, double distance)>;
/// Why the pairs of scans of two parts may not stand so, for people; empty: they may.
using JoinTest = std::function<std::string(const std::vector<PlacedPair>& pairs)>;

/// Scans put together: parts that do not move to each other any more.
struct Assembly {
  std::vector<int> part;                ///< of each scan, numbers in no order
  std::vector<Eigen::Isometry3d> poses; ///< of each scan in the frame of its part
  std::vector<int> used;                ///< of each link: rank of the hypothesis that the assembly keeps, -1: none
  std::vector<std::string> refusal;     ///< of each link: why it joins nothing, empty when it was not refused
};

class SamePlaceOdds;

/// Which joins are made.
struct JoinRule {
  double most_by_links = 0; ///< log odds that links may add to those of a join: mostLogOddsByLinks()
  double least_odds = 0;    ///< log odds that a join must have, besides being more than 0
  bool by_loops = false;    ///< links are as sure as loops make them; else as their pairs say: where places look
                            ///< alike, loops of false links close too
};

/** \brief What links may add to the log odds of a join, at most, where so many of the sure ones are false.
 *
 * Links between two parts that agree are one piece of evidence: those of places alike err together. It is right as
 * often as sure links are, and never better than ChoiceConfig::clear_odds.
 * \param[in] false_share of the sure links of the job, [0, 1]
 */
double
mostLogOddsByLinks(double false_share, const ChoiceConfig& config);

/** \brief Put scans together, what looks most like one place first.
 *
 * A sure link says where two parts may be laid onto each other. Whether they are is said by what all scans of the one
 * see of all scans of the other, and by the links that agree, as far as links can be trusted here. Of all joins that
 * have odds enough the one comes first for which there is most evidence: where places look alike, a wrong one has
 * little of it between two scans, and much against it once both have been joined with others. What is left of it is
 * found by findScansWithRivalsAlike(). Accepted links join before all others.
 *
 * \param[in] places of the sensors in the scans' frames [m]
 * \param[in] join_test nullptr: none
 * \return with a refusal for each link on a join that was not made, and the links that are used
 * \throw DecisionError when accepted links do not agree: the text names scans by \p names
 */
Assembly
assemble(const std::vector<PairLink>& links,
         const HypothesisGraph& graph,
         const std::vector<Eigen::Vector3d>& places,
         SamePlaceOdds& odds,
         const JoinRule& rule,
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
