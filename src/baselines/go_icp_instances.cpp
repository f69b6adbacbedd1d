// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/impl/go_icp.hpp>

namespace pcl_ssfr::baselines {
template class GoIcp<pcl::PointXYZ, pcl::PointXYZ, float>;
template class GoIcp<pcl::PointXYZ, pcl::PointXYZ, double>;
template class GoIcp<pcl::PointXYZI, pcl::PointXYZI, float>;
template class GoIcp<pcl::PointXYZI, pcl::PointXYZI, double>;
template class GoIcp<pcl::PointNormal, pcl::PointNormal, float>;
template class GoIcp<pcl::PointNormal, pcl::PointNormal, double>;
template class GoIcp<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class GoIcp<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
