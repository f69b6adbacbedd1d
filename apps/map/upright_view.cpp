// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/upright_view.h>

#include "common/rotation_math.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kAgreed = 0.97; // cosine to the mean axis, 14 degrees
constexpr double kNear = 0.9;    // cosine of a normal to the vertical that counts for it, 26 degrees
constexpr double kWall = 0.3;    // cosine of a wall's normal to the vertical, at most
constexpr int kRounds = 5;       // of the mean of normals

Eigen::Vector3d
firstVertical(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& axes)
{
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& axis : axes)
    mean += axis;
  if (mean.norm() >= kAgreed * static_cast<double>(axes.size()) && !mean.isZero(0))
    return mean.normalized();
  if (points.empty())
    return Eigen::Vector3d::UnitZ();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points)
    centre += point / static_cast<double>(points.size());
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points)
    sum += (point - centre) * (point - centre).transpose();
  const Eigen::Vector3d least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(0);
  return least.dot(mean) < 0 ? Eigen::Vector3d(-least) : least;
}

} // namespace

Eigen::Matrix3d
uprightView(const std::vector<Eigen::Vector3d>& points,
            const std::vector<Eigen::Vector3d>& normals,
            const std::vector<double>& weights,
            const std::vector<Eigen::Vector3d>& axes)
{
  Eigen::Vector3d up = firstVertical(points, axes);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (const double cosine = normals[i].dot(up); std::abs(cosine) > kNear)
        mean += (cosine < 0 ? -weights[i] : weights[i]) * normals[i];
    if (!mean.isZero(0))
      up = mean.normalized();
  }
  const Eigen::Matrix3d level = rotationOnto(up, Eigen::Vector3d::UnitZ());
  double cosines = 0, sines = 0; // of four times the heading: walls of a room are a quarter of a turn apart
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Eigen::Vector3d n = level * normals[i];
    if (std::abs(n.z()) > kWall)
      continue;
    const double heading = 4 * std::atan2(n.y(), n.x());
    cosines += weights[i] * std::cos(heading);
    sines += weights[i] * std::sin(heading);
  }
  const double heading = cosines == 0 && sines == 0 ? 0 : std::atan2(sines, cosines) / 4;
  return Eigen::AngleAxisd(-heading, Eigen::Vector3d::UnitZ()).toRotationMatrix() * level;
}

} // namespace apps
} // namespace pcl_ssfr
