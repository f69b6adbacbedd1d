// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/scan_view.h>

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace pcl_ssfr {

/// Where a scan lies and how far it reaches; what every other scale follows from.
struct ScanExtent {
  std::size_t returns = 0;                          ///< see ScanView::isReturn()
  Eigen::Vector3d median = Eigen::Vector3d::Zero(); ///< along each axis, of up to some 20000 of the points [m]
  Eigen::Vector3d min = Eigen::Vector3d::Zero();    ///< corner of the bounding box [m]
  Eigen::Vector3d max = Eigen::Vector3d::Zero();    ///< corner of the bounding box [m]
  double radius = 0; ///< 90th percentile of the distance to the median, of the same points [m]
};

/// Measure the returns of a scan. All zero where it has none. When \p deadline passes meanwhile, the result is
/// unspecified.
ScanExtent
measureExtent(const ScanView& scan, const Deadline& deadline = Deadline());

/** \brief One averaged point per voxel, in Morton order of the voxels, so that every octree cell is a contiguous range.
 *
 * Cell l of a point is its \ref codes shifted right by 3 l: cells of edge leaf * 2^l.
 */
struct ThinnedCloud {
  double leaf = 0;                                  ///< edge of the voxels [m]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< subtracted from the points in double [m]
  Eigen::Matrix3Xf points;                          ///< relative to \ref origin, 3 x N [m]
  Eigen::Matrix3Xf normals;                         ///< sums of the given normals, 3 x N; empty when none were given
  std::vector<std::uint64_t> codes;                 ///< Morton code of the voxel, ascending, N
  std::vector<std::uint32_t> counts;                ///< points averaged, N

  Eigen::Index
  size() const
  {
    return points.cols();
  }
};

/// Points farther than this from the origin along an axis are not used: their voxels have no Morton code [m].
double
thinningReach(double leaf);

/** \brief Thin the returns of a scan to one averaged point per voxel of edge \p leaf [m] > 0, relative to \p origin.
 *
 * Points farther than \p max_distance [m] from the origin along any axis are dropped (0: no bound); so is whatever
 * would leave the 2^21 voxels that a Morton code addresses along each axis. The result does not depend on \p threads.
 * When \p deadline passes meanwhile it is empty. Besides the result it needs 6 bytes per point.
 */
ThinnedCloud
thinScan(const ScanView& scan,
         double leaf,
         const Eigen::Vector3d& origin,
         double max_distance = 0,
         unsigned threads = 1,
         const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
