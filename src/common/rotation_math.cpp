// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"

#include "common/types.h"

#include <Eigen/SVD>

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pcl_ssfr {

Eigen::Matrix3d
nearestRotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d
rotationOnto(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
  // Two reflections: the first turns `from` round, the second, across what lies in the middle, lays it on `to`. A
  // quaternion of the two loses its digits, and is no rotation any more, where they are nearly opposite.
  constexpr double kOpposite = 1e-8; // length of the sum of unit vectors: with less, its direction is rounding
  const Eigen::Vector3d first = from.normalized();
  const Eigen::Vector3d sum = first + to.normalized();
  const Eigen::Vector3d middle = sum.norm() > kOpposite ? sum.normalized() : first.unitOrthogonal();
  const auto reflection = [](const Eigen::Vector3d& v) -> Eigen::Matrix3d {
    return Eigen::Matrix3d::Identity() - 2 * v * v.transpose();
  };
  return reflection(middle) * reflection(first);
}

double
angleBetweenDirections(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double
angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

bool
keepsVertical(const Eigen::Matrix3d& R_target_source, const GravityPrior& gravity, double tolerance)
{
  return angleBetweenDirections(R_target_source * gravity.up_source, gravity.up_target) <= tolerance;
}

void
requireRigid(const Eigen::Isometry3d& T, const char* name)
{
  std::ostringstream problem;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column)
      if (problem.str().empty() && !std::isfinite(T(row, column)))
        problem << name << "(" << row << ", " << column << ") = " << T(row, column) << ", must be finite";
  const Eigen::Matrix3d R = T.linear();
  const double deviation = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (problem.str().empty() && !(deviation <= kUnitTolerance && R.determinant() > 0))
    problem << "the linear part of " << name << " is no rotation: R^T R is " << deviation
            << " off the identity, its determinant " << R.determinant();
  if (!problem.str().empty())
    throw std::invalid_argument(problem.str());
}

} // namespace pcl_ssfr
