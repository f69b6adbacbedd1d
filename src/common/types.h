// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pcl_ssfr {

/// Points or directions, one per column, 3 x N. Points are in metres [m].
using Points3 = Eigen::Matrix3Xd;

/// A vector that comes from outside is accepted as a unit vector when its norm is this near to 1.
constexpr double kUnitTolerance = 1e-3;

/// Bits per axis of the Morton code of a voxel: three times as many fit into 64.
constexpr int kMortonBits = 21;

/// Relative rounding of sums of many doubles: what is smaller is nothing.
constexpr double kRoundingOfSums = 1e-12;

/// |cosine| between a normal and a line of sight from which on a surface faces that sensor: six degrees. A plane
/// through the sensor cannot be seen: patches that do not face their own one are lines of points, one sweep along a
/// wall or the edge of a thing, which noise spreads along the line of sight. They lie where something is, but are no
/// surface.
constexpr double kMinFacing = 0.1;

/** \brief Weighted oriented samples of a scanned surface: what every stage after preparation works on.
 *
 * The paper's profile fills them with points and unit weights, the default profile with planar patches and their
 * areas; all later stages are the same functions for both.
 */
struct OrientedSamples {
  Points3 points;          ///< sample positions, 3 x N [m]
  Points3 normals;         ///< unit normals, 3 x N; towards the sensor when \ref oriented, else of arbitrary sign
  Eigen::VectorXd weights; ///< surface that each sample stands for, N, > 0 [m^2]; 1 for the paper's points
  Eigen::VectorXd extents; ///< half width of the sample within its plane, N, >= 0 [m]; 0 for points
  /// |cosine| of the angle between normal and line of sight, N, [0, 1]; empty or 1: the sensor's place is not known.
  /// Below kMinFacing a sample does not face its sensor.
  Eigen::VectorXd facing;
  bool oriented = true; ///< false: the sign of the normals carries no information (viewpoint unknown)

  Eigen::Index
  size() const
  {
    return points.cols();
  }
};

} // namespace pcl_ssfr
