// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/scan_pair.h"

#include <pcl_ssfr/multiway/multiway_options.h>

#include <optional>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// Two groups of scans that contradict each other more than they do among themselves.
struct RivalGroups {
  std::vector<int> first;
  std::vector<int> second;
  double within = 0;  ///< median share of what is in view that is seen through, of two scans of one group
  double between = 0; ///< the same of two scans of different groups
};

/** \brief Whether the scans of a part fall into groups that contradict each other.
 *
 * Storeys that look alike, laid onto one another, agree in walls and floors, not in furniture: a percent or more of
 * what is in view is seen through. (Of what meets it would be a larger share the less two scans have in common, be they
 * right or wrong.) Two scans of one storey contradict each other less, so scans are joined to clusters, those that
 * contradict each other least first (average linkage), and whatever clusters meet on the way are compared: the rates of
 * all pairs between them against those of all pairs within them, by their medians and their ranks (the test of Mann and
 * Whitney). Single scans are joined without a test: one may be moved, or its sensor's place be wrong.
 *
 * \param[in] members scans of the part, ascending
 * \param[in] pairs of members, smaller first, each at most once
 * \param[in] evidence of each pair, where the map puts them; of total 0 (furniture) it counts whatever share is matched
 * \param[in] tied tiedScans(), which are one cluster from the start and so are not held against each other; empty: none
 * \return the first two clusters that are rivals; none: there are not any
 */
std::optional<RivalGroups>
findRivalGroups(const std::vector<int>& members,
                const std::vector<std::pair<int, int>>& pairs,
                const std::vector<PlacementEvidence>& evidence,
                const RivalGroupsConfig& config,
                const std::vector<int>& tied = {});

} // namespace pcl_ssfr
