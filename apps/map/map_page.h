// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/map/map_files.h>

#include <Eigen/Core>

#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A part of report.html that is built into the program; empty for an unknown name.
std::string_view
mapAsset(std::string_view name);

/** \brief report.html: one file, no network.
 * \param[in] outlines some points of each scan for the drawings, in the scan's frame [m]
 * \param[in] places of the sensors in the scans' frames [m]
 */
std::string
mapPage(const MapOutput& output,
        const std::vector<Eigen::Matrix3Xf>& outlines,
        const std::vector<Eigen::Vector3d>& places);

} // namespace apps
} // namespace pcl_ssfr
