// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/footprint.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

Eigen::Matrix2d
turnOf(double yaw)
{
  return Eigen::Rotation2Dd(yaw).toRotationMatrix();
}

/// Distance from a point to a rectangle about the origin with these half extents.
double
distanceToBox(const Eigen::Vector2d& point, const Eigen::Vector2d& half)
{
  return (point.cwiseAbs() - half).cwiseMax(0).norm();
}

double
distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
  const Eigen::Vector2d line = b - a;
  const double square = line.squaredNorm();
  const double t = square > 0 ? std::clamp((point - a).dot(line) / square, 0.0, 1.0) : 0.0;
  return (a + t * line - point).norm();
}

/// Whether a segment touches a rectangle about the origin: what is left of it after clipping.
bool
touches(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& half)
{
  double low = 0;
  double high = 1;
  for (int i = 0; i < 2; ++i) {
    const double d = b[i] - a[i];
    if (d == 0) {
      if (std::abs(a[i]) > half[i])
        return false;
      continue;
    }
    const double t0 = (-half[i] - a[i]) / d;
    const double t1 = (half[i] - a[i]) / d;
    low = std::max(low, std::min(t0, t1));
    high = std::min(high, std::max(t0, t1));
  }
  return low <= high;
}

} // namespace

Footprint
footprintOf(const SurfaceModel& part, const Eigen::Vector3d& foot, double yaw)
{
  const Eigen::AlignedBox3d box = boundsOf(part);
  const Eigen::Vector2d middle = box.center().head<2>();
  return {foot.head<2>() + turnOf(yaw) * middle,
          box.sizes().head<2>() / 2,
          yaw,
          foot.z() + box.min().z(),
          foot.z() + box.max().z()};
}

double
reachOf(const SurfaceModel& part)
{
  const Eigen::AlignedBox3d box = boundsOf(part);
  return box.min().head<2>().cwiseAbs().cwiseMax(box.max().head<2>().cwiseAbs()).norm();
}

bool
meet(const Footprint& a, const Footprint& b)
{
  if (a.low >= b.high || b.low >= a.high)
    return false;
  // Separating axes: the sides of either rectangle.
  const Eigen::Matrix2d turn_a = turnOf(a.yaw);
  const Eigen::Matrix2d turn_b = turnOf(b.yaw);
  const Eigen::Vector2d between = b.centre - a.centre;
  for (const Eigen::Matrix2d* axes : {&turn_a, &turn_b})
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d axis = axes->col(i);
      const double reach_a = (turn_a.transpose() * axis).cwiseAbs().dot(a.half);
      const double reach_b = (turn_b.transpose() * axis).cwiseAbs().dot(b.half);
      if (std::abs(axis.dot(between)) >= reach_a + reach_b)
        return false;
    }
  return true;
}

double
distance(const Footprint& footprint, const Eigen::Vector2d& from, const Eigen::Vector2d& to)
{
  const Eigen::Matrix2d back = turnOf(footprint.yaw).transpose();
  const Eigen::Vector2d a = back * (from - footprint.centre);
  const Eigen::Vector2d b = back * (to - footprint.centre);
  const Eigen::Vector2d& half = footprint.half;
  if (touches(a, b, half))
    return 0;
  double nearest = std::min(distanceToBox(a, half), distanceToBox(b, half));
  for (const double x : {-half.x(), half.x()})
    for (const double y : {-half.y(), half.y()})
      nearest = std::min(nearest, distanceToSegment({x, y}, a, b));
  return nearest;
}

} // namespace pcl_ssfr::simulation
