// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"
#include "judgement/pose_priors.h"

#include "common/config_numbers.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_pose_priors {
namespace {

const Eigen::Vector3d kPlace(0.5, -1, 0.25); // of the source's sensor [m]
constexpr double kRadius = 5;                // of the source [m]

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
rotationAbout(const Eigen::Vector3d& axis, double angle)
{
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// A pose that rotates by R about \p place and then moves it by \p translation.
Eigen::Isometry3d
poseAbout(const Eigen::Vector3d& place, const Eigen::Matrix3d& R, const Eigen::Vector3d& translation)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = place - R * place + translation;
  return T;
}

TEST(PosePriors, WithoutAnyEverythingIsAllowed)
{
  // A guess without a tolerance is no bound.
  const PosePriors priors(Options(), Eigen::Isometry3d::Identity(), kPlace, kRadius, PatchProfileConfig());
  testing::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 100);
    for (const Exactness exactness : {Exactness::Proposed, Exactness::Refined})
      EXPECT_TRUE(priors.allow(T, exactness));
    EXPECT_FALSE(priors.translationWindow(T.linear(), 1));
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
    const Eigen::Matrix3d R_upright =
        rotationOnto(up_source, up_target) * rotationAbout(up_source, random.uniform(-3, 3));
    const auto tilted = [&](double angle) {
      return Eigen::Matrix3d(rotationAbout(up_target.unitOrthogonal(), angle) * R_upright);
    };
    const PosePriors exact(
        withVertical(0.02, up_source, up_target), std::nullopt, kPlace, kRadius, PatchProfileConfig());
    EXPECT_TRUE(exact.allow(tilted(0.029), Exactness::Refined));
    EXPECT_FALSE(exact.allow(tilted(0.031), Exactness::Refined)); // 0.01 beyond the tolerance
    EXPECT_TRUE(exact.allow(tilted(0.119), Exactness::Proposed));
    EXPECT_FALSE(exact.allow(tilted(0.121), Exactness::Proposed)); // what main normals are good to
    EXPECT_TRUE(exact.keepVertical(tilted(0.029), Exactness::Refined));
    const PosePriors rough(
        withVertical(0.3, up_source, up_target), std::nullopt, kPlace, kRadius, PatchProfileConfig());
    EXPECT_TRUE(rough.allow(tilted(0.299), Exactness::Proposed));
    EXPECT_FALSE(rough.allow(tilted(0.301), Exactness::Proposed));
  }
}

TEST(PosePriors, NearTheGuessInRotationAndInTranslationOfThePlace)
{
  testing::Random random(3);
  for (const double scale : {1.0, 10.0}) {
    const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
    const PosePriors priors(
        withTolerance(0.1, 2), guess, kPlace, kRadius, scaledForPair(PatchProfileConfig(), scale, 1));
    ASSERT_TRUE(priors.guess());
    EXPECT_TRUE(priors.guess()->isApprox(guess));
    const auto nearby = [&](double angle, double distance) {
      return Eigen::Isometry3d(guess * poseAbout(kPlace,
                                                 rotationAbout(testing::randomRotation(random).col(0), angle),
                                                 distance * testing::randomRotation(random).col(0)));
    };
    for (int trial = 0; trial < 20; ++trial) {
      EXPECT_TRUE(priors.allow(nearby(0.109, 1.99), Exactness::Refined));
      EXPECT_FALSE(priors.allow(nearby(0.111, 1.99), Exactness::Refined));
      EXPECT_FALSE(priors.allow(nearby(0.09, 2.01), Exactness::Refined));
      // Proposed poses are refined by up to 0.3 m at scale 1.
      EXPECT_TRUE(priors.allow(nearby(0.219, 1.99 + 0.3 * scale), Exactness::Proposed));
      EXPECT_FALSE(priors.allow(nearby(0.221, 1.99), Exactness::Proposed));
      EXPECT_FALSE(priors.allow(nearby(0.09, 2.01 + 0.3 * scale), Exactness::Proposed));
      EXPECT_TRUE(priors.allow(Eigen::Matrix3d(nearby(0.109, 50).linear()), Exactness::Refined)); // of rotations only
    }
  }
}

TEST(PosePriors, DropExcludedAsAllowSaysAndKeepsTheOrder)
{
  testing::Random random(4);
  Options options = withVertical(0.1, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
  options.guess_tolerance = GuessTolerance{0.4, 3};
  const PosePriors priors(options, Eigen::Isometry3d::Identity(), kPlace, kRadius, PatchProfileConfig());
  std::vector<ScoredPose> poses(400);
  std::vector<double> expected;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].T_target_source = poseAbout(kPlace,
                                         rotationAbout(testing::randomRotation(random).col(0), random.uniform(0, 0.6)),
                                         random.uniform(0, 5) * testing::randomRotation(random).col(0));
    poses[i].score = static_cast<double>(i);
    if (priors.allow(poses[i].T_target_source, Exactness::Refined))
      expected.push_back(poses[i].score);
  }
  priors.dropExcluded(poses, Exactness::Refined);
  ASSERT_EQ(poses.size(), expected.size());
  EXPECT_GT(expected.size(), 10U);
  EXPECT_LT(expected.size(), 390U);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_EQ(poses[i].score, expected[i]);
  std::vector<ScoredPose> none;
  priors.dropExcluded(none, Exactness::Refined);
  EXPECT_TRUE(none.empty());
}

TEST(PosePriors, TranslationWindowPutsThePlaceWhereTheGuessDoes)
{
  testing::Random random(5);
  const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
  const PosePriors priors(withTolerance(0.1, 2), guess, kPlace, kRadius, PatchProfileConfig());
  const Eigen::Matrix3d R = testing::randomRotation(random);
  const std::optional<ShiftWindow> window = priors.translationWindow(R, 0.5);
  ASSERT_TRUE(window);
  EXPECT_TRUE((R * kPlace + window->centre).isApprox(guess * kPlace, 1e-12));
  EXPECT_DOUBLE_EQ(window->radius, 2.5);
}

TEST(PosePriors, InformationOnRotationsFollowsFromTheTolerances)
{
  const Eigen::Vector3d up(0.6, 0, 0.8);
  const Options gravity = withVertical(0.15, Eigen::Vector3d::UnitZ(), up);
  const PosePriors vertical(gravity, std::nullopt, kPlace, kRadius, PatchProfileConfig());
  // The tolerance is three standard deviations, and the matches that it is weighed against claim five times too much.
  ASSERT_TRUE(vertical.vertical());
  EXPECT_NEAR(vertical.vertical()->deviation, 0.01, 1e-12);
  EXPECT_EQ(vertical.vertical()->up_target, up);
  const Eigen::Matrix3d tilt = vertical.rotationInformation();
  EXPECT_NEAR((tilt * up).norm(), 0, 1e-9); // none on the rotation about the vertical
  EXPECT_NEAR(up.unitOrthogonal().dot(tilt * up.unitOrthogonal()), 400, 1e-6); // a third of the tolerance: 0.05 rad

  Options both = gravity;
  both.guess_tolerance = GuessTolerance{0.2, 1};
  const PosePriors known(both, Eigen::Isometry3d::Identity(), kPlace, kRadius, PatchProfileConfig());
  EXPECT_TRUE(known.rotationInformation().isApprox(tilt + 25 * Eigen::Matrix3d::Identity(), 1e-12));

  const PosePriors exact(
      withVertical(0, Eigen::Vector3d::UnitZ(), up), std::nullopt, kPlace, kRadius, PatchProfileConfig());
  EXPECT_TRUE(exact.rotationInformation().allFinite());
  EXPECT_GT(exact.vertical()->deviation, 0);
}

TEST(LogPrior, NothingKnownBeforehand)
{
  const PosePriors priors(Options(), std::nullopt, kPlace, kRadius, PatchProfileConfig());
  testing::Random random(6);
  for (int trial = 0; trial < 20; ++trial)
    EXPECT_EQ(priors.logPrior(testing::randomMotion(random, 100)), 0);
}

TEST(LogPrior, AVerticalIsGaussianInTheTilt)
{
  // The tolerance is three standard deviations. The length of the given vectors is no matter.
  const Eigen::Vector3d up_source(0, 0.6, 0.8), up_target(0.8, 0, 0.6);
  const PosePriors priors(
      withVertical(0.3, 2 * up_source, 3 * up_target), std::nullopt, kPlace, kRadius, PatchProfileConfig());
  const Eigen::Matrix3d R_upright = rotationOnto(up_source, up_target);
  testing::Random random(7);
  // One standard deviation of what is given is 0.1; a refined pose errs by 0.01 besides.
  for (const double tilt : {0.0, 0.1, 0.2, 0.3, 0.6}) {
    const double expected = -0.5 * tilt * tilt / (0.1 * 0.1 + 0.01 * 0.01);
    // Rotations about the vertical and translations are as probable as any.
    const Eigen::Matrix3d R = rotationAbout(up_target, random.uniform(-3, 3)) *
                              rotationAbout(up_target.unitOrthogonal(), tilt) * R_upright *
                              rotationAbout(up_source, random.uniform(-3, 3));
    Eigen::Isometry3d T(Eigen::Translation3d(random.uniform(-50, 50), random.uniform(-50, 50), 9));
    T.linear() = R;
    EXPECT_NEAR(priors.logPrior(T), expected, 1e-9) << tilt;
  }
}

TEST(LogPrior, AGuessOfKnownToleranceIsGaussianInRotationAndTranslation)
{
  // Here the tolerances are one standard deviation. Translations are those of the place, whatever the rotation.
  testing::Random random(8);
  const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
  const PosePriors priors(withTolerance(0.1, 2), guess, kPlace, kRadius, PatchProfileConfig());
  const auto at = [&](double angle, double distance) {
    return priors.logPrior(guess * poseAbout(kPlace,
                                             rotationAbout(testing::randomRotation(random).col(0), angle),
                                             distance * testing::randomRotation(random).col(0)));
  };
  EXPECT_NEAR(at(0, 0), 0, 1e-9);
  // A refined pose errs by 0.01 rad besides.
  const double rotation = 0.5 * 0.1 * 0.1 / (0.1 * 0.1 + 0.01 * 0.01);
  EXPECT_NEAR(at(0.1, 0), -rotation, 1e-9);
  EXPECT_NEAR(at(0, 2), -0.5, 1e-9);
  EXPECT_NEAR(at(0.1, 2), -rotation - 0.5, 1e-9);
  EXPECT_NEAR(at(0.3, 0), -9 * rotation, 1e-9);
  EXPECT_NEAR(at(0.2, 6), -4 * rotation - 4.5, 1e-9);
}

TEST(LogPrior, AVerticalAndAGuessAddUp)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Options both = withVertical(0.3, up, up);
  both.guess_tolerance = GuessTolerance{0.1, 2};
  const Eigen::Isometry3d guess = Eigen::Isometry3d::Identity();
  const PosePriors priors(both, guess, kPlace, kRadius, PatchProfileConfig());
  const PosePriors vertical(withVertical(0.3, up, up), std::nullopt, kPlace, kRadius, PatchProfileConfig());
  const PosePriors near_guess(withTolerance(0.1, 2), guess, kPlace, kRadius, PatchProfileConfig());
  const Eigen::Isometry3d T = poseAbout(kPlace, rotationAbout(Eigen::Vector3d::UnitX(), 0.1), Eigen::Vector3d(0, 2, 0));
  EXPECT_NEAR(priors.logPrior(T), -0.5 - 1 / (1 + 0.01), 1e-9);
  EXPECT_NEAR(priors.logPrior(T), vertical.logPrior(T) + near_guess.logPrior(T), 1e-12);
}

TEST(LogPrior, ATinyToleranceDoesNotTellRefinedPosesApart)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const PosePriors priors(withVertical(1e-4, up, up), std::nullopt, kPlace, kRadius, PatchProfileConfig());
  const Eigen::Isometry3d T(rotationAbout(Eigen::Vector3d::UnitX(), 0.01));
  EXPECT_NEAR(priors.logPrior(T), -0.5, 1e-3);
}

TEST(LogPrior, AGuessWithoutAToleranceHasABoundedInfluence)
{
  testing::Random random(9);
  for (const double scale : {1.0, 10.0}) {
    Options options;
    options.patch_profile.judgement.prior.guess_trust = 30;
    options.patch_profile.judgement.prior.guess_deviation = 1;
    const Eigen::Isometry3d guess = testing::randomMotion(random, 20);
    const PosePriors priors(options, guess, kPlace, kRadius, scaledForPair(PatchProfileConfig(), scale, 1));
    const auto at = [&](double angle, double distance) {
      return priors.logPrior(guess * poseAbout(kPlace,
                                               rotationAbout(testing::randomRotation(random).col(0), angle),
                                               distance * testing::randomRotation(random).col(0)));
    };
    EXPECT_NEAR(at(0, 0), std::log(31), 1e-6);
    EXPECT_NEAR(at(0, scale), std::log(16), 1e-9); // one deviation off
    EXPECT_NEAR(at(0, 3 * scale), std::log(4), 1e-9);
    // A rotation counts with what it moves at the radius of the source.
    EXPECT_NEAR(at(0.1 * scale / kRadius, 0), at(0, 0.1 * scale), 1e-9);
    EXPECT_NEAR(at(0.1, scale), std::log1p(30 / (1 + std::pow(1 + 0.1 * kRadius / scale, 2))), 1e-9);
    // Farther off it is less and less, but never a reason against a pose.
    double before = std::log(32);
    for (double distance = 0; distance < 1e6; distance = 2 * distance + 0.1) {
      const double now = at(0, distance);
      EXPECT_LT(now, before);
      EXPECT_GT(now, 0);
      before = now;
    }
    EXPECT_LT(before, 1e-6);
  }
}

} // namespace
} // namespace pcl_ssfr::test_pose_priors
