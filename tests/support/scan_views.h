// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/scan_view.h>

#include <Eigen/Core>

#include <cstddef>

namespace pcl_ssfr::testing {

/// A matrix of points, 3 x N [m], as the core reads scans. The matrix must outlive the view.
inline ScanView
viewOfPoints(const Eigen::Matrix3Xf& points)
{
  ScanView view;
  view.xyz = points.data();
  view.size = static_cast<std::size_t>(points.cols());
  return view;
}

} // namespace pcl_ssfr::testing
