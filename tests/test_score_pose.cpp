// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Scoring a given pose, and the distance that is suggested to a refiner.

#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/pipeline.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::test_score_pose {
namespace {

using namespace pcl_ssfr::testing;
using ::testing::HasSubstr;

/// Two scans of a furnished room, prepared and registered once for all tests.
class ScorePose : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    const Scene scene = makeFurnishedRoom(1);
    const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
    const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(1), 1.85, 0.2);
    scans_ = new Scans;
    scans_->source = castScan(scene, T_world_source, roomScanner(0.0262), 12);
    scans_->target = castScan(scene, T_world_target, roomScanner(0.0262), 11);
    scans_->truth = relativePose(T_world_target, T_world_source);
    for (const Profile profile : {Profile::Default, Profile::Paper2017}) {
      Prepared& prepared = scans_->prepared[profile == Profile::Default ? 0 : 1];
      prepared.options = makeOptions(profile);
      prepared.source = prepareScan(viewOfPoints(scans_->source), prepared.options);
      prepared.target = prepareScan(viewOfPoints(scans_->target), prepared.options);
      prepared.result = registerScans(prepared.source, prepared.target, prepared.options);
    }
  }

  static void
  TearDownTestSuite()
  {
    delete scans_;
    scans_ = nullptr;
  }

  struct Prepared {
    Options options;
    PreparedScan source, target;
    Result result;
  };
  struct Scans {
    Eigen::Matrix3Xf source, target;
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    Prepared prepared[2]; ///< default profile, the paper's
  };

  static const Prepared&
  of(Profile profile)
  {
    return scans_->prepared[profile == Profile::Default ? 0 : 1];
  }

  static Candidate
  scored(const Eigen::Isometry3d& T, Profile profile = Profile::Default)
  {
    return scorePose(of(profile).source, of(profile).target, of(profile).options, T);
  }

  static inline Scans* scans_ = nullptr;
};

TEST_F(ScorePose, GivesTheCandidatesOfARegistrationTheirScores)
{
  for (const Profile profile : {Profile::Default, Profile::Paper2017}) {
    const Result& result = of(profile).result;
    ASSERT_EQ(result.status, Status::Converged) << result.message;
    for (const Candidate& candidate : result.candidates) {
      const Candidate again = scored(candidate.T_target_source, profile);
      EXPECT_EQ(again.T_target_source.matrix(), candidate.T_target_source.matrix());
      EXPECT_NEAR(again.score, candidate.score, 1e-3);
      EXPECT_NEAR(again.overlap, candidate.overlap, 1e-3);
      EXPECT_NEAR(again.contradiction, candidate.contradiction, 1e-3);
      EXPECT_NEAR(again.evidence.facing_score, candidate.evidence.facing_score, 1e-3);
      EXPECT_EQ(again.probability, 0);
    }
    EXPECT_NEAR(scored(result.T_target_source, profile).rmse, result.rmse, 0.01 * result.rmse);
  }
}

TEST_F(ScorePose, APoseNearTheTruthScoresLess)
{
  const Candidate right = scored(scans_->truth);
  EXPECT_GT(right.score, 0.5);
  EXPECT_LT(right.rmse, 0.03);
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(0.3, 0, 0), Eigen::Vector3d(0, 0.3, 0.2)})
    EXPECT_LT(scored(Eigen::Translation3d(shift) * scans_->truth).score, 0.8 * right.score);
  const Eigen::Isometry3d rotated = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()) * scans_->truth;
  EXPECT_LT(scored(rotated).score, 0.8 * right.score);
  // A centimetre is within what counts as a match, but the planes lie farther apart.
  EXPECT_GT(scored(Eigen::Translation3d(0.02, 0.02, 0.02) * scans_->truth).rmse, 1.2 * right.rmse);
}

TEST_F(ScorePose, SameBitsForAnyNumberOfThreads)
{
  const Prepared& scans = of(Profile::Default);
  const Candidate one = scored(scans_->truth);
  for (const unsigned threads : {2U, 8U}) {
    Options options = scans.options;
    options.threads = threads;
    const Candidate many = scorePose(scans.source, scans.target, options, scans_->truth);
    EXPECT_EQ(std::memcmp(&one.score, &many.score, sizeof(double)), 0);
    EXPECT_EQ(std::memcmp(&one.rmse, &many.rmse, sizeof(double)), 0);
  }
}

TEST_F(ScorePose, NothingSpeaksForAPoseOfAnEmptyScan)
{
  for (const Profile profile : {Profile::Default, Profile::Paper2017}) {
    const Prepared& scans = of(profile);
    const PreparedScan empty = prepareScan(ScanView(), scans.options);
    for (const Candidate& candidate : {scorePose(empty, scans.target, scans.options, scans_->truth),
                                       scorePose(scans.source, empty, scans.options, scans_->truth),
                                       scorePose(empty, empty, scans.options, scans_->truth)}) {
      EXPECT_EQ(candidate.score, 0);
      EXPECT_EQ(candidate.overlap, 0);
      EXPECT_EQ(candidate.rmse, 0);
      EXPECT_EQ(candidate.T_target_source.matrix(), scans_->truth.matrix());
    }
  }
}

TEST_F(ScorePose, FarFromTheTargetNothingMeets)
{
  const Candidate far = scored(Eigen::Translation3d(1000, 0, 0) * scans_->truth);
  EXPECT_EQ(far.overlap, 0);
  EXPECT_EQ(far.rmse, 0);
  EXPECT_LE(far.score, 0);
}

/// What scorePose() says is wrong.
std::string
errorOf(const PreparedScan& source, const PreparedScan& target, const Options& options, const Eigen::Isometry3d& T)
{
  try {
    scorePose(source, target, options, T);
  }
  catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST_F(ScorePose, SaysWhatIsWrong)
{
  const Prepared& scans = of(Profile::Default);
  const Prepared& paper = of(Profile::Paper2017);
  const Eigen::Isometry3d& T = scans_->truth;
  EXPECT_EQ(errorOf(scans.source, scans.target, scans.options, T), "");
  EXPECT_EQ(errorOf(PreparedScan(), scans.target, scans.options, T), "the source scan was not prepared");
  EXPECT_EQ(errorOf(scans.source, PreparedScan(), scans.options, T), "the target scan was not prepared");
  EXPECT_THAT(errorOf(scans.source, paper.target, scans.options, T), HasSubstr("another profile"));
  EXPECT_THAT(errorOf(scans.source, scans.target, paper.options, T), HasSubstr("another profile"));
  const PreparedScan late = prepareScan(viewOfPoints(scans_->target), scans.options, Deadline::after(1e-9));
  ASSERT_FALSE(late.isComplete());
  EXPECT_THAT(errorOf(scans.source, late, scans.options, T), HasSubstr("the target scan was not complete"));
  Options options = scans.options;
  options.leaf = -1;
  EXPECT_THAT(errorOf(scans.source, scans.target, options, T), HasSubstr("leaf = -1"));

  Eigen::Isometry3d wrong = T;
  wrong(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errorOf(scans.source, scans.target, scans.options, wrong), "T_target_source(1, 3) = nan, must be finite");
  wrong = T;
  wrong(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(errorOf(scans.source, scans.target, scans.options, wrong), "T_target_source(0, 0) = inf, must be finite");
  wrong = T;
  wrong.linear() *= 1.1;
  EXPECT_THAT(errorOf(scans.source, scans.target, scans.options, wrong), HasSubstr("no rotation"));
  wrong = T;
  wrong.linear().col(0) *= -1; // a mirror
  EXPECT_THAT(errorOf(scans.source, scans.target, scans.options, wrong), HasSubstr("no rotation"));
}

TEST_F(ScorePose, ARefinerReachesAsFarAsNoiseAndSpacingNeed)
{
  const Result& result = of(Profile::Default).result;
  EXPECT_GT(result.correspondence_distance, 3 * result.rmse);
  EXPECT_LT(result.correspondence_distance, 0.3);
  EXPECT_EQ(of(Profile::Paper2017).result.correspondence_distance, 0);
  EXPECT_EQ(Result().correspondence_distance, 0);
}

} // namespace
} // namespace pcl_ssfr::test_score_pose
