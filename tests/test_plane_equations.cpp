// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/plane_equations.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

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

} // namespace
} // namespace pcl_ssfr::test_plane_equations
