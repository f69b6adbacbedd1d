// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/search/kdtree.h>

#include <cstddef>

namespace pcl_ssfr {
namespace apps {

void
addNormals(const MethodCloud::Ptr& cloud, const Eigen::Vector3d& sensor, double radius, unsigned threads)
{
  pcl::NormalEstimationOMP<MethodPoint, MethodPoint> estimation(threads);
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<MethodPoint>>());
  estimation.setRadiusSearch(radius);
  const Eigen::Vector3f viewpoint = sensor.cast<float>();
  estimation.setViewPoint(viewpoint.x(), viewpoint.y(), viewpoint.z());
  MethodCloud normals;
  estimation.compute(normals);
  for (std::size_t i = 0; i < cloud->size(); ++i)
    (*cloud)[i].getNormalVector3fMap() = normals[i].getNormalVector3fMap();
}

} // namespace apps
} // namespace pcl_ssfr
