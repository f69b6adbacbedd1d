// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/plane_equations.h"
#include "synthetic_scene.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace pcl_ssfr::test_plane_equations {
namespace {

using Matrix6 = PlaneEquations::Matrix6;
using Vector6 = PlaneEquations::Vector6;

Eigen::Vector3d
randomVector(testing::Random& random, double size)
{
  return size * Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
}

/// Matches and what is around them.
struct Scene {
  PlaneMatches matches;
  MatchSpread spread;
};

/// \p count matches.
std::unique_ptr<Scene>
randomScene(std::size_t count, std::uint64_t seed)
{
  testing::Random random(seed);
  auto scene = std::make_unique<Scene>();
  for (std::size_t i = 0; i < count; ++i) {
    scene->spread.set(i, randomVector(random, 0.5));
    const double distance = (i % 2 ? 0.05 : 0.2) * (i % 3 ? 1 : -1);
    scene->matches.add(
        randomVector(random, 4), randomVector(random, 1).normalized(), distance, 1 + random.gaussian() * 0.1);
  }
  return scene;
}

/// What the equations say of themselves, match by match.
PlaneEquations
byDefinition(const Scene& scene, double scale, bool with_spread)
{
  PlaneEquations sum;
  for (std::size_t i = 0; i < scene.matches.count; ++i) {
    const PlaneMatches& m = scene.matches;
    const Eigen::Vector3d n(m.nx[i], m.ny[i], m.nz[i]);
    const double r = m.distance[i];
    const double w = m.weight[i] * std::pow(scale * scale / (scale * scale + r * r), 2);
    Vector6 j;
    j << Eigen::Vector3d(m.px[i], m.py[i], m.pz[i]).cross(n), n;
    sum.hessian += w * j * j.transpose();
    sum.gradient += w * r * j;
    sum.weight += w;
    sum.squares += w * r * r;
    ++sum.matches;
    if (!with_spread)
      continue;
    // Two places, one standard deviation to each side, of half the weight each.
    const Eigen::Vector3d extent(scene.spread.x[i], scene.spread.y[i], scene.spread.z[i]);
    const Eigen::Vector3d turn = extent.cross(n);
    sum.hessian.topLeftCorner<3, 3>() += w * turn * turn.transpose();
    sum.gradient.head<3>() += w * extent.dot(n) * turn;
  }
  return sum;
}

void
expectSame(const PlaneEquations& a, const PlaneEquations& b)
{
  EXPECT_TRUE(a.fullHessian().isApprox(b.fullHessian(), 1e-12)) << a.fullHessian() - b.fullHessian();
  EXPECT_LT((a.gradient - b.gradient).norm(), 1e-12 * (1 + b.gradient.norm()));
  EXPECT_NEAR(a.weight, b.weight, 1e-12 * (1 + b.weight));
  EXPECT_NEAR(a.squares, b.squares, 1e-12 * (1 + b.squares));
  EXPECT_EQ(a.matches, b.matches);
}

TEST(PlaneEquations, MomentsAboutAnotherOrigin)
{
  testing::Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d p = randomVector(random, 4);
    const Eigen::Vector3d n = randomVector(random, 1).normalized();
    const Eigen::Vector3d centre = randomVector(random, 10);
    Vector6 about_centre, about_origin;
    about_centre << p.cross(n), n;
    about_origin << (p + centre).cross(n), n;
    EXPECT_TRUE((aboutOrigin(centre) * about_centre).isApprox(about_origin, 1e-12)) << trial;
  }
  EXPECT_EQ(aboutOrigin(Eigen::Vector3d::Zero()), Matrix6(Matrix6::Identity()));
}

TEST(PlaneEquations, AreThoseOfTheirMatches)
{
  for (const std::size_t count : {1, 7, 8, 9, 100, 256})
    for (const bool with_spread : {false, true}) {
      const std::unique_ptr<Scene> scene = randomScene(count, count);
      const PlaneEquations expected = byDefinition(*scene, 0.15, with_spread);
      PlaneEquations equations;
      addMatches(scene->matches, 0.15, equations);
      if (with_spread)
        addSpread(scene->matches, scene->spread, equations);
      SCOPED_TRACE(count);
      expectSame(equations, expected);
    }
}

TEST(PlaneEquations, OfNothing)
{
  const std::unique_ptr<Scene> scene = randomScene(0, 1);
  PlaneEquations equations;
  addMatches(scene->matches, 0.1, equations);
  addSpread(scene->matches, scene->spread, equations);
  expectSame(equations, PlaneEquations());
  EXPECT_EQ(equations.solve(), Vector6::Zero());
}

TEST(PlaneEquations, AddUp)
{
  const std::unique_ptr<Scene> one = randomScene(30, 1), two = randomScene(50, 2);
  PlaneEquations first, second, both;
  addMatches(one->matches, 0.1, first);
  addMatches(two->matches, 0.1, second);
  const std::unique_ptr<Scene> one_again = randomScene(30, 1), two_again = randomScene(50, 2);
  addMatches(one_again->matches, 0.1, both);
  addMatches(two_again->matches, 0.1, both);
  expectSame(first += second, both);
}

TEST(PlaneEquations, SolveFindsTheMotionThatWasMade)
{
  // Distances that a small motion makes.
  testing::Random random(4);
  Vector6 motion;
  motion << 0.001, -0.002, 0.0005, 0.01, -0.02, 0.03;
  PlaneMatches matches;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p = randomVector(random, 4);
    const Eigen::Vector3d n = randomVector(random, 1).normalized();
    matches.add(p, n, -n.dot(motion.head<3>().cross(p) + motion.tail<3>()), 1);
  }
  PlaneEquations equations;
  addMatches(matches, 1e6, equations);
  EXPECT_LT((equations.solve() - motion).norm(), 1e-9);
}

TEST(PlaneEquations, SolveLeavesWhatNothingBinds)
{
  // Planes across x alone: they bind the place along x and the turns about y and z.
  testing::Random random(5);
  PlaneMatches matches;
  for (int i = 0; i < 100; ++i)
    matches.add(randomVector(random, 4), Eigen::Vector3d::UnitX(), 0.1, 1);
  PlaneEquations equations;
  addMatches(matches, 1e6, equations);
  const Vector6 step = equations.solve();
  EXPECT_NEAR(step[3], -0.1, 1e-9);
  EXPECT_EQ((step.array().abs() < 1e-9).count(), 5) << step.transpose();
}

TEST(PlaneEquations, TheLeverArmIsWhereRotationsMoveAsMuchAsTranslations)
{
  EXPECT_EQ(PlaneEquations().leverArm(), 1);
  // Planes whose normals are across the arm of 4 m.
  testing::Random random(6);
  PlaneMatches matches;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p = 4 * randomVector(random, 1).normalized();
    matches.add(p, p.unitOrthogonal(), 0, 1);
  }
  PlaneEquations equations;
  addMatches(matches, 1, equations);
  EXPECT_NEAR(equations.leverArm(), 4, 1e-9);
}

/// Whether no eigenvalue of the symmetric matrix is below zero, but for rounding.
bool
isSemidefinite(const Matrix6& m, double largest)
{
  return Eigen::SelfAdjointEigenSolver<Matrix6>(m).eigenvalues().minCoeff() > -1e-7 * largest;
}

/// Robust distances that change with a small motion as J^T motion.
struct RobustFit {
  Eigen::Matrix<double, 6, 40> jacobians;
  Eigen::Matrix<double, 40, 1> distances;
  double scale = 0.05;
  Matrix6 hessian = Matrix6::Zero(), curvature = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();

  RobustFit(std::uint64_t seed, double noise)
  {
    testing::Random random(seed);
    for (Eigen::Index i = 0; i < distances.size(); ++i) {
      const Eigen::Vector3d n = randomVector(random, 1).normalized();
      jacobians.col(i) << randomVector(random, 4).cross(n), n;
      distances[i] = noise * random.gaussian();
      const double q = scale * scale / (scale * scale + distances[i] * distances[i]);
      const Matrix6 square = jacobians.col(i) * jacobians.col(i).transpose();
      hessian += q * q * square;
      curvature += q * q * (4 * q - 3) * square;
      gradient += q * q * distances[i] * jacobians.col(i);
    }
  }

  /// What the robust weights sum: the integral of r q^2, q = scale^2 / (scale^2 + r^2).
  double
  sum(const Vector6& motion) const
  {
    const auto squares = (distances + jacobians.transpose() * motion).array().square();
    return (squares / (2 * (scale * scale + squares))).sum() * scale * scale;
  }
};

TEST(StepMatrix, LiesBetweenHalfOfTheHessianAndAllOfIt)
{
  for (const double noise : {0.0, 0.02, 0.05, 0.1}) {
    const RobustFit fit(3, noise);
    const Matrix6 matrix = stepMatrix(fit.hessian, fit.curvature);
    const double largest = fit.hessian.trace();
    EXPECT_TRUE(matrix.isApprox(matrix.transpose(), 1e-12)) << noise;
    EXPECT_TRUE(isSemidefinite(matrix - 0.5 * fit.hessian, largest)) << noise;
    EXPECT_TRUE(isSemidefinite(fit.hessian - matrix, largest)) << noise;
    EXPECT_TRUE(stepMatrix(fit.hessian, 0.8 * fit.hessian).isApprox(0.8 * fit.hessian, 1e-6));
    EXPECT_TRUE(stepMatrix(fit.hessian, -fit.hessian).isApprox(0.5 * fit.hessian, 1e-6));
    EXPECT_TRUE(stepMatrix(fit.hessian, 2 * fit.hessian).isApprox(fit.hessian, 1e-6));
  }
  const RobustFit fit(4, 0.01); // its curvature is larger than half of the hessian, and smaller than all
  EXPECT_TRUE(stepMatrix(fit.hessian, fit.curvature).isApprox(fit.curvature, 1e-6));
}

TEST(StepMatrix, StepsDoNotRaiseTheSum)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const RobustFit fit(seed, 0.02 + 0.0005 * static_cast<double>(seed));
    const Vector6 step = -stepMatrix(fit.hessian, fit.curvature).ldlt().solve(fit.gradient);
    EXPECT_LE(fit.sum(step), fit.sum(Vector6::Zero()) * (1 + 1e-12)) << seed;
  }
}

TEST(StepMatrix, OfWhatBindsNothing)
{
  EXPECT_EQ(stepMatrix(Matrix6::Zero(), Matrix6::Zero()), Matrix6(Matrix6::Zero()));
  testing::Random random(6);
  for (int motions = 1; motions < 6; ++motions) { // that are bound, the others are not
    Matrix6 hessian = Matrix6::Zero();
    for (int k = 0; k < motions; ++k) {
      Vector6 jacobian;
      jacobian << randomVector(random, 4), randomVector(random, 1);
      hessian += 100 * jacobian * jacobian.transpose();
    }
    for (const double share : {-1.0, 0.1, 0.7}) {
      const Matrix6 matrix = stepMatrix(hessian, share * hessian);
      EXPECT_TRUE(matrix.isApprox(std::max(0.5, share) * hessian, 1e-6)) << motions << ", " << share;
    }
  }
  const RobustFit fit(5, 0.02);
  EXPECT_EQ(stepMatrix(fit.hessian, Matrix6::Constant(std::numeric_limits<double>::quiet_NaN())), fit.hessian);
}

} // namespace
} // namespace pcl_ssfr::test_plane_equations
