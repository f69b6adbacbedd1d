// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The smallest program: load two scans, align the first with the second, print the pose.
// Usage: minimal_align SOURCE.pcd TARGET.pcd

#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

int
main(int argc, char** argv)
{
  const auto source = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  const auto target = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  if (argc != 3 || pcl::io::loadPCDFile(argv[1], *source) < 0 || pcl::io::loadPCDFile(argv[2], *target) < 0) {
    std::cerr << "usage: minimal_align SOURCE.pcd TARGET.pcd\n";
    return 2;
  }

  pcl_ssfr::StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ> registration;
  registration.setInputSource(source);
  registration.setInputTarget(target);
  pcl::PointCloud<pcl::PointXYZ> moved;
  registration.align(moved);

  const pcl_ssfr::Result& result = registration.getResult();
  std::cout << pcl_ssfr::toString(result.status) << ", overlap " << result.overlap << ", confidence "
            << result.confidence << '\n';
  if (!registration.hasConverged()) {
    std::cout << result.message << '\n';
    return 1;
  }
  std::cout << registration.getFinalTransformation() << '\n';
  return 0;
}
