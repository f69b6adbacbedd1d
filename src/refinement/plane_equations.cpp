// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/plane_equations.h"

#include "common/vector_clones.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <array>
#include <cmath>

namespace pcl_ssfr {

namespace {

using Doubles = PlaceBlock::Doubles;
// Loops read whole groups.
static_assert(PlaceBlock::kSize % kSumGroup == 0);

/// Sum of the products of two columns.
[[gnu::always_inline]] inline double
dot(const Doubles& a, const Doubles& b, std::size_t padded)
{
  GroupSums sums{};
  for (std::size_t i = 0; i < padded; i += kSumGroup)
    for (std::size_t k = 0; k < kSumGroup; ++k)
      sums[k] += a[i + k] * b[i + k];
  return total(sums);
}

std::size_t
paddedCount(const PlaneMatches& matches)
{
  return (matches.count + kSumGroup - 1) / kSumGroup * kSumGroup;
}

} // namespace

PlaneEquations::Matrix6
aboutOrigin(const Eigen::Vector3d& centre)
{
  PlaneEquations::Matrix6 a = PlaneEquations::Matrix6::Identity();
  a.topRightCorner<3, 3>() << 0, -centre.z(), centre.y(), centre.z(), 0, -centre.x(), -centre.y(), centre.x(), 0;
  return a;
}

PlaneEquations&
PlaneEquations::operator+=(const PlaneEquations& other)
{
  hessian += other.hessian;
  gradient += other.gradient;
  weight += other.weight;
  squares += other.squares;
  matches += other.matches;
  return *this;
}

double
PlaneEquations::leverArm() const
{
  const double rotations = hessian.diagonal().head<3>().sum(), translations = hessian.diagonal().tail<3>().sum();
  return rotations > 0 && translations > 0 ? std::sqrt(rotations / translations) : 1;
}

PlaneEquations::Vector6
PlaneEquations::solve() const
{
  Vector6 units;
  units << Eigen::Vector3d::Constant(1 / leverArm()), Eigen::Vector3d::Ones();
  const Matrix6 scaled = units.asDiagonal() * fullHessian() * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(scaled);
  const Vector6 projected = solver.eigenvectors().transpose() * (units.asDiagonal() * gradient);
  Vector6 step = Vector6::Zero();
  for (int k = 0; k < 6; ++k)
    if (solver.eigenvalues()[k] > kFreeMotion * solver.eigenvalues()[5])
      step -= solver.eigenvectors().col(k) * (projected[k] / solver.eigenvalues()[k]);
  return units.asDiagonal() * step;
}

PCL_SSFR_VECTOR_CLONES void
addMatches(PlaneMatches& matches, double scale, PlaneEquations& equations)
{
  const std::size_t padded = paddedCount(matches);
  for (Doubles* column : {&matches.px,
                          &matches.py,
                          &matches.pz,
                          &matches.nx,
                          &matches.ny,
                          &matches.nz,
                          &matches.distance,
                          &matches.weight})
    for (std::size_t i = matches.count; i < padded; ++i)
      (*column)[i] = 0;

  const double square = scale * scale;
  std::array<Doubles, 3> moments; // p x n
  std::array<Doubles, 6> weighted;
  Doubles residuals; // weighted
  int near = 0;
  for (std::size_t i = 0; i < padded; ++i) {
    const double r = matches.distance[i];
    const double q = square / (square + r * r);
    const double w = matches.weight[i] * (q * q);
    matches.weight[i] = w;
    residuals[i] = w * r;
    near += static_cast<int>(w > 0);
  }
  for (std::size_t i = 0; i < padded; ++i) {
    moments[0][i] = matches.py[i] * matches.nz[i] - matches.pz[i] * matches.ny[i];
    moments[1][i] = matches.pz[i] * matches.nx[i] - matches.px[i] * matches.nz[i];
    moments[2][i] = matches.px[i] * matches.ny[i] - matches.py[i] * matches.nx[i];
  }
  const std::array<const Doubles*, 6> jacobian = {
      &moments[0], &moments[1], &moments[2], &matches.nx, &matches.ny, &matches.nz};
  for (std::size_t row = 0; row < 6; ++row) {
    const Doubles& j = *jacobian[row];
    for (std::size_t i = 0; i < padded; ++i)
      weighted[row][i] = matches.weight[i] * j[i];
  }
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column <= row; ++column)
      equations.hessian(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) +=
          dot(weighted[row], *jacobian[column], padded);
    equations.gradient[static_cast<Eigen::Index>(row)] += dot(residuals, *jacobian[row], padded);
  }
  double sum = 0;
  for (std::size_t i = 0; i < padded; ++i)
    sum += matches.weight[i];
  equations.weight += sum;
  equations.squares += dot(residuals, matches.distance, padded);
  equations.matches += near;
}

PCL_SSFR_VECTOR_CLONES void
addSpread(const PlaneMatches& matches, const MatchSpread& spread, PlaneEquations& equations)
{
  const std::size_t padded = paddedCount(matches);
  std::array<Doubles, 3> moments; // spread x n
  std::array<Doubles, 3> weighted;
  Doubles lengths; // along the normal
  for (std::size_t i = 0; i < padded; ++i) {
    // What is beyond the count has never been written.
    const bool counts = i < matches.count;
    const double x = counts ? spread.x[i] : 0;
    const double y = counts ? spread.y[i] : 0;
    const double z = counts ? spread.z[i] : 0;
    moments[0][i] = y * matches.nz[i] - z * matches.ny[i];
    moments[1][i] = z * matches.nx[i] - x * matches.nz[i];
    moments[2][i] = x * matches.ny[i] - y * matches.nx[i];
    lengths[i] = x * matches.nx[i] + y * matches.ny[i] + z * matches.nz[i];
  }
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t i = 0; i < padded; ++i)
      weighted[row][i] = matches.weight[i] * moments[row][i];
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column <= row; ++column)
      equations.hessian(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) +=
          dot(weighted[row], moments[column], padded);
    equations.gradient[static_cast<Eigen::Index>(row)] += dot(weighted[row], lengths, padded);
  }
}

PlaneEquations::Matrix6
stepMatrix(const PlaneEquations::Matrix6& hessian, const PlaneEquations::Matrix6& curvature)
{
  using Matrix6 = PlaneEquations::Matrix6;
  constexpr double kLeast = 0.5;      // steps of at most twice those of the hessian
  constexpr double kRounding = 1e-12; // of the trace: where nothing binds some motion there are factors, too
  Matrix6 whole = hessian;
  whole.diagonal().array() += kRounding * hessian.trace();
  const Eigen::LLT<Matrix6> factors(whole);
  if (factors.info() != Eigen::Success || !curvature.allFinite())
    return hessian;
  // The eigenvalues of the curvature where the hessian is the identity.
  const Matrix6 half = factors.matrixL().solve(curvature);
  const Matrix6 relative = factors.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(relative);
  const Matrix6 axes = factors.matrixL() * solver.eigenvectors();
  return axes * solver.eigenvalues().cwiseMax(kLeast).cwiseMin(1).asDiagonal() * axes.transpose();
}

EquationStatisticsSum::EquationStatisticsSum(std::size_t source_patches, std::size_t target_patches, double scale)
    : square_(scale * scale), source_patches_(source_patches), patches_(source_patches + target_patches)
{}

void
EquationStatisticsSum::add(std::size_t source_patch,
                           std::size_t target_patch,
                           const Eigen::Vector3d& p,
                           const Eigen::Vector3d& n,
                           double r,
                           double weight,
                           double share)
{
  Vector6 jacobian;
  jacobian << p.cross(n), n;
  const double q = square_ / (square_ + r * r);
  const double w = weight * q * q;
  // psi = r q^2; its derivative is q^2 (1 - 4 r^2 / (scale^2 + r^2)), and r^2 / (scale^2 + r^2) = 1 - q.
  const PlaneEquations::Matrix6 curvature = (w * (4 * q - 3)) * jacobian * jacobian.transpose();
  sums_.full_curvature += curvature;
  sums_.curvature += share * curvature;
  sums_.unit_scatter.noalias() += (w * w) * jacobian * jacobian.transpose();
  for (const std::size_t patch : {source_patch, source_patches_ + target_patch}) {
    patches_[patch].gradient += (w * r) * jacobian;
    patches_[patch].offset += w * jacobian;
  }
}

EquationStatistics
EquationStatisticsSum::statistics() const
{
  EquationStatistics total = sums_;
  for (const PatchSum& patch : patches_) {
    total.scatter.noalias() += patch.gradient * patch.gradient.transpose();
    total.unit_scatter.noalias() += patch.offset * patch.offset.transpose();
  }
  return total;
}

} // namespace pcl_ssfr
