// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"
#include "judgement/pose_priors.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <vector>

namespace pcl_ssfr {
namespace {

const Eigen::Vector3d kPlace(0.5, -1, 0.25); // of the source's sensor

Options
withVertical(double tolerance, const Eigen::Vector3d& up_source, const Eigen::Vector3d& up_target)
{
  Options options;
  options.gravity.emplace();
  options.gravity->up_source = up_source;
  options.gravity->up_target = up_target;
  options.gravity->tolerance = tolerance;
  return options;
}

Options
withTolerance(double rotation, double translation)
{
  Options options;
  options.guess_tolerance = GuessTolerance{rotation, translation};
  return options;
}

Eigen::Matrix3d
turnAbout(const Eigen::Vector3d& axis, double angle)
{
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// A pose that turns by R about \p place and then moves it by \p shift.
Eigen::Isometry3d
poseAbout(const Eigen::Vector3d& place, const Eigen::Matrix3d& R, const Eigen::Vector3d& shift)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = place - R * place + shift;
  return T;
}

TEST(PosePriors, WithoutAnyEverythingIsAllowed)
{
  // A guess without a tolerance is no bound.
  const PosePriors priors(Options(), Eigen::Isometry3d::Identity(), kPlace, 1);
  testing::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 100);
    for (const Exactness exactness : {Exactness::Proposed, Exactness::Refined})
      EXPECT_TRUE(priors.allow(T, exactness));
    EXPECT_FALSE(priors.shiftWindow(T.linear(), 1));
  }
  EXPECT_FALSE(priors.guess());
  EXPECT_FALSE(priors.vertical());
  EXPECT_TRUE(priors.rotationInformation().isZero());
}

TEST(PosePriors, TiltWithinToleranceAndMargin)
{
  testing::Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d up_source = testing::randomRotation(random).col(2);
    const Eigen::Vector3d up_target = testing::randomRotation(random).col(2);
    const Eigen::Matrix3d R_upright = Eigen::Quaterniond::FromTwoVectors(up_source, up_target).toRotationMatrix() *
                                      turnAbout(up_source, random.uniform(-3, 3));
    const auto tilted = [&](double angle) {
      return Eigen::Matrix3d(turnAbout(up_target.unitOrthogonal(), angle) * R_upright);
    };
    const PosePriors exact(withVertical(0.02, up_source, up_target), std::nullopt, kPlace, 1);
    EXPECT_TRUE(exact.allow(tilted(0.029), Exactness::Refined));
    EXPECT_FALSE(exact.allow(tilted(0.031), Exactness::Refined)); // 0.01 beyond the tolerance
    EXPECT_TRUE(exact.allow(tilted(0.119), Exactness::Proposed));
    EXPECT_FALSE(exact.allow(tilted(0.121), Exactness::Proposed)); // what main normals are good to
    EXPECT_TRUE(exact.keepVertical(tilted(0.029), Exactness::Refined));
    const PosePriors rough(withVertical(0.3, up_source, up_target), std::nullopt, kPlace, 1);
    EXPECT_TRUE(rough.allow(tilted(0.299), Exactness::Proposed));
    EXPECT_FALSE(rough.allow(tilted(0.301), Exactness::Proposed));
  }
}

TEST(PosePriors, NearTheGuessInTurnAndInShiftOfThePlace)
{
  testing::Random random(3);
  for (const double scale : {1.0, 10.0}) {
    const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
    const PosePriors priors(withTolerance(0.1, 2), guess, kPlace, scale);
    ASSERT_TRUE(priors.guess());
    EXPECT_TRUE(priors.guess()->isApprox(guess));
    const auto beside = [&](double turn, double shift) {
      return Eigen::Isometry3d(guess * poseAbout(kPlace,
                                                 turnAbout(testing::randomRotation(random).col(0), turn),
                                                 shift * testing::randomRotation(random).col(0)));
    };
    for (int trial = 0; trial < 20; ++trial) {
      EXPECT_TRUE(priors.allow(beside(0.109, 1.99), Exactness::Refined));
      EXPECT_FALSE(priors.allow(beside(0.111, 1.99), Exactness::Refined));
      EXPECT_FALSE(priors.allow(beside(0.09, 2.01), Exactness::Refined));
      // Proposed poses are refined by up to 0.3 m at scale 1.
      EXPECT_TRUE(priors.allow(beside(0.219, 1.99 + 0.3 * scale), Exactness::Proposed));
      EXPECT_FALSE(priors.allow(beside(0.221, 1.99), Exactness::Proposed));
      EXPECT_FALSE(priors.allow(beside(0.09, 2.01 + 0.3 * scale), Exactness::Proposed));
      EXPECT_TRUE(priors.allow(Eigen::Matrix3d(beside(0.109, 50).linear()), Exactness::Refined)); // of turns only
    }
  }
}

TEST(PosePriors, DropOthersAsAllowSaysAndKeepsTheOrder)
{
  testing::Random random(4);
  Options options = withVertical(0.1, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
  options.guess_tolerance = GuessTolerance{0.4, 3};
  const PosePriors priors(options, Eigen::Isometry3d::Identity(), kPlace, 1);
  std::vector<ScoredPose> poses(400);
  std::vector<double> expected;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].T_target_source = poseAbout(kPlace,
                                         turnAbout(testing::randomRotation(random).col(0), random.uniform(0, 0.6)),
                                         random.uniform(0, 5) * testing::randomRotation(random).col(0));
    poses[i].score = static_cast<double>(i);
    if (priors.allow(poses[i].T_target_source, Exactness::Refined))
      expected.push_back(poses[i].score);
  }
  priors.dropOthers(poses, Exactness::Refined);
  ASSERT_EQ(poses.size(), expected.size());
  EXPECT_GT(expected.size(), 10U);
  EXPECT_LT(expected.size(), 390U);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_EQ(poses[i].score, expected[i]);
  std::vector<ScoredPose> none;
  priors.dropOthers(none, Exactness::Refined);
  EXPECT_TRUE(none.empty());
}

TEST(PosePriors, WindowOfShiftsLaysThePlaceWhereTheGuessDoes)
{
  testing::Random random(5);
  const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
  const PosePriors priors(withTolerance(0.1, 2), guess, kPlace, 1);
  const Eigen::Matrix3d R = testing::randomRotation(random);
  const std::optional<ShiftWindow> window = priors.shiftWindow(R, 0.5);
  ASSERT_TRUE(window);
  EXPECT_TRUE((R * kPlace + window->centre).isApprox(guess * kPlace, 1e-12));
  EXPECT_DOUBLE_EQ(window->radius, 2.5);
}

TEST(PosePriors, TellRotationsAsMuchAsTheirTolerances)
{
  const Eigen::Vector3d up(0.6, 0, 0.8);
  const Options gravity = withVertical(0.15, Eigen::Vector3d::UnitZ(), up);
  const PosePriors vertical(gravity, std::nullopt, kPlace, 1);
  // The tolerance is three standard deviations, and the matches that it is weighed against claim five times too much.
  ASSERT_TRUE(vertical.vertical());
  EXPECT_NEAR(vertical.vertical()->deviation, 0.01, 1e-12);
  EXPECT_EQ(vertical.vertical()->up_target, up);
  const Eigen::Matrix3d tilt = vertical.rotationInformation();
  EXPECT_NEAR((tilt * up).norm(), 0, 1e-9);                                    // nothing of the turn about the vertical
  EXPECT_NEAR(up.unitOrthogonal().dot(tilt * up.unitOrthogonal()), 400, 1e-6); // a third of the tolerance: 0.05 rad

  Options both = gravity;
  both.guess_tolerance = GuessTolerance{0.2, 1};
  const PosePriors known(both, Eigen::Isometry3d::Identity(), kPlace, 1);
  EXPECT_TRUE(known.rotationInformation().isApprox(tilt + 25 * Eigen::Matrix3d::Identity(), 1e-12));

  const PosePriors exact(withVertical(0, Eigen::Vector3d::UnitZ(), up), std::nullopt, kPlace, 1);
  EXPECT_TRUE(exact.rotationInformation().allFinite());
  EXPECT_GT(exact.vertical()->deviation, 0);
}

} // namespace
} // namespace pcl_ssfr
