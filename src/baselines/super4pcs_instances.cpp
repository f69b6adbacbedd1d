// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/impl/super4pcs.hpp>

namespace pcl_ssfr::baselines {
template class Super4PCS<pcl::PointXYZ, pcl::PointXYZ, float>;
template class Super4PCS<pcl::PointXYZ, pcl::PointXYZ, double>;
template class Super4PCS<pcl::PointXYZI, pcl::PointXYZI, float>;
template class Super4PCS<pcl::PointXYZI, pcl::PointXYZI, double>;
template class Super4PCS<pcl::PointNormal, pcl::PointNormal, float>;
template class Super4PCS<pcl::PointNormal, pcl::PointNormal, double>;
template class Super4PCS<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class Super4PCS<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
