// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/furniture.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/map_stages.h"
#include "multiway/parts.h"
#include "multiway/placed_evidence.h"
#include "multiway/storeys.h"

#include <string>
#include <vector>

namespace pcl_ssfr {

/// Scans of a part that are not to be trusted.
struct Doubt {
  std::vector<int> scans;
  std::string note; ///< for people
};

/// What furniture says of the sure links of a job.
struct FurnitureFindings {
  double false_share = 0;           ///< of all; FurnitureConfig::least_false: it distinguishes places here
  double false_share_of_walled = 0; ///< of those between walled scans; as many: places look alike here
};

/// Whose furniture counts.
enum class FurnitureOf {
  Walled, ///< pairs of walled scans: leaves are seen through, and prove nothing
  All     ///< of all, where places look alike; and scans at one place are two places
};

/** \brief The tests for places that look alike (MAPS, "Places that look alike" and "Storeys alike").
 *
 * Links of places alike agree with each other, so what the links say is not enough. What a person said decides about
 * the scans that it ties to each other, tiedScans(), and about no other one; nothing is found where
 * AliasConfig::check is off.
 */
class PlacesAlike {
public:
  /// All must outlive it.
  /// \param[in] places of the sensors in the frames of their scans [m]
  PlacesAlike(const MapInput& input,
              const std::vector<PairLink>& links,
              const MultiwayMap& map,
              const std::vector<Eigen::Vector3d>& places,
              PlacedEvidence& evidence);

  /// tiedScans() by accepted links and approximate poses.
  const std::vector<int>&
  tied() const
  {
    return tied_;
  }

  /// Of parts that no person decided.
  std::vector<int>
  undecidedScans(const Assembly& assembly) const;

  /// Find the furniture of all scans, before samePlaceLogOdds().
  FurnitureFindings
  findFurniture(const HypothesisGraph& graph);

  /** \brief Log odds that two scans at a pose show one place, not two that look alike: logOddsAmongMany(). 0
   * where AliasConfig::check is off. Where places look alike (FurnitureOf::All), less those of ChoiceConfig::clear_odds
   * within ChoiceConfig::same_translation, and these are the odds of scans that a person tied to each other.
   *
   * Furniture differs where walls are alike, and a scanner is hardly set up twice at one place.
   */
  double
  samePlaceLogOdds(const PlacedPair& pair, FurnitureOf whose) const;

  /// Whether scans are too far from each other to share anything, and no person tied them to each other.
  /// \param[in] distance of their sensors [m]
  bool
  areUnrelated(int source, int target, double distance) const;

  /// The share of its sure links that a part contradicts, where that is too often (isRefuted()); of several parts the
  /// largest, 0 where there is none.
  double
  refutedShare(const Assembly& assembly, const HypothesisGraph& graph) const;

  /// Piles within ChoiceConfig::same_translation in which a scan and at least two others see the same: a reason for
  /// doubt where these alone say so (findScansWithRivals()).
  Piles
  piles(const Assembly& assembly) const;

  /// Notes on scans of any part that stand within ChoiceConfig::same_translation of at least two others and see the
  /// same: no reason for doubt by itself, as sensors turn on the spot, but a person knows whether they did.
  std::vector<std::string>
  repeatedStations(const Assembly& assembly) const;

  /// Storeys that may be several laid onto one another: scansInDoubt().
  std::vector<Doubt>
  storeys(const Assembly& assembly) const;

private:
  /// What the scans of a pile see of each other's surfaces.
  enum class SeenInPile { TheSame, Anything };
  /// Of AliasConfig::least_scans scans and more.
  Piles
  pilesOf(const Assembly& assembly, const std::vector<int>& members, SeenInPile seen) const;
  bool
  isOfWalled(int scan) const;
  FurnitureEvidence
  furniture(int source, int target, const Eigen::Isometry3d& T_target_source) const;
  /// Parts of at least so many scans that are not decided.
  std::vector<std::vector<int>>
  undecidedParts(const Assembly& assembly, std::size_t least) const;
  /// Whether a person tied all of some scans to each other, or there are none.
  bool
  isDecided(const std::vector<int>& scans) const;
  const std::string&
  name(int scan) const;
  /// How many they are, and one of them. \param[in] scans at least one
  std::string
  inWords(const std::vector<int>& scans) const;

  const MapInput& input_;
  const std::vector<PairLink>& links_;
  const MultiwayMap& map_;
  const std::vector<Eigen::Vector3d>& places_;
  PlacedEvidence& evidence_;
  std::vector<int> tied_;
  std::vector<Furniture> furniture_; ///< of each scan; empty before findFurniture()
};

} // namespace pcl_ssfr
