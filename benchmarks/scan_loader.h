// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <string>

namespace pcl_ssfr::benchmarks {

/// The finite points of a scan of the folder. \throw std::runtime_error naming the file
pcl::PointCloud<pcl::PointXYZ>::Ptr
loadScan(const std::string& folder, const std::string& name);

} // namespace pcl_ssfr::benchmarks
