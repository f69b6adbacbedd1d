// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <gmock/gmock.h>

#include <cmath>

namespace pcl_ssfr::testing {

/// Any pose as Matrix4d.
template <typename Scalar, int Mode, int Options>
Eigen::Matrix4d
poseMatrix(const Eigen::Transform<Scalar, 3, Mode, Options>& T)
{
  return T.matrix().template cast<double>();
}

template <typename Derived>
Eigen::Matrix4d
poseMatrix(const Eigen::MatrixBase<Derived>& T)
{
  return T.template cast<double>();
}

/// How far two poses are apart: T_estimated^-1 T_reference.
struct PoseError {
  double rotation = 0;    ///< angle of the rotation [rad]
  double translation = 0; ///< norm of the translation [m]
};

template <typename Estimate, typename Reference>
PoseError
poseError(const Estimate& T_estimated, const Reference& T_reference)
{
  const Eigen::Matrix4d estimated = poseMatrix(T_estimated);
  const Eigen::Matrix4d reference = poseMatrix(T_reference);
  const Eigen::Matrix3d R_t = estimated.topLeftCorner<3, 3>().transpose();
  const Eigen::Quaterniond q(Eigen::Matrix3d(R_t * reference.topLeftCorner<3, 3>()));
  PoseError error;
  error.rotation = 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
  error.translation = (R_t * (reference.topRightCorner<3, 1>() - estimated.topRightCorner<3, 1>())).norm();
  return error;
}

/// True when T is a rigid motion: proper rotation to \p tolerance, last row 0 0 0 1.
template <typename Pose>
bool
isRigid(const Pose& T, double tolerance = 1e-4)
{
  const Eigen::Matrix4d matrix = poseMatrix(T);
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  return matrix.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < tolerance &&
         R.determinant() > 0 && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
}

/// The pose (Isometry3, Matrix4, float or double) is rigid and within \p max_rotation [rad] and \p max_translation [m]
/// of \p T_reference.
MATCHER_P3(IsPoseNear, T_reference, max_rotation, max_translation, "")
{
  constexpr double kDegree = 3.14159265358979323846 / 180;
  if (!isRigid(arg)) {
    *result_listener << "which is no rigid motion";
    return false;
  }
  const PoseError error = poseError(arg, T_reference);
  *result_listener << "which is off by " << error.rotation / kDegree << " degrees and " << error.translation
                   << " m, allowed " << max_rotation / kDegree << " degrees and " << max_translation << " m";
  return error.rotation <= max_rotation && error.translation <= max_translation;
}

} // namespace pcl_ssfr::testing
