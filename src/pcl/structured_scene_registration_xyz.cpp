// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/impl/structured_scene_registration.hpp>

namespace pcl_ssfr {
template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
} // namespace pcl_ssfr
