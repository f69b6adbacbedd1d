// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/impl/structured_scene_registration.hpp>

namespace pcl_ssfr {
namespace detail {
template class RegistrationAdaptor<pcl::PointXYZ, pcl::PointXYZ, float>;
template class RegistrationAdaptor<pcl::PointXYZ, pcl::PointXYZ, double>;
template class RegistrationAdaptor<pcl::PointXYZI, pcl::PointXYZI, float>;
template class RegistrationAdaptor<pcl::PointXYZI, pcl::PointXYZI, double>;
template class RegistrationAdaptor<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
template class RegistrationAdaptor<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
} // namespace detail
template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
} // namespace pcl_ssfr
