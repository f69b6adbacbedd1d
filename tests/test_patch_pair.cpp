// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pose_matchers.h"
#include "profiles/patch_pair.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace pcl_ssfr::test_patch_pair {
namespace {

using testing::IsPoseNear;
using testing::viewOfPoints;

Eigen::Isometry3d
motion(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& translation)
{
  return Eigen::Translation3d(translation) * Eigen::AngleAxisd(angle, axis.normalized());
}

ScoredPose
at(const Eigen::Isometry3d& T_target_source)
{
  ScoredPose pose;
  pose.T_target_source = T_target_source;
  return pose;
}

/// Two scans of a furnished room, prepared once for all tests.
class PatchPairOfARoom : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    const testing::Scene scene = testing::makeFurnishedRoom(1);
    const Eigen::Isometry3d T_world_target = testing::sensorPose(scene.stations.at(0), 0.1);
    const Eigen::Isometry3d T_world_source = testing::sensorPose(scene.stations.at(1), 1.85, 0.2);
    const auto cast = [&](const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed) {
      return testing::castScan(scene, T_world_sensor, testing::roomScanner(0.0262), seed);
    };
    target_points_ = cast(T_world_target, 11);
    const Eigen::Matrix3Xf source_points = cast(T_world_source, 12);
    source_ = new PatchScan(preparePatchScan(viewOfPoints(source_points), Options()));
    target_ = new PatchScan(preparePatchScan(viewOfPoints(target_points_), Options()));
    truth_ = testing::relativePose(T_world_target, T_world_source);
  }

  static void
  TearDownTestSuite()
  {
    delete source_;
    delete target_;
    source_ = target_ = nullptr;
  }

  static PatchPair
  pair(const Options& options, const Deadline& deadline = Deadline())
  {
    return PatchPair(*source_, *target_, options, nullptr, deadline);
  }

  static inline Eigen::Matrix3Xf target_points_; ///< in the frame of its sensor
  static inline PatchScan* source_ = nullptr;
  static inline PatchScan* target_ = nullptr;
  static inline Eigen::Isometry3d truth_ = Eigen::Isometry3d::Identity(); ///< between the sensors' frames
  const Options options_ = Options();
};

TEST_F(PatchPairOfARoom, FramesThereAndBack)
{
  const PatchPair scans = pair(options_);
  const Eigen::Isometry3d inner = scans.toInner(truth_);
  EXPECT_THAT(scans.toOuter(inner), IsPoseNear(truth_, 1e-12, 1e-12));
  // The same place in both frames.
  const Eigen::Vector3d p(0.3, -0.4, 0.5);
  EXPECT_TRUE((truth_ * p - target_->origin).isApprox(inner * (p - source_->origin), 1e-9));
}

TEST_F(PatchPairOfARoom, AGuessBoundsThePoseOnlyWithItsTolerance)
{
  const Eigen::Isometry3d guess = motion(Eigen::Vector3d::UnitZ(), 0.02, Eigen::Vector3d(0.1, 0, 0)) * truth_;
  EXPECT_FALSE(PatchPair(*source_, *target_, options_, &guess, Deadline()).priors().guess());
  Options bounded = options_;
  bounded.guess_tolerance = GuessTolerance{0.1, 0.5};
  EXPECT_FALSE(PatchPair(*source_, *target_, bounded, nullptr, Deadline()).priors().guess());
  const PatchPair scans(*source_, *target_, bounded, &guess, Deadline());
  ASSERT_TRUE(scans.priors().guess());
  EXPECT_THAT(*scans.priors().guess(), IsPoseNear(scans.toInner(guess), 1e-9, 1e-9));
  EXPECT_TRUE(scans.priors().allow(scans.toInner(truth_), Exactness::Refined));
  // A rotation about the source's sensor does not move it, wherever the middle of its points lies.
  const Eigen::Isometry3d rotated = guess * motion(Eigen::Vector3d::UnitZ(), 0.09, Eigen::Vector3d::Zero());
  EXPECT_TRUE(scans.priors().allow(scans.toInner(rotated), Exactness::Refined));
  const Eigen::Isometry3d shifted = guess * motion(Eigen::Vector3d::UnitZ(), 0, Eigen::Vector3d(0, 0.6, 0));
  EXPECT_FALSE(scans.priors().allow(scans.toInner(shifted), Exactness::Refined));
}

TEST_F(PatchPairOfARoom, TheTruthExplainsMoreThanOtherPoses)
{
  const PatchPair scans = pair(options_);
  ScoredPose truth = at(scans.toInner(truth_));
  scans.scoreFine(truth);
  EXPECT_GT(truth.score, 0.4);
  testing::Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    ScoredPose other = at(motion(testing::randomRotation(random).col(0),
                                 random.uniform(0.3, 3),
                                 random.uniform(0.5, 2) * testing::randomRotation(random).col(0)) *
                          truth.T_target_source);
    scans.scoreFine(other);
    EXPECT_LT(other.score, 0.7 * truth.score) << trial;
  }
}

TEST_F(PatchPairOfARoom, RolesDoNotMatter)
{
  const PatchPair scans = pair(options_);
  const PatchPair back(*target_, *source_, options_, nullptr, Deadline());
  for (const double shift : {0.0, 0.05, 0.5}) {
    ScoredPose pose = at(motion(Eigen::Vector3d::UnitZ(), shift, Eigen::Vector3d(shift, 0, 0)) * scans.toInner(truth_));
    ScoredPose inverse = at(pose.T_target_source.inverse());
    scans.scoreFine(pose);
    back.scoreFine(inverse);
    EXPECT_NEAR(pose.score, inverse.score, 1e-6);
    EXPECT_NEAR(pose.evidence.matched, inverse.evidence.matched, 1e-6 * pose.evidence.total);
    // Evidence by direction is in the frame of the target.
    const Eigen::Matrix3d R = pose.T_target_source.linear();
    EXPECT_TRUE((R * inverse.evidence.matched_normals * R.transpose()).isApprox(pose.evidence.matched_normals, 1e-5));
    EXPECT_NEAR(pose.evidence.clutter, inverse.evidence.clutter, 2); // a point at the edge of a cell
  }
}

TEST_F(PatchPairOfARoom, EachRefinementFromAsFarAsItReaches)
{
  const PatchPair scans = pair(options_);
  const Eigen::Isometry3d truth = scans.toInner(truth_);
  testing::Random random(2);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Vector3d axis = testing::randomRotation(random).col(0);
    const Eigen::Vector3d shift = testing::randomRotation(random).col(0);
    EXPECT_THAT(scans.refinedCoarse(motion(axis, 0.08, 0.2 * shift) * truth), IsPoseNear(truth, 0.03, 0.06)) << trial;
    EXPECT_THAT(scans.refinedFine(motion(axis, 0.03, 0.06 * shift) * truth), IsPoseNear(truth, 0.005, 0.01)) << trial;
    ScoredPose pose = at(motion(axis, 0.01, 0.02 * shift) * truth);
    scans.scoreFine(pose);
    scans.polish(pose);
    EXPECT_THAT(pose.T_target_source, IsPoseNear(truth, 0.003, 0.004)) << trial;
    ASSERT_TRUE(pose.polish);
    EXPECT_EQ(pose.polish->T_target_source.matrix(), pose.T_target_source.matrix());
    EXPECT_GT(pose.polish->matches, 100);
  }
}

TEST_F(PatchPairOfARoom, APolishMakesNoMoreStepsThanItIsGiven)
{
  const Eigen::Isometry3d start =
      motion(Eigen::Vector3d::UnitX(), 0.01, Eigen::Vector3d(0.02, 0, 0)) * pair(options_).toInner(truth_);
  const auto polished = [&](int most) {
    Options options = options_;
    options.max_refinement_steps = most;
    const PatchPair scans = pair(options);
    ScoredPose pose = at(start);
    scans.scoreFine(pose);
    scans.polish(pose);
    return *pose.polish;
  };
  for (const int most : {1, 4, 12, 16, 30})
    EXPECT_LE(polished(most).steps, most);
  // Settled with wide matches, it goes on with narrow ones, and settles again.
  const Refinement settled = polished(100);
  EXPECT_LT(settled.steps, 80);
  EXPECT_LT(settled.rms, 0.8 * polished(4).rms);
}

TEST_F(PatchPairOfARoom, WithoutPolishThePoseStaysAndIsDescribed)
{
  const Eigen::Isometry3d start =
      motion(Eigen::Vector3d::UnitX(), 0.01, Eigen::Vector3d(0.02, 0, 0)) * pair(options_).toInner(truth_);
  Options unrefined = options_;
  unrefined.refine = false;
  const Deadline passed = Deadline::after(1e-9);
  for (const PatchPair& scans : {pair(unrefined), pair(options_, passed)}) {
    ScoredPose pose = at(start);
    scans.scoreFine(pose);
    scans.polish(pose);
    EXPECT_EQ(pose.T_target_source.matrix(), start.matrix());
    ASSERT_TRUE(pose.polish);
    EXPECT_EQ(pose.polish->steps, 1);
    EXPECT_GT(pose.polish->matches, 100);
  }
}

TEST_F(PatchPairOfARoom, APolishThatLeavesTheGivenVerticalIsNotTaken)
{
  // A vertical that is wrong by more than its tolerance, and a pose that keeps it: the surfaces lead to the truth.
  constexpr double kWrong = 0.035;
  const Eigen::Isometry3d truth = pair(options_).toInner(truth_);
  const Eigen::Isometry3d start = Eigen::Translation3d(target_->viewpoint) *
                                  Eigen::AngleAxisd(kWrong, Eigen::Vector3d::UnitX()) *
                                  Eigen::Translation3d(-target_->viewpoint) * truth;
  for (const double tolerance : {0.01, 0.03}) {
    Options options = options_;
    options.gravity.emplace();
    options.gravity->up_source = truth.linear().transpose() * Eigen::Vector3d::UnitZ();
    options.gravity->up_target = start.linear() * options.gravity->up_source;
    options.gravity->tolerance = tolerance;
    const PatchPair scans = pair(options);
    ScoredPose pose = at(start);
    scans.scoreFine(pose);
    scans.polish(pose);
    if (tolerance < kWrong / 2)
      EXPECT_EQ(pose.T_target_source.matrix(), start.matrix());
    else
      EXPECT_THAT(pose.T_target_source, IsPoseNear(truth, 0.01, 0.02));
  }
}

TEST_F(PatchPairOfARoom, MovesUnlessThatExplainsLess)
{
  const PatchPair scans = pair(options_);
  const Eigen::Isometry3d truth = scans.toInner(truth_);
  const Eigen::Isometry3d nearby = motion(Eigen::Vector3d::UnitX(), 0, Eigen::Vector3d(0.15, 0.1, 0.1)) * truth;
  ScoredPose pose = at(nearby);
  scans.scoreFine(pose);
  const double before = pose.score;
  scans.polish(pose);
  pose.T_target_source = nearby;
  EXPECT_TRUE(scans.moveUnlessWorse(pose, truth));
  EXPECT_FALSE(pose.polish); // it was of another place
  EXPECT_GT(pose.score, before);
  EXPECT_EQ(pose.T_target_source.matrix(), truth.matrix());
  const double best = pose.score;
  EXPECT_FALSE(scans.moveUnlessWorse(pose, nearby));
  EXPECT_EQ(pose.T_target_source.matrix(), truth.matrix());
  EXPECT_EQ(pose.score, best);
}

TEST_F(PatchPairOfARoom, TheSamePlaceIsNearInRotationAndInTranslationOfTheSensor)
{
  const PatchPair scans = pair(options_);
  const Eigen::Isometry3d T = scans.toInner(truth_);
  const auto rotated = [&](double angle, double shift) {
    const Eigen::Vector3d sensor = T * source_->viewpoint;
    return Eigen::Isometry3d(Eigen::Translation3d(sensor + Eigen::Vector3d(0, shift, 0)) *
                             Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * Eigen::Translation3d(-sensor) * T);
  };
  EXPECT_TRUE(scans.isSamePlace(T, rotated(0.049, 0.29 * scans.scale())));
  EXPECT_FALSE(scans.isSamePlace(T, rotated(0.051, 0)));
  EXPECT_FALSE(scans.isSamePlace(T, rotated(0, 0.31 * scans.scale())));
}

TEST_F(PatchPairOfARoom, FreeSpaceNeedsBothSensors)
{
  EXPECT_TRUE(pair(options_).seesFreeSpace());
  EXPECT_EQ(target_->freeSpace(), &target_->range_image);
  PatchScan blind = *target_;
  blind.range_image = RangeImage();
  EXPECT_FALSE(PatchPair(*source_, blind, options_, nullptr, Deadline()).seesFreeSpace());
  EXPECT_EQ(blind.freeSpace(), nullptr);
  EXPECT_FALSE(PatchPair(blind, *target_, options_, nullptr, Deadline()).seesFreeSpace());
}

TEST_F(PatchPairOfARoom, ThePosteriorIsThatOfWhatTheSensorsSaw)
{
  Options options = options_;
  options.patch_profile.judgement.posterior.known = 11;
  options.patch_profile.judgement.posterior_blind.known = 12;
  PatchScan blind = *target_;
  blind.range_image = RangeImage();
  EXPECT_EQ(pair(options).posteriorModel().surface.known, 11);
  EXPECT_EQ(PatchPair(*source_, blind, options, nullptr, Deadline()).posteriorModel().surface.known, 12);
}

TEST_F(PatchPairOfARoom, AScoreWeighsContradictionsAsConfigured)
{
  Options options = options_;
  options.patch_profile.judgement.evidence.contradiction_weight = 3;
  const PatchPair scans = pair(options);
  ScoredPose pose = at(motion(Eigen::Vector3d::UnitZ(), 0.2, Eigen::Vector3d(0.5, 0.2, 0)) * scans.toInner(truth_));
  for (const bool fine : {false, true}) {
    fine ? scans.scoreFine(pose) : scans.scoreCoarse(pose);
    const WeightedEvidence& patches = pose.evidence.patches;
    ASSERT_GT(patches.contradicted, 0.01 * patches.total);
    EXPECT_NEAR(pose.score, (patches.matched - 3 * patches.contradicted) / patches.total, 1e-12);
  }
}

TEST_F(PatchPairOfARoom, APoseThatPutsSensorOnSensorIsLessProbableBeforehand)
{
  Options options = options_;
  options.patch_profile.judgement.prior.sensor_on_sensor = 0.2;
  PatchScan blind = *source_;
  blind.range_image = RangeImage();
  const PatchPair scans = pair(options), unseen(blind, *target_, options, nullptr, Deadline());
  const auto log_prior = [](const PatchPair& of, const Eigen::Vector3d& offset) {
    // Any rotation about the target's sensor.
    ScoredPose pose = at(Eigen::Translation3d(of.target().viewpoint + offset) *
                         Eigen::AngleAxisd(1.3, Eigen::Vector3d(1, 2, 3).normalized()) *
                         Eigen::Translation3d(-of.source().viewpoint));
    of.scoreFine(pose);
    return pose.log_prior;
  };
  const double reach = 0.1 * scans.scale();
  EXPECT_NEAR(log_prior(scans, Eigen::Vector3d::Zero()), std::log(0.2), 1e-12);
  EXPECT_NEAR(log_prior(scans, Eigen::Vector3d(0, 0.99 * reach, 0)), std::log(0.2), 1e-12);
  EXPECT_EQ(log_prior(scans, Eigen::Vector3d(0, 1.01 * reach, 0)), 0);
  EXPECT_EQ(log_prior(unseen, Eigen::Vector3d::Zero()), 0); // where the sensors were is not known
}

TEST_F(PatchPairOfARoom, WhatIsKnownBeforehandBelongsToTheScore)
{
  const PatchPair scans(*source_, *target_, options_, &truth_, Deadline());
  ScoredPose truth = at(scans.toInner(truth_)), other = at(Eigen::Isometry3d::Identity());
  for (ScoredPose* pose : {&truth, &other}) {
    scans.scoreCoarse(*pose);
    const double coarse = pose->log_prior;
    scans.scoreFine(*pose);
    EXPECT_EQ(pose->log_prior, coarse); // of the pose alone
  }
  EXPECT_NEAR(truth.log_prior, std::log1p(PriorConfig().guess_trust), 1e-6);
  EXPECT_LT(other.log_prior, truth.log_prior - 1);
}

TEST_F(PatchPairOfARoom, NoisyScansMatchFartherThinPatchesNoNearer)
{
  const auto matchOf = [&](double thickness) {
    PatchScan source = *source_;
    source.thickness = thickness;
    const PatchPair scans(source, *target_, options_, nullptr, Deadline());
    return scans.config().preparation.match;
  };
  ASSERT_EQ(source_->scale, 1);
  const double usual = PreparationConfig().thickness;
  EXPECT_DOUBLE_EQ(matchOf(usual), PreparationConfig().match);
  EXPECT_DOUBLE_EQ(matchOf(3 * usual), 3 * PreparationConfig().match);
  PatchScan thin = *source_;
  thin.thickness = usual / 2; // of a scan prepared with another PreparationConfig::thickness
  const PatchPair scans(thin, thin, options_, nullptr, Deadline());
  EXPECT_DOUBLE_EQ(scans.config().preparation.match, PreparationConfig().match);
}

TEST_F(PatchPairOfARoom, ThePolishReachesAsFarAsPosesThatAreOneAndNoLessThanAMatch)
{
  const PreparationConfig usual;
  for (const double noise : {1., 3.5}) {
    PatchScan source = *source_;
    source.thickness = noise * usual.thickness;
    const PatchPair scans(source, *target_, options_, nullptr, Deadline());
    EXPECT_DOUBLE_EQ(scans.polishReach(), noise > 3 ? noise * usual.match : RefinementConfig().distinct_distance);
    EXPECT_DOUBLE_EQ(scans.binWidth(), usual.match); // whatever the noise
  }
}

TEST_F(PatchPairOfARoom, TheIndexReachesAsFarAsACountedMatch)
{
  Eigen::Matrix3Xf points = target_points_;
  testing::Random random(3);
  for (const double noise : {0.0, 0.06}) {
    for (Eigen::Index i = 0; i < points.size(); ++i)
      points.data()[i] += static_cast<float>(noise * random.gaussian());
    for (const float size : {1.f, 100.f}) {
      const Eigen::Matrix3Xf sized = size * points;
      const PatchScan scan = preparePatchScan(viewOfPoints(sized), options_);
      const double match = PatchPair(scan, scan, options_, nullptr, Deadline()).config().preparation.match;
      EXPECT_DOUBLE_EQ(scan.index.reach(), match) << noise << ", " << size;
      if (noise > 0) {
        EXPECT_GT(match, 1.5 * scan.scale * PreparationConfig().match) << size;
      }
    }
  }
}

TEST_F(PatchPairOfARoom, NothingOnNothing)
{
  const PatchScan empty = preparePatchScan(ScanView(), options_);
  for (const PatchPair& scans : {PatchPair(empty, *target_, options_, nullptr, Deadline()),
                                 PatchPair(*source_, empty, options_, nullptr, Deadline()),
                                 PatchPair(empty, empty, options_, nullptr, Deadline())}) {
    ScoredPose pose = at(Eigen::Isometry3d::Identity());
    scans.scoreFine(pose);
    EXPECT_LE(pose.score, 0);
    scans.polish(pose);
    ASSERT_TRUE(pose.polish);
    EXPECT_EQ(pose.polish->matches, 0);
    EXPECT_TRUE(scans.refinedFine(pose.T_target_source).matrix().allFinite());
    EXPECT_TRUE(scans.refinedCoarse(pose.T_target_source).matrix().allFinite());
  }
}

} // namespace
} // namespace pcl_ssfr::test_patch_pair
