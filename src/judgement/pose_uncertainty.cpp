// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/pose_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ssfr {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Matrix6
symmetric(const Matrix6& m)
{
  return 0.5 * (m + m.transpose());
}

double
deviationOf(double information, double largest)
{
  return information > kRoundingOfSums * largest ? 1 / std::sqrt(information) : kInfinite;
}

/// Units of motions [rad] and [m] in which a step of 1 moves the matched surface by 1 m; zero when there is none.
Vector6
surfaceUnits(const Refinement& polish)
{
  const double rotation = polish.hessian.topLeftCorner<3, 3>().trace();
  const double translation = polish.hessian.bottomRightCorner<3, 3>().trace();
  Vector6 units = Vector6::Zero();
  if (polish.matches > 0 && polish.hessian.allFinite() && rotation > 0 && translation > 0)
    units << Eigen::Vector3d::Constant(std::sqrt(translation / rotation)), Eigen::Vector3d::Ones();
  return units;
}

/// A B^-1 A in the motions that A determines, zero in the others: both in units in which motions compare.
Matrix6
sandwichInformation(const Matrix6& a, const Matrix6& b)
{
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(a);
  const Vector6& values = solver.eigenvalues();
  if (!(values[5] > 0))
    return Matrix6::Zero();
  const Eigen::Index determined = (values.array() > kFreeMotion * values[5]).count();
  const Eigen::MatrixXd basis = solver.eigenvectors().rightCols(determined);
  const Eigen::MatrixXd scatter = basis.transpose() * b * basis;
  const Eigen::MatrixXd lambda = values.tail(determined).asDiagonal();
  return symmetric(basis * lambda * scatter.ldlt().solve(lambda * basis.transpose()));
}

std::vector<PrincipalTranslation>
principalTranslations(const Eigen::Matrix3d& information)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  const double most = solver.eigenvalues()[2];
  std::vector<PrincipalTranslation> translations;
  translations.reserve(3);
  for (int k = 0; k < 3; ++k)
    translations.push_back(
        {solver.eigenvectors().col(k), most > 0 ? std::max(0.0, solver.eigenvalues()[k] / most) : 0.0});
  return translations;
}

std::vector<PrincipalRotation>
principalRotations(const Matrix6& information)
{
  // What is left of the rotation's information when the translation is free (the Schur complement).
  const Eigen::Matrix3d coupling = information.topRightCorner<3, 3>();
  const Eigen::Matrix3d rotation =
      information.topLeftCorner<3, 3>() -
      coupling * information.bottomRightCorner<3, 3>().completeOrthogonalDecomposition().solve(coupling.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (rotation + rotation.transpose()));
  // Rounding leaves some information where there is none.
  const double most = information.topLeftCorner<3, 3>().trace();
  std::vector<PrincipalRotation> rotations;
  rotations.reserve(3);
  for (int k = 0; k < 3; ++k) {
    const double deviation = deviationOf(solver.eigenvalues()[k], most);
    rotations.push_back({solver.eigenvectors().col(k),
                         deviation,
                         std::isinf(deviation) ? 0 : solver.eigenvalues()[k] / solver.eigenvalues()[2]});
  }
  return rotations;
}

} // namespace

double
PoseUncertainty::largestRotationDeviation() const
{
  return rotations.empty() ? kInfinite : rotations.front().deviation;
}

Matrix6
PoseUncertainty::informationAbout(const Eigen::Vector3d& origin) const
{
  const Matrix6 a = aboutOrigin(centre - origin);
  return symmetric(a * information * a.transpose());
}

double
noiseFloor(const UncertaintyConfig& config, double rms)
{
  return std::hypot(config.noise_floor, config.patch_noise * rms);
}

PoseUncertainty
poseUncertainty(const Refinement& polish,
                double noise_floor,
                const Eigen::Matrix3d& rotation_prior,
                bool sensors_coincide)
{
  PoseUncertainty result;
  result.centre = polish.centre;
  const Vector6 units = surfaceUnits(polish);
  if (!(units[0] > 0))
    return result;
  const auto scaled = [&](const Matrix6& m) { return Matrix6(units.asDiagonal() * m * units.asDiagonal()); };
  Matrix6 information = sandwichInformation(
      scaled(polish.statistics.curvature),
      scaled(polish.statistics.scatter + noise_floor * noise_floor * polish.statistics.unit_scatter));
  information.topLeftCorner<3, 3>() += units[0] * units[0] * rotation_prior;
  if (!information.allFinite())
    return result;
  const Vector6 inverse = units.cwiseInverse();
  result.information = inverse.asDiagonal() * information * inverse.asDiagonal();
  const Matrix6& held = sensors_coincide ? polish.statistics.curvature : polish.hessian;
  result.translations = principalTranslations(held.bottomRightCorner<3, 3>());
  result.rotations = principalRotations(result.information);
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(information);
  for (int k = 0; k < 6; ++k)
    result.motions.push_back({units.cwiseProduct(solver.eigenvectors().col(k)),
                              deviationOf(solver.eigenvalues()[k], solver.eigenvalues()[5])});
  return result;
}

std::vector<UnobservableDirection>
unobservableDirections(const PoseUncertainty& uncertainty, const UncertaintyConfig& config)
{
  std::vector<UnobservableDirection> open;
  for (const PrincipalTranslation& t : uncertainty.translations)
    if (t.strength < config.min_translation)
      open.push_back({t.direction, false, t.strength});
  for (const PrincipalRotation& r : uncertainty.rotations)
    if (r.deviation > config.max_rotation)
      open.push_back({r.axis, true, r.strength});
  return open;
}

std::vector<PrincipalMotion>
motionsToExplore(const PoseUncertainty& uncertainty, double deviation)
{
  std::vector<PrincipalMotion> motions;
  for (const PrincipalMotion& m : uncertainty.motions)
    if (m.deviation > deviation)
      motions.push_back(m);
  return motions;
}

} // namespace pcl_ssfr
