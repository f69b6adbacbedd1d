// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/prepared_scan.h>

namespace pcl_ssfr {

/** \brief The patches of a scan that are of no large plane: furniture, frames, machines.
 *
 * Places that look alike have walls, floors and ceilings in common, and differ in these. The time grows with the square
 * of the patches (some milliseconds a scan). \return none of a scan that has no patches
 */
OrientedSamples
furnitureOf(const PreparedScan& scan, const FurnitureConfig& config);

} // namespace pcl_ssfr
