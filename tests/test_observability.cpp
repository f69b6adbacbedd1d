// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/observability.h"
#include "made_up_matches.h"
#include "patch_scenes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr {
namespace {

using testing::hessianAbout;
using testing::Matches;
using testing::matchesOn;
using testing::Matrix6;
using testing::refinementOf;

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(), kZ = Eigen::Vector3d::UnitZ();

TEST(UnobservableDirections, NoneInARoom)
{
  EXPECT_TRUE(findUnobservableDirections(refinementOf(matchesOn({kX, kY, kZ}, 50, kX, 1))).empty());
}

TEST(UnobservableDirections, AlongTheCorridor)
{
  const auto weak = findUnobservableDirections(refinementOf(matchesOn({kY, kZ}, 50, kX, 2)));
  ASSERT_EQ(weak.size(), 1U);
  EXPECT_FALSE(weak[0].rotation);
  EXPECT_NEAR(std::abs(weak[0].direction.x()), 1, 1e-9);
  EXPECT_NEAR(weak[0].strength, 0, 1e-9);
}

TEST(UnobservableDirections, OnOnePlane)
{
  const auto weak = findUnobservableDirections(refinementOf(matchesOn({kZ}, 50, kX, 3)));
  ASSERT_EQ(weak.size(), 3U); // two shifts within it and the turn about its normal
  for (const UnobservableDirection& u : weak) {
    EXPECT_NEAR(u.direction.norm(), 1, 1e-9);
    EXPECT_NEAR(std::abs(u.direction.z()), u.rotation ? 1 : 0, 1e-9);
  }
  EXPECT_TRUE(weak[2].rotation);
}

TEST(UnobservableDirections, WeaknessIsRelative)
{
  Matches m = matchesOn({kY, kZ}, 500, kX, 4);
  m.normals.col(0) = kX; // one of 1000 matches faces x
  const Refinement refinement = refinementOf(m);
  ObservabilityOptions options;
  options.min_translation = 0.0019;
  EXPECT_TRUE(findUnobservableDirections(refinement, options).empty());
  options.min_translation = 0.0021;
  const auto weak = findUnobservableDirections(refinement, options);
  ASSERT_EQ(weak.size(), 1U);
  EXPECT_NEAR(weak[0].strength, 1.0 / 500, 1e-4);
  // The amount of information does not matter.
  Refinement scaled = refinement;
  scaled.hessian *= 1e-9;
  EXPECT_EQ(findUnobservableDirections(scaled, options).size(), 1U);
}

TEST(UnobservableDirections, ShiftsAndTurnsHaveBoundsOfTheirOwn)
{
  // Half a hundredth of what tells the others: too little for a shift; enough for a turn, whose levers may be short.
  Refinement refinement;
  refinement.matches = 100;
  refinement.hessian = (Matrix6::Identity()).eval();
  refinement.hessian(1, 1) = refinement.hessian(4, 4) = 0.0045;
  const auto weak = findUnobservableDirections(refinement);
  ASSERT_EQ(weak.size(), 1U);
  EXPECT_FALSE(weak[0].rotation);
  EXPECT_NEAR(std::abs(weak[0].direction.y()), 1, 1e-9);
  refinement.hessian(1, 1) = 0.0025;
  EXPECT_EQ(findUnobservableDirections(refinement).size(), 2U);
}

TEST(UnobservableDirections, TurnWithTheScene)
{
  testing::Random random(5);
  const Matches m = matchesOn({kY, kZ}, 80, kX, 6);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 100);
    const auto weak = findUnobservableDirections(refinementOf({T * m.points, T.linear() * m.normals}));
    ASSERT_EQ(weak.size(), 1U);
    EXPECT_NEAR(std::abs(weak[0].direction.dot(T.linear() * kX)), 1, 1e-6);
  }
}

TEST(UnobservableDirections, NothingKnown)
{
  EXPECT_TRUE(findUnobservableDirections(Refinement()).empty());
  Refinement r;
  r.matches = 5; // and no information at all
  EXPECT_TRUE(findUnobservableDirections(r).empty());
}

TEST(InformationMatrix, AgreesWithTheSumAboutTheOrigin)
{
  testing::Random random(7);
  for (int trial = 0; trial < 10; ++trial) {
    // The refinement ran in a frame whose origin lies at \p origin of the target's frame.
    const Eigen::Vector3d origin(random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-50, 50));
    const Matches m = matchesOn({kX, kY + kZ, kZ - 0.3 * kX}, 40, Eigen::Vector3d(3, -2, 1), 8);
    Refinement refinement = refinementOf(m);
    refinement.rms = 0.02;
    Matches in_target = m;
    in_target.points.colwise() += origin;
    const Matrix6 expected = hessianAbout(in_target, Eigen::Vector3d::Zero()) / (0.02 * 0.02 * 5);
    const Matrix6 information = informationMatrix(refinement, origin, 0.001, 5);
    EXPECT_LT((information - expected).norm(), 1e-9 * expected.norm());
    EXPECT_TRUE(information == information.transpose());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(information).eigenvalues()[0], 0);
  }
}

TEST(InformationMatrix, DoesNotDependOnTheCentreNorOnTheFrameOfTheRefinement)
{
  const Matches m = matchesOn({kX, kY, kZ}, 40, Eigen::Vector3d(3, -2, 1), 9);
  Refinement a = refinementOf(m, Eigen::Vector3d(3, -2, 1)), b = refinementOf(m, Eigen::Vector3d(-7, 20, 4));
  a.rms = b.rms = 0.01;
  const Eigen::Vector3d origin(10, 20, 30), shift(4, -5, 6);
  const Matrix6 information = informationMatrix(a, origin, 0, 1);
  EXPECT_TRUE(information.isApprox(informationMatrix(b, origin, 0, 1), 1e-9));
  Matches moved = m; // the same places in a frame that lies elsewhere
  moved.points.colwise() -= shift;
  Refinement c = refinementOf(moved);
  c.rms = 0.01;
  EXPECT_TRUE(information.isApprox(informationMatrix(c, origin + shift, 0, 1), 1e-9));
  // Another origin of the target's frame: the adjoint of the shift.
  Matrix6 adjoint = Matrix6::Identity();
  for (int k = 0; k < 3; ++k)
    adjoint.topRightCorner<3, 3>().col(k) = shift.cross(Eigen::Vector3d::Unit(k));
  EXPECT_TRUE(informationMatrix(a, origin + shift, 0, 1).isApprox(adjoint * information * adjoint.transpose(), 1e-9));
}

TEST(InformationMatrix, NoiseFloorBoundsIt)
{
  Refinement r = refinementOf(matchesOn({kX, kY, kZ}, 4, kX, 10));
  r.rms = 0; // an exact fit
  const Matrix6 information = informationMatrix(r, Eigen::Vector3d::Zero(), 0.01, 1);
  EXPECT_NEAR(information.bottomRightCorner(3, 3).trace(), 12 / 1e-4, 1e-6);
  r.rms = 0.02;
  EXPECT_TRUE(information.isApprox(4 * informationMatrix(r, Eigen::Vector3d::Zero(), 0.01, 1), 1e-12));
  EXPECT_TRUE(informationMatrix(Refinement(), Eigen::Vector3d::Ones(), 0.01, 1).isZero());
}

TEST(RotationDeviation, IsThatOfTheCovariance)
{
  for (const std::uint64_t seed : {12, 13, 14}) {
    const Refinement r = refinementOf(matchesOn({kX, kY, kZ}, 20, Eigen::Vector3d(30, -20, 5), seed));
    const RotationDeviation turn = largestRotationDeviation(r, 0.01, 4);
    for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(50, 40, -30)}) {
      const Matrix6 covariance = informationMatrix(r, origin, 0.01, 4).inverse();
      const Eigen::Matrix3d rotation = covariance.topLeftCorner<3, 3>();
      const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rotation).eigenvalues()[2];
      EXPECT_NEAR(turn.deviation, std::sqrt(largest), 1e-6 * turn.deviation);
      EXPECT_NEAR(turn.axis.dot(rotation * turn.axis), largest, 1e-6 * largest);
    }
  }
}

TEST(RotationDeviation, IsInfiniteWhereNothingTells)
{
  // Planes across x alone tell no turn about x.
  const RotationDeviation turn = largestRotationDeviation(refinementOf(matchesOn({kX}, 40, kX, 15)), 0.01, 1);
  EXPECT_EQ(turn.deviation, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(std::abs(turn.axis.x()), 1, 1e-6);
  EXPECT_EQ(largestRotationDeviation(Refinement(), 0.01, 1).deviation, std::numeric_limits<double>::infinity());
}

TEST(InformationMatrix, FarOrigin)
{
  const Refinement r = refinementOf(matchesOn({kX, kY, kZ}, 40, kX, 11));
  for (const double x : {1e6, 1e30})
    EXPECT_TRUE(informationMatrix(r, Eigen::Vector3d::Constant(x), 0.01, 1).allFinite());
}

TEST(RotationDeviation, APriorTellsTheAxesThatItBinds)
{
  const Refinement level = refinementOf(matchesOn({kX, kY}, 100, kX, 12)); // heights are open, turns are told
  const double before = largestRotationDeviation(level, 0.5, 1).deviation;
  const double rough = 10 * before, exact = 0.1 * before;
  const auto with = [&](double deviation) {
    return largestRotationDeviation(level, 0.5, 1, Eigen::Matrix3d::Identity() / (deviation * deviation)).deviation;
  };
  EXPECT_NEAR(with(rough), before, 0.01 * before);
  EXPECT_NEAR(with(exact), exact, 0.01 * exact);
  // One plane leaves the turn about its normal open; a prior of the others does not tell it.
  const Refinement plane = refinementOf(matchesOn({kZ}, 100, kX, 13));
  const Eigen::Matrix3d vertical = 1e6 * (Eigen::Matrix3d::Identity() - kZ * kZ.transpose());
  EXPECT_EQ(largestRotationDeviation(plane, 0.5, 1, vertical).deviation, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(largestRotationDeviation(plane, 0.5, 1, 1e6 * Eigen::Matrix3d::Identity()).deviation, 1e-3, 1e-5);
}

TEST(RankMotions, AlongTheCorridorFirst)
{
  // Floor and walls, a few places on its end: the way along the corridor is told least, and nothing else moves with it.
  Matches m = matchesOn({Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()}, 400, Eigen::Vector3d::Zero(), 3);
  const Matches end = matchesOn({Eigen::Vector3d::UnitX()}, 4, Eigen::Vector3d::Zero(), 4);
  m.points.conservativeResize(3, 804);
  m.normals.conservativeResize(3, 804);
  m.points.rightCols(4) = end.points;
  m.normals.rightCols(4) = end.normals;
  const std::vector<MotionStrength> motions = rankMotions(refinementOf(m, Eigen::Vector3d::Zero()));
  ASSERT_EQ(motions.size(), 6u);
  EXPECT_LT(motions[0].strength, 0.02);
  EXPECT_GT(motions[1].strength, 5 * motions[0].strength);
  EXPECT_GT(std::abs(motions[0].motion[3]), 0.95);
  EXPECT_LT(motions[0].motion.head<3>().norm() * 5, 0.3); // at the ends of the corridor [m]
}

TEST(RankMotions, AreOrderedAndSpanTheHessian)
{
  testing::Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Eigen::Vector3d> normals(4);
    for (Eigen::Vector3d& n : normals)
      n = Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const Refinement r = refinementOf(matchesOn(normals, 30, Eigen::Vector3d::Zero(), 100 + trial), {0.1, 0.2, 0.3});
    const std::vector<MotionStrength> motions = rankMotions(r);
    ASSERT_EQ(motions.size(), 6u);
    EXPECT_DOUBLE_EQ(motions[5].strength, 1);
    const double strongest = motions[5].motion.dot(r.hessian * motions[5].motion);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_TRUE(i == 0 || motions[i].strength >= motions[i - 1].strength);
      EXPECT_NEAR(
          motions[i].motion.dot(r.hessian * motions[i].motion), motions[i].strength * strongest, 1e-9 * strongest);
      for (std::size_t k = 0; k < i; ++k) // independent
        EXPECT_NEAR(motions[i].motion.dot(r.hessian * motions[k].motion), 0, 1e-9 * strongest);
    }
  }
}

TEST(RankMotions, RotationsCountByTheirLever)
{
  // The same scene ten times as large, by ten times smaller turns: the same order and strengths.
  Matches m = matchesOn({Eigen::Vector3d::UnitX(), {0.3, 1, 0}, {0, 0.2, 1}}, 50, Eigen::Vector3d::Zero(), 11);
  const std::vector<MotionStrength> small = rankMotions(refinementOf(m, Eigen::Vector3d::Zero()));
  m.points *= 10;
  const std::vector<MotionStrength> large = rankMotions(refinementOf(m, Eigen::Vector3d::Zero()));
  ASSERT_EQ(small.size(), 6u);
  ASSERT_EQ(large.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(small[i].strength, large[i].strength, 1e-9);
}

TEST(RankMotions, NothingKnown)
{
  EXPECT_TRUE(rankMotions(Refinement()).empty());
  Refinement r = refinementOf(matchesOn({Eigen::Vector3d::UnitZ()}, 10, Eigen::Vector3d::Zero(), 1), {0, 0, 0});
  EXPECT_EQ(rankMotions(r).size(), 6u); // one plane
  EXPECT_LT(rankMotions(r)[2].strength, 1e-12);
  r.hessian(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(rankMotions(r).empty());
}

} // namespace
} // namespace pcl_ssfr
