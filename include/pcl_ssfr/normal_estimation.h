// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/scan_view.h>
#include <pcl_ssfr/types.h>

namespace pcl_ssfr {

/// Options of the paper's point sampling and normals (paper, section 3.1; METHOD stage 1).
struct NormalOptions {
  double pre_leaf = 0.01; ///< keep one real point a voxel of this size before the normals [m]; 0: keep all
  double radius = 0;      ///< PCA radius r [m]; 0: from the data
  double leaf = 0;        ///< keep one real point a voxel of this size after the normals [m]; 0: from the data
  double max_range = 0;   ///< drop points farther than this from the viewpoint [m]; 0: no bound
  bool away_from_viewpoint = false; ///< sign of the normals: towards the viewpoint (2017) or away from it (2019)
  bool use_given_normals = true;    ///< take finite unit normals that the scan already carries
};

/// The scales that were used, and the samples.
struct NormalEstimationResult {
  OrientedSamples samples;                          ///< unit weights, zero extents, relative to \ref origin
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< subtracted from the points before anything else [m]
  double radius = 0;                                ///< [m]
  double leaf = 0;                                  ///< [m]
  double resolution = 0;                            ///< mean distance to the nearest neighbour after pre_leaf [m]
  std::size_t finite_points = 0;
};

/** \brief Sample the scan, estimate PCA normals in a radius with PCL's tree and covariance (the normals of
 * pcl::NormalEstimationOMP), orient them relative to the viewpoint, thin (METHOD stage 1).
 *
 * Thinning keeps real points, so the normals are only computed at those that stay, over all points.
 *
 * Points with fewer than 3 neighbours, or whose neighbours lie on a line, have no normal and are dropped.
 * \param[in] oriented false: the viewpoint is not believed; normals keep an arbitrary sign and the result says so.
 * \param[in] threads only changes the speed. \param[in] deadline what it gives when that passes meanwhile is of no use
 */
NormalEstimationResult
estimateNormals(const ScanView& scan,
                const NormalOptions& options,
                bool oriented,
                unsigned threads = 1,
                const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
