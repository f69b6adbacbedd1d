// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/impl/baseline_registration.hpp>

namespace pcl_ssfr::baselines {
template class BaselineRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
template class BaselineRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
template class BaselineRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
template class BaselineRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
template class BaselineRegistration<pcl::PointNormal, pcl::PointNormal, float>;
template class BaselineRegistration<pcl::PointNormal, pcl::PointNormal, double>;
template class BaselineRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class BaselineRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
