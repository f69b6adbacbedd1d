// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>

namespace pcl_ssfr {

/** \brief A scan as its owner stores it: borrowed, strided, never copied. Any point type of PCL fits.
 *
 * Non-finite points are allowed anywhere and are skipped, and so are points exactly at the viewpoint: many drivers put
 * there what did not return, often more than half of a scan. The owner keeps the memory alive.
 */
struct ScanView {
  const float* xyz = nullptr;            ///< x of the first point; y and z follow it [m]
  std::size_t stride = 3;                ///< floats from one point to the next, >= 3
  std::size_t size = 0;                  ///< number of points behind \ref xyz
  const float* normals = nullptr;        ///< nx of the first point, same stride; null: no normals
  const std::int32_t* indices = nullptr; ///< points to use, each in [0, size); null: all
  std::size_t index_count = 0;           ///< number of \ref indices
  /// Position of the sensor in the coordinates of the points [m], as far as the caller knows or assumes one.
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  /// The viewpoint was given by the user: it is used whatever the points look like.
  bool viewpoint_is_known = false;

  /// Number of points to visit (before those are dropped that are no returns).
  std::size_t
  count() const
  {
    return indices ? index_count : size;
  }
  /// Index into \ref xyz of the i-th point to visit, i in [0, count()).
  std::size_t
  index(std::size_t i) const
  {
    return indices ? static_cast<std::size_t>(indices[i]) : i;
  }
  /// The i-th point to visit.
  Eigen::Map<const Eigen::Vector3f>
  point(std::size_t i) const
  {
    return Eigen::Map<const Eigen::Vector3f>(xyz + index(i) * stride);
  }
  /// Whether the i-th point to visit is a return of the sensor: finite, and not at the viewpoint.
  bool
  isReturn(std::size_t i) const
  {
    const Eigen::Vector3f p = point(i);
    return p.allFinite() && p != viewpoint.cast<float>();
  }
  /// The normal of the i-th point to visit; only when \ref normals is set.
  Eigen::Map<const Eigen::Vector3f>
  normal(std::size_t i) const
  {
    return Eigen::Map<const Eigen::Vector3f>(normals + index(i) * stride);
  }
};

} // namespace pcl_ssfr
