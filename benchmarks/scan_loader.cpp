// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "scan_loader.h"

#include <apps/io/dataset_folder.h>

#include <pcl/common/point_tests.h>
#include <pcl/io/pcd_io.h>

#include <stdexcept>

namespace pcl_ssfr::benchmarks {

pcl::PointCloud<pcl::PointXYZ>::Ptr
loadScan(const std::string& folder, const std::string& name)
{
  const std::string file = io::scanPath(folder, name);
  pcl::PointCloud<pcl::PointXYZ> all;
  if (pcl::io::loadPCDFile(file, all) < 0)
    throw std::runtime_error(file + ": cannot read");
  auto finite = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const pcl::PointXYZ& point : all) {
    if (pcl::isXYZFinite(point))
      finite->push_back(point);
  }
  return finite;
}

} // namespace pcl_ssfr::benchmarks
