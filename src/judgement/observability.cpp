// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/observability.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ssfr {

namespace {

/// Eigenvectors of a 3 x 3 block of information whose eigenvalue is below \p min_strength of the largest.
void
addWeakDirections(const Eigen::Matrix3d& information,
                  bool rotation,
                  double min_strength,
                  std::vector<UnobservableDirection>& weak)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  const double largest = solver.eigenvalues()[2];
  if (!(largest > 0))
    return;
  for (int k = 0; k < 3; ++k) {
    const double strength = std::max(0.0, solver.eigenvalues()[k] / largest);
    if (strength < min_strength)
      weak.push_back({solver.eigenvectors().col(k), rotation, strength});
  }
}

} // namespace

std::vector<UnobservableDirection>
findUnobservableDirections(const Refinement& refinement, const ObservabilityOptions& options)
{
  std::vector<UnobservableDirection> weak;
  if (refinement.matches == 0)
    return weak;
  addWeakDirections(refinement.hessian.bottomRightCorner<3, 3>(), false, options.min_translation, weak);
  addWeakDirections(refinement.hessian.topLeftCorner<3, 3>(), true, options.min_rotation, weak);
  return weak;
}

Eigen::Matrix<double, 6, 6>
informationMatrix(const Refinement& refinement,
                  const Eigen::Vector3d& origin,
                  double noise_floor,
                  double samples_per_patch)
{
  // J about the target's origin is A J about the centre of the refinement: (p + o) x n = p x n + o x n.
  const Eigen::Vector3d o = origin + refinement.centre;
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity();
  A.topRightCorner<3, 3>() << 0, -o.z(), o.y(), o.z(), 0, -o.x(), -o.y(), o.x(), 0;
  const double variance = std::max(refinement.rms * refinement.rms, noise_floor * noise_floor);
  const Eigen::Matrix<double, 6, 6> information =
      A * refinement.hessian * A.transpose() / (variance * samples_per_patch);
  return 0.5 * (information + information.transpose());
}

RotationDeviation
largestRotationDeviation(const Refinement& refinement,
                         double noise_floor,
                         double samples_per_patch,
                         const Eigen::Matrix3d& prior)
{
  RotationDeviation largest;
  largest.deviation = std::numeric_limits<double>::infinity();
  // About the centre of the matches, where the numbers are small.
  const Eigen::Matrix<double, 6, 6> information =
      informationMatrix(refinement, -refinement.centre, noise_floor, samples_per_patch);
  if (!information.allFinite())
    return largest;
  // What is left of the rotation's information when the place is free (the Schur complement).
  const Eigen::Matrix3d coupling = information.topRightCorner<3, 3>();
  const Eigen::Matrix3d rotation =
      prior + information.topLeftCorner<3, 3>() -
      coupling * information.bottomRightCorner<3, 3>().completeOrthogonalDecomposition().solve(coupling.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (rotation + rotation.transpose()));
  largest.axis = solver.eigenvectors().col(0);
  // Rounding leaves some information where there is none.
  if (solver.eigenvalues()[0] > 1e-12 * (prior + information.topLeftCorner<3, 3>()).trace()) {
    largest.deviation = 1 / std::sqrt(solver.eigenvalues()[0]);
    largest.strength = solver.eigenvalues()[0] / solver.eigenvalues()[2];
  }
  return largest;
}

std::vector<MotionStrength>
rankMotions(const Refinement& refinement)
{
  const double lever_square =
      refinement.hessian.topLeftCorner<3, 3>().trace() / refinement.hessian.bottomRightCorner<3, 3>().trace();
  if (refinement.matches == 0 || !(lever_square > 0) || !refinement.hessian.allFinite())
    return {};
  SmallMotion unit; // of each coordinate: moves the matched surface by 1 m
  unit << Eigen::Vector3d::Constant(1 / std::sqrt(lever_square)), Eigen::Vector3d::Ones();
  const Eigen::Matrix<double, 6, 6> scaled = unit.asDiagonal() * refinement.hessian * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(0.5 * (scaled + scaled.transpose()));
  std::vector<MotionStrength> motions;
  motions.reserve(6);
  for (int k = 0; k < 6; ++k)
    motions.push_back({unit.cwiseProduct(solver.eigenvectors().col(k)),
                       std::max(0.0, solver.eigenvalues()[k] / solver.eigenvalues()[5])});
  return motions;
}

} // namespace pcl_ssfr
