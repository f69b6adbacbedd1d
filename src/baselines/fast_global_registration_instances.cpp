// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/impl/fast_global_registration.hpp>

namespace pcl_ssfr::baselines {
template class FastGlobalRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
template class FastGlobalRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
template class FastGlobalRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
template class FastGlobalRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
template class FastGlobalRegistration<pcl::PointNormal, pcl::PointNormal, float>;
template class FastGlobalRegistration<pcl::PointNormal, pcl::PointNormal, double>;
template class FastGlobalRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class FastGlobalRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
