// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/scan_pair.h"

#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// The scans of each part, in order.
std::map<int, std::vector<int>>
membersOf(const Assembly& assembly);
/// All pairs of these scans.
std::vector<std::pair<int, int>>
pairsOf(const std::vector<int>& members);
/// Each of the one scans in each of the others, but for those that are left out: among many scans nearly all.
/// \param[in] T moves \p sources, as \p poses has them, into the frame of \p targets
/// \param[in] places of the sensors in the scans' frames [m]
std::vector<PlacedPair>
pairsBetween(const std::vector<int>& sources,
             const std::vector<int>& targets,
             const Eigen::Isometry3d& T,
             const std::vector<Eigen::Isometry3d>& poses,
             const std::vector<Eigen::Vector3d>& places,
             const PairTest& left_out = nullptr);
/// A number that no part has.
int
nextPart(const Assembly& assembly);
/// The poses of a part by the links that it keeps, as a pose graph between the sensors; its first scan is kept.
/// \param[in] places of the sensors in the scans' frames [m]
void
adjustPart(Assembly& assembly,
           int part,
           const std::vector<PairLink>& links,
           const std::vector<Eigen::Vector3d>& places);
/// Pieces of a part that no used links of a belief of ChoiceConfig::sure connect any more become parts of their own.
void
splitUnconnected(Assembly& assembly,
                 const std::vector<PairLink>& links,
                 const HypothesisGraph& graph,
                 const ChoiceConfig& config);

/// What holds two scans together, the more the heavier.
struct WeightedEdge {
  int a = 0, b = 0;
  double weight = 0;
};
/** \brief Where a part comes apart most easily: of each edge of its maximum spanning tree, the smaller one of the sides
 * into which the part falls without it, the lightest edge first; of equal sides the one without the first scan.
 * \param[in] members ascending
 * \param[in] edges of the part; they must connect it
 */
std::vector<std::vector<int>>
weakestCuts(const std::vector<int>& members, const std::vector<WeightedEdge>& edges);

/** \brief Scans of a part that hang in what the others saw to be free: each against all others, the worst one first,
 * until none that is left contradicts more than it matches.
 * \param[in] pairs all of \p members, with their evidence
 * \param[in] contradiction_weight of surface in free space
 * \return in the order of \p members
 */
std::vector<int>
findHanging(const std::vector<int>& members,
            const std::vector<std::pair<int, int>>& pairs,
            const std::vector<PlacementEvidence>& evidence,
            double contradiction_weight);

/// Scans by those that stand where they do: of each of them all within some distance, itself included, ascending.
using Piles = std::map<int, std::vector<int>>;

/** \brief Piles of at least so many scans.
 *
 * Nobody sets up a scanner at one place so often: rooms alike, scanned from the same place, are laid onto one another.
 * Or a sensor stood there for a while, or rotated on the spot.
 * \param[in] stations places of the sensors of \p members in the map [m]
 * \param[in] within distance of two sensors that are at one place [m]
 * \param[in] pairs of \p members, with their evidence
 * \param[in] counts whether a pair at one place is taken for one, by its evidence
 */
Piles
findPiles(const std::vector<int>& members,
          const std::vector<Eigen::Vector3d>& stations,
          double within,
          const std::vector<std::pair<int, int>>& pairs,
          const std::vector<PlacementEvidence>& evidence,
          const std::function<bool(const PlacementEvidence&)>& counts,
          std::size_t least);

/// What became of the sure links that touch a part.
struct SureLinks {
  std::vector<double>
      wrong;            ///< of each, the probability of being wrong that it claims, 1 / (1 + clear_odds) at the least
  int contradicted = 0; ///< the map has another pose of the pair, or its other scan is not of the part
};
/// Which links are sure: by their pairs alone those of at least ChoiceConfig::lone, with the loops those whose belief
/// has odds of clear_odds. Loops of places alike make links sure that pairs alone were not, and the other way round.
/// Links that a person rejected, with a prior of 0, do not count.
enum class SureBy { Pair, Loops };
SureLinks
countSureLinks(const Assembly& assembly,
               const std::vector<PairLink>& links,
               const HypothesisGraph& graph,
               int part,
               SureBy by,
               const ChoiceConfig& config);
/** \brief Whether so many sure links are contradicted that they cannot be as sure as they claim: by chance, each wrong
 * with the probability that it claims, as many or more would be in less than one of clear_odds parts.
 *
 * Then places look alike. Links of places alike err together and close loops, so what agrees proves nothing either.
 */
bool
isRefuted(const SureLinks& links, const ChoiceConfig& config);

} // namespace pcl_ssfr
