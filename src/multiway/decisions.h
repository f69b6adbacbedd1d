// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_registration.h>

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// What a person decided; pairs as (smaller, larger number).
struct Decisions {
  std::set<std::pair<int, int>> accepted;
  std::set<std::pair<int, int>> rejected;
  std::vector<int> pinned;
};

/// Whether a person accepted, or rejected, the link of two scans. \param[in] source smaller than \p target
bool
isAccepted(const Decisions& decisions, int source, int target);
bool
isRejected(const Decisions& decisions, int source, int target);
/// Whether a person accepted any link of a scan.
bool
hasAcceptedLink(const Decisions& decisions, int scan);

/** \brief The same of the scans that are linked: of those with the same points the first.
 * \param[in] original of each scan: the first one with its points
 * \throw DecisionError when a pair is both accepted and rejected, or of a scan with itself; naming it by \p scans
 */
Decisions
onOriginals(const Decisions& given, const std::vector<int>& original, const std::vector<MapScan>& scans);

/** \brief Scans that a person tied to each other: by accepted links, in a row as well.
 * \param[in] placed scans of which a person said where they are: all of these are tied to each other
 * \param[in] count of all scans
 * \return of each scan a number that those tied to it have too
 */
std::vector<int>
tiedScans(const Decisions& decisions, const std::vector<int>& placed, std::size_t count);

/// Whether scans of a group are tied to others of its part. \param[in] group,members ascending \param[in] tied
/// tiedScans()
bool
areTiedToOthers(const std::vector<int>& group, const std::vector<int>& members, const std::vector<int>& tied);

/// What the approximate poses of two scans say of their pose.
/// \param[in] source_place,target_place of the sensors in the frames of the scans [m]
PairGuess
guessOf(const PosePrior& source,
        const PosePrior& target,
        const Eigen::Vector3d& source_place,
        const Eigen::Vector3d& target_place);

/// As the project keeps them: kind ("accept", "reject", "pin") and the names of the scans.
std::vector<std::pair<std::string, std::string>>
inWords(const Decisions& given, const std::vector<MapScan>& scans);

} // namespace pcl_ssfr
