// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/scan_view.h>

#include <apps/io/loaded_cloud.h>

namespace pcl_ssfr {
namespace apps {

/// The view of a cloud that the library works on.
ScanView
viewOf(const io::LoadedCloud& cloud);

/// The same of a scan that was read for nothing else.
ScanView
viewOf(const io::ScanPoints& points);

} // namespace apps
} // namespace pcl_ssfr
