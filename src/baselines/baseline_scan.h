// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/scan_view.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>

// What every comparison method starts from: two scans thinned alike, each about its own origin.
namespace pcl_ssfr::baselines {

/// Fewer points do not determine a pose.
constexpr Eigen::Index kPosePoints = 3;

/// A thinned scan, centred for the sake of float arithmetic.
struct BaselineScan {
  Points3 points;                                      ///< relative to \ref origin, 3 x N [m]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< subtracted from the points of the scan [m]
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero(); ///< of the sensor, relative to \ref origin [m]
};

/** \brief The voxel edge [m] for a pair of scans when the caller gives none.
 *
 * 1/50 of the smaller scan's radius (90th percentile of the distance to the median point), grown by halves until an
 * occupied voxel holds 3 points on average in both scans, but to no more than 1/5 of that radius. 0 when a scan has no
 * extent.
 */
double
deriveLeaf(const ScanView& source, const ScanView& target, unsigned threads);

/// One averaged point per voxel of edge \p leaf [m]; all returns as they are when leaf is 0.
BaselineScan
thinBaselineScan(const ScanView& scan, double leaf, unsigned threads);

/// The two scans of a registration, thinned to the same leaf.
struct BaselinePair {
  BaselineScan source;
  BaselineScan target;
};

/** \brief thinBaselineScan() for both, with \p leaf [m] or, when that is 0, what deriveLeaf() gives.
 * \param[out] result leaf and numbers of points; a message when there is no pair, because a scan has no extent or fewer
 * than \p min_points points
 */
std::optional<BaselinePair>
thinPair(const ScanView& source,
         const ScanView& target,
         double leaf,
         unsigned threads,
         Eigen::Index min_points,
         BaselineResult& result);

/// The pose between the scans as given, from the one between the centred scans.
Eigen::Isometry3d
uncentred(const Eigen::Isometry3d& T_centred, const BaselineScan& source, const BaselineScan& target);

/// The opposite of uncentred().
Eigen::Isometry3d
centred(const Eigen::Isometry3d& T, const BaselineScan& source, const BaselineScan& target);

} // namespace pcl_ssfr::baselines
