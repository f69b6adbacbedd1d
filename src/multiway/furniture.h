// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/scan_pair.h"

#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/prepared_scan.h>

#include <vector>

namespace pcl_ssfr {

/** \brief The patches of a scan that are of no large plane and the points of none (solidClutter()): furniture, frames,
 * machines.
 *
 * Places that look alike have walls, floors and ceilings in common, and differ in these. The time grows with the square
 * of the patches (some milliseconds a scan). \return nothing of a scan that has no points
 */
Furniture
furnitureOf(const PreparedScan& scan, const MultiwayOptions& options);

/// Whether less than half of the patches of a scan are furniture: elsewhere much of it is leaves, which are seen
/// through from anywhere. \return false of a scan that has no patches
bool
isWalled(const PreparedScan& scan, const Furniture& furniture);

/** \brief Log odds that two scans show one place and not two places alike, by the furniture that is seen through.
 *
 * Of each kind of pair the share of it is taken for a draw from a beta distribution with its mode at none: of what is
 * in view, each is seen through with that share.
 * \param[in] pair of nothing in view nothing is known: 0
 */
double
furnitureLogOdds(const FurnitureEvidence& pair, const FurnitureConfig& config);

/// furnitureLogOdds() of a pair as one of many that see the same place: if they are for it, FurnitureConfig::agreement
/// times as much.
double
logOddsAmongMany(const FurnitureEvidence& pair, const FurnitureConfig& config);

/** \brief The share of poses that are of places alike, by the furniture that is seen through: by expectation and
 * maximisation, some right poses added.
 * \return [0, 1); 0 of no poses
 */
double
shareOfPlacesAlike(const std::vector<FurnitureEvidence>& pairs, const FurnitureConfig& config);

} // namespace pcl_ssfr
