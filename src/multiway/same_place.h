// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/rival_places.h"

#include <Eigen/Geometry>

#include <functional>
#include <limits>
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
  /// \param[in] are_unrelated nullptr: none are; those that are are not kept, as most pairs of a large job are
  SamePlaceOdds(PairOddsFunction odds,
                const std::vector<Eigen::Vector3d>& places,
                const MultiwayOptions& options,
                PairTest are_unrelated = nullptr);

  /// Of all these pairs together; 0 of none. Once the first of them have \p hopeless or less, the others are not asked.
  double
  of(const std::vector<PlacedPair>& pairs, double hopeless = -std::numeric_limits<double>::infinity());

  /// What has no part in it, whatever the pose.
  const PairTest&
  areUnrelated() const
  {
    return are_unrelated_;
  }

private:
  struct Known {
    Eigen::Isometry3d T_target_source;
    double odds = 0;
  };

  bool
  isUnrelated(const PlacedPair& pair) const;
  /// \param[in] pairs with source < target
  std::vector<double>
  ofEach(const std::vector<PlacedPair>& pairs);

  PairOddsFunction odds_;
  PairTest are_unrelated_;
  const std::vector<Eigen::Vector3d>& places_;
  ChoiceConfig config_; ///< with bounds within which odds are kept
  int threads_ = 1;
  std::map<std::pair<int, int>, std::vector<Known>> known_;
};

/** \brief Scans, of those asked about, for which it is not clear where they belong among places that look alike.
 *
 * Rivals are other places that links with a probability of ChoiceConfig::rival say. All other scans of its part must
 * have odds of ChoiceConfig::clear_odds for where a scan is, against a rival; a scan that stands where the rival is
 * would stand where this one does, and what the others say of that counts as well. To what distinguishes places the
 * odds of the links and of all surfaces are added (logOdds()). A place in another part, by a sure link, must not have
 * higher odds, and odds for it, than the one that the scan has: if both were right, the parts would be joined.
 * \param[in] most_by_links mostLogOddsByLinks()
 * \return in the order of \p asked; no scan of which a person accepted a link
 */
std::vector<int>
findScansWithRivalsAlike(const std::vector<int>& asked,
                         const PlacedScans& placed,
                         SamePlaceOdds& odds,
                         const EvidenceFunction& evidence,
                         double most_by_links,
                         const Decisions& decisions,
                         const MultiwayOptions& options);

/** \brief Groups of two scans and more of a part that might belong elsewhere as a whole: weakestCuts() by the used
 * links, which weigh what distinguishes their places.
 */
std::vector<std::vector<int>>
groupsOf(const std::vector<int>& members, const PlacedScans& placed, SamePlaceOdds& odds);

/** \brief The first one, of groups of scans, for which it is not clear where it belongs among places that look alike:
 * findScansWithRivalsAlike(), all its scans moved together by what a link of any of them says. Asked alone, each is
 * where the others of its group say.
 * \return empty where there is none
 */
std::vector<int>
findGroupWithRivalAlike(const std::vector<std::vector<int>>& asked,
                        const PlacedScans& placed,
                        SamePlaceOdds& odds,
                        const EvidenceFunction& evidence,
                        double most_by_links,
                        const MultiwayOptions& options);

} // namespace pcl_ssfr
