// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>

namespace pcl_ssfr {

Eigen::Matrix3d
nearestRotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

double
angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

bool
keepsVertical(const Eigen::Matrix3d& R_target_source, const GravityPrior& gravity, double tolerance)
{
  const Eigen::Vector3d up = R_target_source * gravity.up_source;
  return std::atan2(up.cross(gravity.up_target).norm(), up.dot(gravity.up_target)) <= tolerance;
}

} // namespace pcl_ssfr
