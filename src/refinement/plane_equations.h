// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/place_block.h"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <vector>

namespace pcl_ssfr {

/// Motions with less than this share of the largest eigenvalue of their equations are left free: rounding alone gives
/// some.
constexpr double kFreeMotion = 1e-6;

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

  /// Weighted root mean square plane distance [m]; 0 without matches.
  double
  rms() const
  {
    return weight > 0 ? std::sqrt(squares / weight) : 0;
  }

  /// Where matches feel rotations [rad] as much as translations [m]: their root mean square arm [m]; 1 without any.
  double
  leverArm() const;

  /// The step that solves the equations in the motions that they determine; others are left as they are. Rotations
  /// count like motions of the lever arm.
  Vector6
  solve() const;
};

/// The matrix A that takes J about a centre to J about the origin, from which the centre lies at \p centre [m]: A J is
/// [(p + centre) x n; n], so what was sum J J^T becomes A (sum J J^T) A^T.
PlaneEquations::Matrix6
aboutOrigin(const Eigen::Vector3d& centre);

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

/** \brief Weigh the matches by Geman-McClure's function at \p scale [m] and add them to the equations. The weights of
 * \p matches become the robust ones.
 */
void
addMatches(PlaneMatches& matches, double scale, PlaneEquations& equations);

/// After addMatches(): the surface around the matches.
void
addSpread(const PlaneMatches& matches, const MatchSpread& spread, PlaneEquations& equations);

/** \brief How plane distances that are weighed as by addMatches() react to a small motion, and by how much what they
 * say of it scatters from patch to patch: what the covariance of the pose needs (pose_uncertainty.h).
 */
struct EquationStatistics {
  using Matrix6 = PlaneEquations::Matrix6;

  /// Derivative of the gradient: sum of weight psi'(r) J J^T, psi being the robust function that addMatches() sums.
  /// Matches at the far end of psi count against it. May have negative eigenvalues where they determine nothing.
  Matrix6 full_curvature = Matrix6::Zero();
  /// The same with the share that each match keeps where it is found again wherever the pose is.
  Matrix6 curvature = Matrix6::Zero();
  /// Sum over the patches of both scans of s s^T, where s is what the matches of one patch add to the gradient
  /// (units of the gradient, squared). Points on a patch err alike, patches err independently.
  Matrix6 scatter = Matrix6::Zero();
  /// What the scatter would be if each patch and each match had an independent error of distance of 1 m.
  Matrix6 unit_scatter = Matrix6::Zero();
};

/** \brief The matrix of the steps of a robust fit: its curvature, but not less than half of the reweighted hessian.
 *
 * For the matches as they are, the hessian of iteratively reweighted least squares majorises the sum of the robust
 * function (Hunter and Lange, A Tutorial on MM Algorithms, The American Statistician 58(1), 2004), so steps of up to
 * twice its own do not raise that sum. Along motions in which matches at the far end of the function leave little
 * curvature the reweighted steps are too short by the ratio of both, and a fit along them takes many.
 * \param[in] hessian positive semidefinite
 * \param[in] curvature symmetric, EquationStatistics::full_curvature
 * \return between half of the hessian and all of it; the hessian, where one of both is not finite or it is zero
 */
PlaneEquations::Matrix6
stepMatrix(const PlaneEquations::Matrix6& hessian, const PlaneEquations::Matrix6& curvature);

/// What the matches of one patch add to the gradient: they err together.
struct PatchSum {
  PlaneEquations::Vector6 gradient = PlaneEquations::Vector6::Zero();
  PlaneEquations::Vector6 offset = PlaneEquations::Vector6::Zero(); ///< gradient of an offset of the patch by 1 m
};

/// Collects the statistics of matches between patches of two scans.
class EquationStatisticsSum {
public:
  /// \param[in] scale of the robust function [m]
  EquationStatisticsSum(std::size_t source_patches, std::size_t target_patches, double scale);

  /** \brief Add a match.
   * \param[in] source_patch patch of the source that it involves: of the place, or the plane
   * \param[in] target_patch the same of the target
   * \param[in] p place relative to the centre [m]
   * \param[in] n unit normal of the plane
   * \param[in] r distance along it [m]
   * \param[in] weight before the robust one
   * \param[in] share of its curvature that it keeps, [0, 1]; it scatters all the same
   */
  void
  add(std::size_t source_patch,
      std::size_t target_patch,
      const Eigen::Vector3d& p,
      const Eigen::Vector3d& n,
      double r,
      double weight,
      double share);

  EquationStatistics
  statistics() const;

  /// Of each patch of the source, then of the target.
  const std::vector<PatchSum>&
  patches() const
  {
    return patches_;
  }

private:
  using Vector6 = PlaneEquations::Vector6;

  double square_; ///< of the scale [m^2]
  std::size_t source_patches_;
  std::vector<PatchSum> patches_; ///< of the source, then of the target
  EquationStatistics sums_;       ///< of single matches
};

} // namespace pcl_ssfr
