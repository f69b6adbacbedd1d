// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/scan_view.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace pcl_ssfr::testing {

/// A cloud of PCL as the core reads scans. The cloud must outlive the view.
inline ScanView
viewOfCloud(const pcl::PointCloud<pcl::PointXYZ>& cloud)
{
  ScanView view;
  view.xyz = cloud.empty() ? nullptr : cloud.points.front().data;
  view.stride = sizeof(pcl::PointXYZ) / sizeof(float);
  view.size = cloud.size();
  return view;
}

} // namespace pcl_ssfr::testing
