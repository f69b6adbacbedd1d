// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/paper_options.h>
#include <pcl_ssfr/scan_view.h>

namespace pcl_ssfr {

/// The scales that were used, and the samples.
struct NormalEstimationResult {
  OrientedSamples samples;                          ///< unit weights, zero extents, relative to \ref origin
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< subtracted from the points before anything else [m]
  double radius = 0;                                ///< [m]
  double resolution = 0;                            ///< mean distance to the nearest neighbour after pre_leaf [m]
  std::size_t returns = 0;                          ///< see ScanView::isReturn(), of any range
};

/** \brief Sample the scan, estimate PCA normals in a radius with PCL's tree and covariance (the normals of
 * pcl::NormalEstimationOMP), orient them relative to the viewpoint, thin (METHOD stage 1).
 *
 * Thinning keeps real points, so the normals are only computed at those that stay, over all points.
 *
 * Points with fewer than 3 neighbours, or whose neighbours lie on a line, have no normal and are dropped.
 * \param[in] oriented false: the viewpoint is not accepted; normals keep an arbitrary sign and the result says so.
 * \param[in] threads only changes the speed.
 * \param[in] deadline when it passes meanwhile, the result is unspecified
 */
NormalEstimationResult
estimateNormals(const ScanView& scan,
                const NormalOptions& options,
                bool oriented,
                unsigned threads = 1,
                const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
