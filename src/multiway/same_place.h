// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/rival_places.h"

#include <Eigen/Geometry>

#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// Log odds that two scans at a pose show one place and not two that look alike.
using PairOddsFunction = std::function<double(const PlacedPair& pair)>;

/** \brief Log odds that scans, laid onto each other, show one place and not two that look alike.
 *
 * Those of pairs are added, and kept: where scans have moved by less than a tenth of what makes places distinct, what
 * they see of each other is not looked at again.
 */
class SamePlaceOdds {
public:
  /// \param[in] odds of a pair; called from several threads, always with source < target
  /// \param[in] places of the sensors in the scans' frames [m]; they must outlive it
  SamePlaceOdds(PairOddsFunction odds, const std::vector<Eigen::Vector3d>& places, const MultiwayOptions& options);

  /// Of all these pairs together; 0 of none.
  double
  of(const std::vector<PlacedPair>& pairs);

private:
  struct Known {
    Eigen::Isometry3d T_target_source;
    double odds = 0;
  };

  PairOddsFunction odds_;
  const std::vector<Eigen::Vector3d>& places_;
  ChoiceConfig config_; ///< with bounds within which odds are kept
  int threads_ = 1;
  std::map<std::pair<int, int>, std::vector<Known>> known_;
};

/** \brief Put scans together where places look alike: what looks most like one place first.
 *
 * Where places look alike, sure links are false, agree with each other, and close loops. So a link only says where two
 * parts may be laid onto each other; whether they are is said by what all scans of the one see of all scans of the
 * other. Of all joins with odds for one place the one comes first for which there is most evidence: a wrong one has
 * little of it between two scans, and much against it once both have been joined with others. What is left of it is
 * found by findScansWithRivalsAlike().
 *
 * \param[in] graph the priors of its hypotheses count, their beliefs do not
 * \param[in] places of the sensors in the scans' frames [m]
 * \param[in] join_test nullptr: none
 * \return with a refusal for each link on a join that was not made, and the links that are used
 */
Assembly
assembleBySamePlace(const std::vector<PairLink>& links,
                    const HypothesisGraph& graph,
                    const std::vector<Eigen::Vector3d>& places,
                    SamePlaceOdds& odds,
                    const Decisions& decisions,
                    const MultiwayOptions& options,
                    const JoinTest& join_test = nullptr);

/** \brief Scans, of those asked about, for which it is not clear where they belong among places that look alike.
 *
 * Rivals are other places that links with a probability of ChoiceConfig::rival say. All other scans of its part must
 * have odds of ChoiceConfig::clear_odds for where a scan is, against a rival; a scan that stands where the rival is
 * would stand where this one does, and what the others say of that counts as well. A place in another part, by a sure
 * link, must not have higher odds, and odds for it, than the one that the scan has: if both were right, the parts would
 * be joined.
 * \return in the order of \p asked; no scan of which a person accepted a link
 */
std::vector<int>
findScansWithRivalsAlike(const std::vector<int>& asked,
                         const PlacedScans& placed,
                         SamePlaceOdds& odds,
                         const Decisions& decisions,
                         const MultiwayOptions& options);

} // namespace pcl_ssfr
