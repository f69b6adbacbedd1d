// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/pipeline.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <string>

namespace pcl_ssfr_ros2 {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/** \brief What is said of directions that the scans leave open, as standard deviations.
 *
 * A covariance cannot say "not known": these bound it, by a prior about the pose that says next to nothing. Half the
 * circle, and farther than a LiDAR sees.
 */
constexpr double kUnknownRotation = 3.14159265358979323846; ///< [rad]
constexpr double kUnknownTranslation = 1000;                ///< [m]

/** \brief Covariance of a pose as geometry_msgs/PoseWithCovariance has it: x, y, z [m], then rotations about the fixed
 * axes X, Y, Z of the frame that the pose is given in [rad].
 *
 * Result::information is about motions x <- Exp(w) x + v of the target's frame in the order (w, v), so a rotation also
 * moves the pose's position t: the error of the position is v + w x t. Rotations are small here, so that the order of
 * the axes does not matter.
 * \param[in] information of Result, symmetric, positive semidefinite
 * \param[in] T_target_source the pose that it belongs to
 */
Matrix6
covarianceInRosOrder(const Matrix6& information, const Eigen::Isometry3d& T_target_source);

/// The same, row by row, as the message holds it.
std::array<double, 36>
toRowMajor(const Matrix6& covariance);

/** \brief The transform to publish when the source's frame already has a parent in the tree of frames.
 *
 * A frame has one parent. Where the scanner's is the odometry's, T_target_odometry is published in its place, so that
 * the chain target, odometry, scanner gives the pose that was found.
 * \param[in] T_target_source the pose that was found
 * \param[in] T_anchor_source the scanner in the frame that is to be the child, at the time of the scan
 */
Eigen::Isometry3d
anchored(const Eigen::Isometry3d& T_target_source, const Eigen::Isometry3d& T_anchor_source);

/// Read a map: PCD or PLY. \throw std::invalid_argument naming the file and what is wrong
pcl::PointCloud<pcl::PointXYZ>::Ptr
readMap(const std::string& path);

/// Settings of a matcher, parameters of the node.
struct MatcherConfig {
  unsigned threads = 0;        ///< 0: all processors
  double time_limit = 2;       ///< of a registration without the preparation of the map [s]; 0: none
  double min_confidence = 0.7; ///< accept from this confidence on, [0, 1]
  double gravity_tolerance =
      0; ///< > 0: z is up in both frames within this [rad], three standard deviations; 0: unknown
};

/// What is published of a registration.
struct Match {
  bool accepted = false; ///< publish only then
  std::string message;   ///< why, in one sentence
  double confidence = 0; ///< estimated probability that the pose is right, [0, 1]
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< pose of the source's frame in the target's
  Matrix6 covariance = Matrix6::Zero();                              ///< covarianceInRosOrder()
};

/// Registers scans onto one target, which is prepared once. Not to be used by two threads at once.
class ScanMatcher {
public:
  /// \throw std::invalid_argument naming the setting that is out of range
  explicit ScanMatcher(const MatcherConfig& config);

  /// The map, or the last cloud of the target's topic. It need not be kept.
  void
  setTarget(const pcl::PointCloud<pcl::PointXYZ>& cloud);

  bool
  hasTarget() const
  {
    return !target_.empty();
  }

  /// Without a target, or with clouds that say nothing, the match is not accepted and the message says why.
  Match
  match(const pcl::PointCloud<pcl::PointXYZ>& source) const;

private:
  pcl_ssfr::Options options_;
  pcl_ssfr::PreparedScan target_;
};

} // namespace pcl_ssfr_ros2
