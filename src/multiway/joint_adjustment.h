// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/scan_pair.h"

#include <Eigen/Geometry>

#include <functional>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// Gives the linearised plane distances of pair k at a pose (equationsAt()).
using EquationsFunction = std::function<SurfaceEquations(std::size_t pair, const Eigen::Isometry3d& T_target_source)>;

/// Gives what each patch of one scan of pair k adds to the gradient of these equations (patchGradientsAt()).
using PatchGradientsFunction =
    std::function<PatchGradients(std::size_t pair, const Eigen::Isometry3d& T_target_source, bool of_source)>;

/// Poses of the scans of one part, adjusted jointly over their surfaces.
struct JointAdjustment {
  std::vector<Eigen::Isometry3d> poses; ///< T_map_scan
  /// Of small motions on the left about each scan's place, order (rotation [rad], translation [m]); zero of fixed ones,
  /// NaN where the equations have no solution. Empty where none were asked for.
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;
  double rms = 0; ///< of plane distances [m]
};

/// The damping for a part of some scans: no more than a row of as many bends against
/// (AdjustmentConfig::damping_of_row).
double
dampingOf(const AdjustmentConfig& config, std::size_t scans);

/** \brief All poses of a part at once: the plane distances of all overlapping pairs are made small together.
 *
 * Steps on the robust point-to-plane distances (stepMatrix()): each pair contributes its equations in the motion of its
 * source relative to its target, so a loop is closed where its surfaces meet, not by averages of pairs.
 *
 * The covariance is that of a robust estimate whose data err in patches, A^-1 B A^-1 as of a pair (PoseUncertainty),
 * with one B for the network: a patch errs once for all pairs that it takes part in. That is what averages do not
 * remove: with ever more pairs, each scan is known as well as its own patches are, not better.
 * \param[in] poses start, T_map_scan
 * \param[in] pairs (source, target) that overlap
 * \param[in] fixed scans whose poses are kept, at least one
 * \param[in] places of the sensors in the scans' frames [m]
 * \param[in] patches empty: no covariances
 */
JointAdjustment
adjustJointly(std::vector<Eigen::Isometry3d> poses,
              const std::vector<std::pair<int, int>>& pairs,
              const std::vector<int>& fixed,
              const std::vector<Eigen::Vector3d>& places,
              const EquationsFunction& equations,
              const PatchGradientsFunction& patches,
              const AdjustmentConfig& config,
              int threads);

/// Root mean square of the plane distances of all pairs at the poses [m]; see adjustJointly().
double
rmsOfPairs(const std::vector<Eigen::Isometry3d>& poses,
           const std::vector<std::pair<int, int>>& pairs,
           const std::vector<Eigen::Vector3d>& places,
           const EquationsFunction& equations,
           int threads);

} // namespace pcl_ssfr
