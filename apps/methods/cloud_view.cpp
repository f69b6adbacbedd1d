// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/cloud_view.h>

namespace pcl_ssfr {
namespace apps {

ScanView
viewOf(const io::LoadedCloud& cloud)
{
  ScanView view;
  view.size = cloud.points->size();
  view.stride = sizeof(pcl::PointXYZINormal) / sizeof(float);
  if (view.size > 0) {
    view.xyz = cloud.points->front().data;
    view.normals = cloud.has_normals ? cloud.points->front().data_n : nullptr;
  }
  view.viewpoint = cloud.viewpoint.value_or(Eigen::Vector3d::Zero()) - cloud.offset;
  return view;
}

ScanView
viewOf(const io::ScanPoints& points)
{
  ScanView view;
  view.size = points.size;
  view.stride = points.stride();
  if (view.size > 0) {
    view.xyz = points.xyz();
    view.normals = points.has_normals ? points.xyz() + 3 : nullptr;
  }
  view.viewpoint = points.viewpoint.value_or(Eigen::Vector3d::Zero()) - points.offset;
  return view;
}

} // namespace apps
} // namespace pcl_ssfr
