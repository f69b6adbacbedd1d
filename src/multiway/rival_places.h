// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/decisions.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/parts.h"

#include <cstddef>
#include <vector>

namespace pcl_ssfr {

/// A place for a scan: the sum of the beliefs of the links that say so, and the score of all surfaces there.
struct PlaceOdds {
  double belief = 0;
  double score = 0;
};
/// What others see of a scan at a pose in their part, loosely; its own entry is not read.
PlacementEvidence
surfacesAt(int scan,
           const Eigen::Isometry3d& at,
           const std::vector<int>& others,
           const Assembly& assembly,
           const EvidenceFunction& evidence,
           const MultiwayOptions& options);

/** \brief Log odds for the place chosen against a rival: those of the links, at most \p most_by_links for it, and those
 * of the surfaces, by ChoiceConfig::score_power. Infinite where the score of the rival is not positive; then against
 * the chosen one where its score is not, or no link says either place.
 */
double
logOdds(const PlaceOdds& chosen, const PlaceOdds& rival, double most_by_links, const ChoiceConfig& config);

/** \brief Whether the odds for the place chosen against a rival are enough (ChoiceConfig::clear_odds), however much
 * the links say. A rival whose score is not positive is none; one with the higher score always competes.
 */
bool
isClear(const PlaceOdds& chosen, const PlaceOdds& rival, const MultiwayOptions& options);

/// What is asked about: an assembly and what made it. All must outlive it.
struct PlacedScans {
  PlacedScans(const Assembly& assembly,
              const std::vector<PairLink>& links,
              const HypothesisGraph& graph,
              const std::vector<Eigen::Vector3d>& places);

  const Assembly& assembly;
  const std::vector<PairLink>& links;
  const HypothesisGraph& graph;
  const std::vector<Eigen::Vector3d>& places;     ///< of the sensors in the scans' frames [m]
  std::vector<std::vector<std::size_t>> links_of; ///< of each scan, ascending
};

/// Where a hypothesis of a link puts one of its scans.
struct ProposedPose {
  int other = 0;                 ///< scan of the link
  PlacedPair pair;               ///< the hypothesis
  Eigen::Isometry3d T_part_scan; ///< in the frame of the part of the other scan
  double prior = 0, belief = 0;  ///< WeighedHypothesis
};
/// By all links of a scan, in their order.
std::vector<ProposedPose>
proposedPoses(int scan, const PlacedScans& placed);

/** \brief Scans, of those asked about, for which another place in their part, which a link of theirs says, explains all
 * surfaces better, or nearly as well: isClear() does not hold. Each scan against all others of its part, where these
 * are two or more.
 *
 * Links on another place with a probability of ChoiceConfig::rival and more are rivals. Scans of a pile confirm each
 * other wherever they are laid: for them neither the links nor the surfaces of the pile count. And as links of places
 * alike err together, all other scans decide by their surfaces alone, whatever the probability of a rival. For scans of
 * a pile that is a part by itself nobody else says where they are: they have one where there are scans of other parts.
 *
 * \param[in] piles scans at one place of which most see the same
 * \return in the order of \p asked; no scan of which a person accepted a link
 */
std::vector<int>
findScansWithRivals(const std::vector<int>& asked,
                    const PlacedScans& placed,
                    const EvidenceFunction& evidence,
                    const Piles& piles,
                    const Decisions& decisions,
                    const MultiwayOptions& options);

} // namespace pcl_ssfr
