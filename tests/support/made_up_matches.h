// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "refinement/refinement.h"
#include "synthetic_scene.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

// Refinements as they end with given matches, for the tests of what is said of a pose.
namespace pcl_ssfr::testing {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Places with the normal of the plane that each lies on.
struct Matches {
  Points3 points, normals;
};

/// \p count places on planes of each of the normals, spread over 10 m around \p middle.
inline Matches
matchesOn(const std::vector<Eigen::Vector3d>& normals, int count, const Eigen::Vector3d& middle, std::uint64_t seed)
{
  Random random(seed);
  Matches m;
  const auto total = static_cast<Eigen::Index>(normals.size()) * count;
  m.points.resize(3, total);
  m.normals.resize(3, total);
  for (Eigen::Index i = 0; i < total; ++i) {
    m.points.col(i) = middle + Eigen::Vector3d(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5));
    m.normals.col(i) = normals[static_cast<std::size_t>(i / count)].normalized();
  }
  return m;
}

/// Sum of J J^T, J = [p x n; n], p relative to \p centre.
inline Matrix6
hessianAbout(const Matches& m, const Eigen::Vector3d& centre)
{
  Matrix6 hessian = Matrix6::Zero();
  for (Eigen::Index i = 0; i < m.points.cols(); ++i) {
    Vector6 j;
    j << (m.points.col(i) - centre).cross(m.normals.col(i)), m.normals.col(i);
    hessian += j * j.transpose();
  }
  return hessian;
}

/// Each match is on patches of its own, and its distance errs by \p deviation [m].
inline Refinement
refinementOf(const Matches& m, const Eigen::Vector3d& centre, double deviation = 0.01)
{
  Refinement r;
  r.hessian = hessianAbout(m, centre);
  r.centre = centre;
  r.matches = m.points.cols();
  r.rms = deviation;
  r.statistics.curvature = r.statistics.unit_scatter = r.hessian;
  r.statistics.scatter = deviation * deviation * r.hessian;
  return r;
}

inline Refinement
refinementOf(const Matches& m, double deviation = 0.01)
{
  return refinementOf(m, m.points.rowwise().mean(), deviation);
}

} // namespace pcl_ssfr::testing
