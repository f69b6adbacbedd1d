// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/impl/structured_scene_registration.hpp>

namespace pcl_ssfr {
namespace detail {
template class RegistrationAdaptor<pcl::PointNormal, pcl::PointNormal, float>;
template class RegistrationAdaptor<pcl::PointNormal, pcl::PointNormal, double>;
template class RegistrationAdaptor<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class RegistrationAdaptor<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace detail
template class StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, float>;
template class StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, double>;
template class StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
template class StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr
