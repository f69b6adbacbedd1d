// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/map/map_files.h>
#include <apps/map/upright_view.h>

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
 * \param[in] outlines of the scans, drawn upright by component
 */
std::string
mapPage(const MapOutput& output, const std::vector<ScanOutline>& outlines);

} // namespace apps
} // namespace pcl_ssfr
