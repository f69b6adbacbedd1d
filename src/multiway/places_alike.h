// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/furniture.h"
#include "multiway/hypothesis_graph.h"
#include "multiway/map_stages.h"
#include "multiway/parts.h"
#include "multiway/placed_evidence.h"
#include "multiway/rival_groups.h"
#include "multiway/storeys.h"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// Scans of a part that are not to be trusted.
struct Doubt {
  std::vector<int> scans;
  std::string note; ///< for people
};

/** \brief The tests for places that look alike (MAPS, "Places that look alike" and "Storeys alike").
 *
 * Links of places alike agree with each other, so what the links say is not enough. What a person said decides about
 * the scans that it ties to each other, tiedScans(), and about no other one; what finds parts in doubt finds none where
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

  /// Find the furniture of all scans, before mayStand(), excluded() and betweenRivals().
  void
  findFurniture();

  /// The scans of all parts that refuted() or rivalGroups() doubts.
  std::set<int>
  inDoubt(const Assembly& assembly, const HypothesisGraph& graph) const;

  /** \brief Hypotheses of the scans in doubt by which more than a very small share of what is in view is seen through.
   *
   * Furniture differs where walls are alike: a right pose contradicts nearly nothing, one of a place alike a few
   * percent. That is no rule for all jobs, as cars leave and poses of pairs are not exact.
   */
  ExcludedHypotheses
  contradicting(const std::set<int>& in_doubt) const;

  /** \brief Whether scans may stand so where places look alike: no two within ChoiceConfig::same_translation, and all
   * pairs together see through at most FurnitureConfig::seen_through of the furniture in view.
   *
   * Furniture differs where walls are alike, and nobody sets up a scanner twice at one place. That is no rule for all
   * jobs, as cars leave and poses of pairs are not exact.
   */
  bool
  mayStand(std::vector<PlacedPair> pairs) const;

  /// Hypotheses of the scans in doubt that put them where they may not stand.
  ExcludedHypotheses
  excluded(const std::set<int>& in_doubt) const;

  /// Hypotheses between groups of scans of a part that contradict each other, in all surfaces or in furniture, that
  /// agree with where it puts them.
  ExcludedHypotheses
  betweenRivals(const Assembly& assembly) const;

  /// The scans of parts whose sure links contradict each other too often.
  std::vector<int>
  refuted(const Assembly& assembly, const HypothesisGraph& graph) const;

  /// The scans of parts that were put together wrongly: scansOfMisledParts().
  /// \param[in] with_rivals findScansWithRivals()
  std::vector<int>
  misled(const Assembly& assembly, const std::vector<int>& with_rivals) const;

  /// Parts in which groups of scans contradict each other.
  std::vector<Doubt>
  rivalGroups(const Assembly& assembly) const;

  /// Of parts in doubt, scans that stand where at least two others do and see the same.
  std::vector<Doubt>
  sameStations(const Assembly& assembly, const std::set<int>& in_doubt) const;

  /** \brief Piles within ChoiceConfig::same_translation whose scans see through more than AliasConfig::seen_through of
   * what they see of each other: rooms alike, laid onto one another.
   *
   * From one place surfaces hide each other in the same way, and poses that are off by a little contradict nothing.
   */
  std::vector<Doubt>
  contradictingStations(const Assembly& assembly) const;

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
  /// Groups of a part that contradict each other, in furniture where that was found, or in all surfaces.
  /// \param[in] members of undecidedParts()
  std::optional<RivalGroups>
  rivalsOf(const Assembly& assembly, const std::vector<int>& members) const;
  std::optional<RivalGroups>
  rivalsByFurniture(const Assembly& assembly, const std::vector<int>& members) const;
  /// Hypotheses of the scans in doubt, but for those of scans that are tied, that the test finds to be out.
  template <typename Test>
  ExcludedHypotheses
  excludedBy(const std::set<int>& in_doubt, const Test& is_out) const;
  /// What the scans of a pile see of each other's surfaces.
  enum class SeenInPile { TheSame, Anything };
  /// Of AliasConfig::least_scans scans and more.
  Piles
  pilesOf(const Assembly& assembly, const std::vector<int>& members, double within, SeenInPile seen) const;
  PlacementEvidence
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
  std::vector<OrientedSamples> furniture_; ///< of each scan; empty before findFurniture()
};

} // namespace pcl_ssfr
