// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/scan_view.h>

#include <pcl/common/point_tests.h>
#include <pcl/common/transforms.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/type_traits.h>
#include <pcl/types.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace pcl_ssfr::detail {

inline constexpr std::int32_t kNoIndex{}; ///< what an empty index list points to: null would mean all points

/// Floats before field \p Tag in a point; only for fields that are floats.
template <typename PointT, typename Tag>
constexpr std::size_t
floatOffset()
{
  static_assert(pcl::traits::offset<PointT, Tag>::value % sizeof(float) == 0, "fields must be aligned");
  return pcl::traits::offset<PointT, Tag>::value / sizeof(float);
}

/// True when the point type carries its normal as three floats in a row.
template <typename PointT>
constexpr bool
hasNormal()
{
  if constexpr (pcl::traits::has_normal_v<PointT>) {
    return std::is_same_v<typename pcl::traits::datatype<PointT, pcl::fields::normal_x>::type, float> &&
           floatOffset<PointT, pcl::fields::normal_y>() == floatOffset<PointT, pcl::fields::normal_x>() + 1 &&
           floatOffset<PointT, pcl::fields::normal_z>() == floatOffset<PointT, pcl::fields::normal_x>() + 2;
  }
  else {
    return false;
  }
}

/// The points of \p cloud (of \p indices only, when given) as the core reads them; nothing is copied.
template <typename PointT>
ScanView
viewOf(const pcl::PointCloud<PointT>& cloud,
       const pcl::Indices* indices,
       const std::optional<Eigen::Vector3d>& viewpoint)
{
  static_assert(sizeof(PointT) % sizeof(float) == 0, "points must be made of whole floats");
  static_assert(std::is_same_v<pcl::index_t, std::int32_t>, "PCL must be built with 32 bit indices");

  ScanView view;
  view.stride = sizeof(PointT) / sizeof(float);
  view.size = cloud.size();
  if (!cloud.empty()) {
    view.xyz = cloud.points.front().data;
    if constexpr (hasNormal<PointT>()) {
      view.normals =
          reinterpret_cast<const float*>(&cloud.points.front()) + floatOffset<PointT, pcl::fields::normal_x>();
    }
  }
  if (indices) {
    view.indices = indices->empty() ? &kNoIndex : indices->data();
    view.index_count = indices->size();
  }
  const Eigen::Vector3d origin = cloud.sensor_origin_.template head<3>().template cast<double>();
  view.viewpoint = viewpoint ? *viewpoint : (origin.allFinite() ? origin : Eigen::Vector3d::Zero());
  view.viewpoint_is_known = viewpoint.has_value();
  return view;
}

/** \brief Move the points \p indices of \p input by \p transform into \p output, which is another cloud.
 *
 * Normals are rotated and the other fields kept. Non-finite points stay as they are, whatever `is_dense` says. All
 * points of an organised cloud stay organised.
 */
template <typename PointT, typename Scalar>
void
moveCloud(const pcl::PointCloud<PointT>& input,
          const pcl::Indices& indices,
          const Eigen::Matrix<Scalar, 4, 4>& transform,
          pcl::PointCloud<PointT>& output)
{
  if constexpr (pcl::traits::has_normal_v<PointT>) {
    pcl::transformPointCloudWithNormals(input, indices, output, transform);
  }
  else {
    pcl::transformPointCloud(input, indices, output, transform);
  }
  if (indices.size() == input.size()) {
    output.width = input.width;
    output.height = input.height;
  }
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const PointT& original = input[static_cast<std::size_t>(indices[i])];
    if (!pcl::isXYZFinite(original)) {
      output[i] = original;
      output[i].data[3] = 1.0F;
    }
  }
}

} // namespace pcl_ssfr::detail
