// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "surface_normals.h"

#include <pcl/features/normal_3d_omp.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <cstddef>

namespace pcl_ssfr::baselines {

Points3
estimateSurfaceNormals(const Points3& points, const Eigen::Vector3d& viewpoint, double radius, unsigned threads)
{
  Points3 normals = Points3::Zero(3, points.cols());
  if (points.cols() == 0)
    return normals;
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->resize(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    (*cloud)[static_cast<std::size_t>(i)].getVector3fMap() = points.col(i).cast<float>();

  pcl::PointCloud<pcl::Normal> estimated;
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(threads);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(radius);
  estimation.setInputCloud(cloud);
  const Eigen::Vector3f eye = viewpoint.cast<float>();
  estimation.setViewPoint(eye.x(), eye.y(), eye.z());
  estimation.compute(estimated);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f normal = estimated[static_cast<std::size_t>(i)].getNormalVector3fMap();
    if (normal.allFinite())
      normals.col(i) = normal.cast<double>();
  }
  return normals;
}

} // namespace pcl_ssfr::baselines
