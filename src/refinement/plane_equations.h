// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/place_block.h"

#include <Eigen/Core>

#include <cstddef>

namespace pcl_ssfr {

/// Normal equations of the robust plane distances, about a fixed centre: J = [p x n; n].
struct PlaneEquations {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  Matrix6 hessian = Matrix6::Zero(); ///< only its lower triangle until solve()
  Vector6 gradient = Vector6::Zero();
  double weight = 0;
  double squares = 0;
  Eigen::Index matches = 0;

  PlaneEquations&
  operator+=(const PlaneEquations& other);

  /// The whole of the symmetric matrix.
  Matrix6
  fullHessian() const
  {
    return hessian.selfadjointView<Eigen::Lower>();
  }

  /// The step that solves the equations in the motions that they determine; others are left as they are. Rotations
  /// [rad] count like motions of a lever of \p lever_arm [m].
  Vector6
  solve(double lever_arm) const;
};

/// Places that met planes: at most as many as a PlaceBlock holds.
struct PlaneMatches {
  using Doubles = PlaceBlock::Doubles;

  Doubles px, py, pz; ///< place relative to the centre [m]
  Doubles nx, ny, nz; ///< normal of the plane
  Doubles distance;   ///< to the plane, along its normal [m]
  Doubles weight;     ///< before the robust one
  std::size_t count = 0;

  void
  add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, double r, double w)
  {
    px[count] = p.x();
    py[count] = p.y();
    pz[count] = p.z();
    nx[count] = n.x();
    ny[count] = n.y();
    nz[count] = n.z();
    distance[count] = r;
    weight[count] = w;
    ++count;
  }
};

/// Half of the surface around each match, to both sides of its place (one standard deviation): it binds the rotation.
struct MatchSpread {
  using Doubles = PlaceBlock::Doubles;
  Doubles x, y, z; ///< [m]

  void
  set(std::size_t match, const Eigen::Vector3d& extent)
  {
    x[match] = extent.x();
    y[match] = extent.y();
    z[match] = extent.z();
  }
};

/** \brief Weigh the matches by Geman-McClure's function at \p scale [m], leave out those not nearer than \p most [m],
 * and add them to the equations. The weights of \p matches become the robust ones.
 */
void
addMatches(PlaneMatches& matches, double scale, double most, PlaneEquations& equations);

/// After addMatches(): the surface around the matches.
void
addSpread(const PlaneMatches& matches, const MatchSpread& spread, PlaneEquations& equations);

} // namespace pcl_ssfr
