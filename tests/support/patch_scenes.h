// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "preparation/planar_patches.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/scan_view.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <limits>
#include <vector>

// Exact planar surfaces as points and as patches, for the tests of the default profile's stages.
namespace pcl_ssfr::testing {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kMaxFloat = std::numeric_limits<float>::max();

/// centre + [-1, 1] half_u + [-1, 1] half_v; half_u and half_v are perpendicular [m].
struct Rectangle {
  Eigen::Vector3d centre, half_u, half_v;
};

/// Rectangles without symmetry: the inside of a room of 6 x 5 x 3 m around the origin, a box, a slanted board.
inline std::vector<Rectangle>
roomRectangles()
{
  using Eigen::Vector3d;
  return {{Vector3d(0, 0, -1.2), Vector3d(3, 0, 0), Vector3d(0, 2.5, 0)},
          {Vector3d(0, 0, 1.8), Vector3d(3, 0, 0), Vector3d(0, 2.5, 0)},
          {Vector3d(-3, 0, 0.3), Vector3d(0, 2.5, 0), Vector3d(0, 0, 1.5)},
          {Vector3d(3, 0.5, 0.3), Vector3d(0, 2, 0), Vector3d(0, 0, 1.5)},
          {Vector3d(0, -2.5, 0.3), Vector3d(3, 0, 0), Vector3d(0, 0, 1.5)},
          {Vector3d(-0.5, 2.5, 0.3), Vector3d(2.5, 0, 0), Vector3d(0, 0, 1.5)},
          {Vector3d(1.7, -1.6, -0.7), Vector3d(0, 0.6, 0), Vector3d(0, 0, 0.5)},
          {Vector3d(2.2, -1.0, -0.7), Vector3d(0.5, 0, 0), Vector3d(0, 0, 0.5)},
          {Vector3d(-1.7, 1.4, -0.4), Vector3d(0.5, 0.5, 0), Vector3d(0, 0, 0.8)}};
}

/// \p density random points a square metre on each rectangle, 3 x N [m].
inline Eigen::Matrix3Xf
samplePoints(const std::vector<Rectangle>& rectangles, double density, std::uint64_t seed)
{
  Random random(seed);
  std::vector<Eigen::Vector3f> drawn;
  for (const Rectangle& r : rectangles) {
    const int count = static_cast<int>(4 * r.half_u.norm() * r.half_v.norm() * density);
    for (int i = 0; i < count; ++i) {
      const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
      drawn.emplace_back((r.centre + u * r.half_u + v * r.half_v).cast<float>());
    }
  }
  Eigen::Matrix3Xf points(3, static_cast<Eigen::Index>(drawn.size()));
  for (std::size_t i = 0; i < drawn.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = drawn[i];
  return points;
}

/// Append a patch that covers a rectangle evenly; its normal is half_u x half_v, half_u the longer one.
inline void
addPatch(PlanarPatches& patches, const Rectangle& r)
{
  const Eigen::Index n = patches.size();
  OrientedSamples& samples = patches.samples;
  samples.points.conservativeResize(3, n + 1);
  samples.normals.conservativeResize(3, n + 1);
  samples.weights.conservativeResize(n + 1);
  samples.extents.conservativeResize(n + 1);
  patches.majors.conservativeResize(3, n + 1);
  patches.half_minors.conservativeResize(n + 1);
  patches.thickness.conservativeResize(n + 1);
  samples.points.col(n) = r.centre;
  samples.normals.col(n) = r.half_u.cross(r.half_v).normalized();
  samples.weights[n] = 4 * r.half_u.norm() * r.half_v.norm();
  samples.extents[n] = r.half_u.norm();
  patches.majors.col(n) = r.half_u.normalized();
  patches.half_minors[n] = r.half_v.norm();
  patches.thickness[n] = 0;
  patches.counts.push_back(0);
  patches.first_point.push_back(0);
}

/// Patches of rectangles at random places within \p size [m] of the origin, of half widths up to \p half_width [m].
inline PlanarPatches
randomPatches(int count, double size, double half_width, std::uint64_t seed)
{
  Random random(seed);
  PlanarPatches patches;
  for (int i = 0; i < count; ++i) {
    const Eigen::Matrix3d R = randomRotation(random);
    const double major = random.uniform(0.3, 1) * half_width, minor = random.uniform(0.3, 1) * major;
    const Eigen::Vector3d centre(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
    addPatch(patches, {centre, major * R.col(0), minor * R.col(1)});
  }
  return patches;
}

} // namespace pcl_ssfr::testing
