// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Two clouds of two points are no map, which is said: the installed component multiway links and runs.

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <pcl/point_types.h>

#include <iostream>
#include <stdexcept>

int
main()
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.push_back(pcl::PointXYZ(1, 2, 3));
  pcl_ssfr::MultiwayRegistration registration;
  registration.addPointCloud("a", cloud);
  registration.addPointCloud("b", cloud);
  try {
    registration.run();
  }
  catch (const std::invalid_argument& error) {
    std::cout << error.what() << '\n';
    return 0;
  }
  return 1;
}
