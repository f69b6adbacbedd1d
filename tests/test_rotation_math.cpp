// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"
#include "pose_matchers.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::test_rotation_math {
namespace {

Eigen::Matrix3d
turn(double angle, const Eigen::Vector3d& axis)
{
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

void
expectRotation(const Eigen::Matrix3d& R)
{
  EXPECT_TRUE((R.transpose() * R).isIdentity(1e-12));
  EXPECT_NEAR(R.determinant(), 1, 1e-12);
}

TEST(NearestRotation, ByHand)
{
  EXPECT_TRUE(nearestRotation(Eigen::Vector3d(3, 2, 1).asDiagonal()).isIdentity(1e-12));
  // A mirror: the least of the three is given up.
  EXPECT_TRUE(nearestRotation(Eigen::Vector3d(3, 2, -1).asDiagonal()).isIdentity(1e-12));
  EXPECT_TRUE(nearestRotation(Eigen::Vector3d(3, -2, -1).asDiagonal())
                  .isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), 1e-12));
}

TEST(NearestRotation, NoRotationIsNearer)
{
  testing::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Matrix3d M = testing::randomRotation(random) * Eigen::Vector3d(1.5, 0.8, 0.3).asDiagonal() *
                              testing::randomRotation(random).transpose();
    const Eigen::Matrix3d R = nearestRotation(M);
    expectRotation(R);
    for (int other = 0; other < 200; ++other) {
      const Eigen::Matrix3d Q = other % 2 == 0
                                    ? testing::randomRotation(random)
                                    : Eigen::Matrix3d(turn(0.01, testing::randomRotation(random).col(0)) * R);
      EXPECT_LE((R - M).norm(), (Q - M).norm() + 1e-12);
    }
  }
}

TEST(NearestRotation, OfNothingIsARotation)
{
  const Eigen::Matrix3d R = nearestRotation(Eigen::Matrix3d::Zero());
  expectRotation(R);
}

TEST(RotationOnto, IsTheSmallestThatDoes)
{
  testing::Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d from = random.uniform(0.1, 9) * testing::randomRotation(random).col(0);
    Eigen::Vector3d to = testing::randomRotation(random).col(0);
    if (trial % 3 != 0) // nearly the same, and nearly opposite
      to = turn(1e-3, to) * (trial % 3 == 1 ? 1 : -0.2) * from;
    const Eigen::Matrix3d R = rotationOnto(from, to);
    expectRotation(R);
    EXPECT_LT(angleBetweenDirections(R * from, to), 1e-11);
    EXPECT_NEAR(angleBetween(R, Eigen::Matrix3d::Identity()), angleBetweenDirections(from, to), 1e-9);
  }
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(rotationOnto(up, up).isIdentity(0));
  for (const double from_opposite : {0.0, 1e-17, 1e-12, 1e-9, 1e-8, 1e-7, 1e-5}) {
    const Eigen::Vector3d to = Eigen::Vector3d(from_opposite, 0, -1).normalized();
    const Eigen::Matrix3d R = rotationOnto(up, to);
    expectRotation(R);
    EXPECT_LT(angleBetweenDirections(R * up, to), 1.1e-8) << from_opposite;
  }
  // Of directions along no axis the sum is rounding where it should be nothing.
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d from = random.uniform(0.1, 9) * testing::randomRotation(random).col(0);
    const double from_opposite = std::pow(10, random.uniform(-18, -6));
    const Eigen::Vector3d to = -(turn(from_opposite, testing::randomRotation(random).col(0)) * from).normalized();
    const Eigen::Matrix3d R = rotationOnto(from, to);
    expectRotation(R);
    EXPECT_LT(angleBetweenDirections(R * from, to), 5e-8) << from_opposite;
  }
}

TEST(AngleBetween, IsTheAngleOfTheTurn)
{
  testing::Random random(2);
  for (const double angle : {0.0, 1e-9, 1e-4, 0.3, 1.5, 3.0, kPi - 1e-7, kPi}) {
    const Eigen::Matrix3d R = testing::randomRotation(random);
    const Eigen::Matrix3d Q = R * turn(angle, testing::randomRotation(random).col(0));
    EXPECT_NEAR(angleBetween(R, Q), angle, 1e-8) << angle;
    EXPECT_NEAR(angleBetween(Q, R), angle, 1e-8) << angle;
  }
  EXPECT_NEAR(angleBetween(Eigen::Matrix3d::Identity(), turn(4, Eigen::Vector3d(1, 2, 3))), 2 * kPi - 4, 1e-12);
}

TEST(RequireRigid, NamesWhatIsWrong)
{
  const auto problem = [](const Eigen::Isometry3d& T) -> std::string {
    try {
      requireRigid(T, "T");
    }
    catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Eigen::Isometry3d T(turn(1, Eigen::Vector3d(1, 2, 3)));
  T.translation() << 1e6, -2, 0;
  EXPECT_EQ(problem(T), "");
  Eigen::Isometry3d bad = T;
  bad(1, 3) = std::nan("");
  EXPECT_EQ(problem(bad), "T(1, 3) = nan, must be finite");
  for (const double factor : {1.01, -1.0}) {
    bad = T;
    bad.linear() *= factor;
    EXPECT_NE(problem(bad).find("the linear part of T is no rotation"), std::string::npos);
  }
}

TEST(KeepsVertical, WithinTheTolerance)
{
  GravityPrior gravity;
  gravity.up_source = Eigen::Vector3d::UnitX();
  gravity.up_target = Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d upright = turn(-kPi / 2, Eigen::Vector3d::UnitY()); // x to z
  for (const double around : {0.0, 1.0, 3.0})
    for (const double tilt : {0.0, 1e-9, 0.05, 0.2, 3.0}) {
      const Eigen::Matrix3d R = turn(around, Eigen::Vector3d::UnitZ()) * turn(tilt, Eigen::Vector3d(1, 1, 0)) * upright;
      EXPECT_TRUE(keepsVertical(R, gravity, tilt + 1e-7)) << tilt;
      EXPECT_TRUE(tilt < 1e-6 || !keepsVertical(R, gravity, tilt - 1e-7)) << tilt;
      EXPECT_TRUE(keepsVertical(R, gravity, kPi));
    }
  Eigen::Matrix3d none = upright;
  none(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(keepsVertical(none, gravity, kPi));
}

} // namespace
} // namespace pcl_ssfr::test_rotation_math
