// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/prepared_scan.h>

#include <Eigen/Geometry>

namespace pcl_ssfr {

/** \brief The patches of a scan that are of no large plane: furniture, frames, machines.
 *
 * Places that look alike have walls, floors and ceilings in common, and differ in these. The time grows with the square
 * of the patches (some milliseconds a scan). \return none of a scan that has no patches
 */
OrientedSamples
furnitureOf(const PreparedScan& scan, const FurnitureConfig& config);

/// What becomes of the furniture of two scans in each other, in patches (WeightedEvidence).
struct FurnitureEvidence {
  double seen = 0;         ///< in view of the other sensor
  double seen_through = 0; ///< of those: there the other one saw free space

  FurnitureEvidence&
  operator+=(const FurnitureEvidence& other);
};

/// Both ways. \param[in] source_furniture,target_furniture furnitureOf() the scans
FurnitureEvidence
furnitureAt(const PreparedScan& source,
            const OrientedSamples& source_furniture,
            const PreparedScan& target,
            const OrientedSamples& target_furniture,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options);

} // namespace pcl_ssfr
