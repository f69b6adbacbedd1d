// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/angles.h"

#include <pcl_ssfr/options.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pcl_ssfr {

/// The rotation R that maximises trace(R^T M): of a correlation sum of w target source^T the best one (Kabsch 1976), of
/// a matrix that is nearly a rotation the nearest in the Frobenius norm.
Eigen::Matrix3d
nearestRotation(const Eigen::Matrix3d& matrix);

/// The smallest rotation that lays one direction, of any length > 0, on another; one of those that do where they are
/// opposite. Exact to rounding, of directions that are nearly opposite to 1e-8 rad.
Eigen::Matrix3d
rotationOnto(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Angle between two directions of any length > 0 [rad], [0, pi].
double
angleBetweenDirections(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Angle of the rotation that leads from one to the other [rad], [0, pi].
double
angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// Whether a rotation maps one vertical onto the other within \p tolerance [rad].
bool
keepsVertical(const Eigen::Matrix3d& R_target_source, const GravityPrior& gravity, double tolerance);

/// \throw std::invalid_argument for what is no rigid motion: \p name with the entry that is not finite, or how far off
void
requireRigid(const Eigen::Isometry3d& T, const char* name);

} // namespace pcl_ssfr
