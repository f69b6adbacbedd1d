// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/pose_refinement.h"

#include "judgement/posterior.h"
#include "pose_matchers.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace pcl_ssfr::test_pose_refinement {
namespace {

using testing::viewOfPoints;

/// \p T moved by \p metres along x of the target's frame.
Eigen::Isometry3d
moved(const Eigen::Isometry3d& T, double metres)
{
  return Eigen::Translation3d(metres, 0, 0) * T;
}

/// Two scans, prepared, and the pose between them.
struct TwoScans {
  TwoScans(const testing::Scene& scene,
           const Eigen::Isometry3d& T_world_source,
           const Eigen::Isometry3d& T_world_target,
           double step)
      : source(prepared(scene, T_world_source, step, 12)), target(prepared(scene, T_world_target, step, 11)),
        T_target_source(testing::relativePose(T_world_target, T_world_source))
  {}

  static PatchScan
  prepared(const testing::Scene& scene, const Eigen::Isometry3d& T_world_sensor, double step, std::uint64_t seed)
  {
    return preparePatchScan(viewOfPoints(testing::castScan(scene, T_world_sensor, testing::roomScanner(step), seed)),
                            Options());
  }

  PatchScan source, target;
  Eigen::Isometry3d T_target_source; ///< between the sensors' frames
};

/// A furnished room, prepared once for all tests.
class PosesOfARoom : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    const testing::Scene scene = testing::makeFurnishedRoom(1);
    scans_ = new TwoScans(scene,
                          testing::sensorPose(scene.stations.at(1), 1.85, 0.2),
                          testing::sensorPose(scene.stations.at(0), 0.1),
                          0.0262);
  }

  static void
  TearDownTestSuite()
  {
    delete scans_;
    scans_ = nullptr;
  }

  PatchPair
  pair() const
  {
    return PatchPair(scans_->source, scans_->target, options_, nullptr, Deadline());
  }

  /// A pose this far from the truth, with a score.
  static ScoredPose
  scored(const PatchPair& pair, double metres)
  {
    ScoredPose pose;
    pose.T_target_source = moved(pair.toInner(scans_->T_target_source), metres);
    pair.scoreFine(pose);
    return pose;
  }

  static inline TwoScans* scans_ = nullptr;
  Options options_;
  std::vector<StageReport> reports_;
  StageLog stages_ = StageLog(reports_);
};

TEST_F(PosesOfARoom, TheMoreProbableOneStandsForThoseNearIt)
{
  const PatchPair scans = pair();
  const double apart = scans.config().refinement.distinct_distance;
  const std::vector<ScoredPose> poses = {
      scored(scans, 2 * apart), scored(scans, 0.5 * apart), scored(scans, 0), scored(scans, 2.2 * apart)};
  const std::vector<ScoredPose> kept = keepDistinct(scans, poses, 10);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].T_target_source.matrix(), poses[2].T_target_source.matrix());
  EXPECT_GT(kept[0].score, kept[1].score);
  EXPECT_EQ(keepDistinct(scans, poses, 1).size(), 1U);
  EXPECT_TRUE(keepDistinct(scans, poses, 0).empty());
  EXPECT_TRUE(keepDistinct(scans, {}, 10).empty());
}

TEST_F(PosesOfARoom, ABatchIsRefinedToTheTruth)
{
  const PatchPair scans = pair();
  const Eigen::Isometry3d truth = scans.toInner(scans_->T_target_source);
  HypothesisBatch batch;
  batch.distinct = 8;
  batch.poses = {moved(truth, 3), moved(truth, 0.2 * scans.scale()), moved(truth, -1e6)};
  const std::vector<ScoredPose> poses = refineAndMerge(scans, batch, {}, stages_);
  ASSERT_FALSE(poses.empty());
  EXPECT_LT(translationBetween(poses[0].T_target_source, truth, scans_->source.viewpoint), 0.03);
  EXPECT_GT(poses[0].score, scored(scans, 0.2 * scans.scale()).score);
  // What meets nothing is no pose.
  for (const ScoredPose& pose : poses)
    EXPECT_LT((pose.T_target_source.translation() - truth.translation()).norm(), 100);
  EXPECT_TRUE(refineAndMerge(scans, HypothesisBatch(), {}, stages_).empty());
}

TEST_F(PosesOfARoom, WhatIsPolishedStandsForWhatLeadsToItAgain)
{
  const PatchPair scans = pair();
  ScoredPose known = scored(scans, 0);
  scans.polish(known);
  HypothesisBatch batch;
  batch.distinct = 8;
  batch.poses = {moved(known.T_target_source, 0.05 * scans.scale())};
  const std::vector<ScoredPose> poses = refineAndMerge(scans, batch, {known}, stages_);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_TRUE(poses[0].polish);
  EXPECT_EQ(poses[0].T_target_source.matrix(), known.T_target_source.matrix());
}

TEST_F(PosesOfARoom, LeadersArePolishedDownToTheOddsOfARival)
{
  const PatchPair scans = pair();
  std::vector<ScoredPose> poses = keepDistinct(scans, {scored(scans, 0), scored(scans, 1.0), scored(scans, -1.2)}, 10);
  ASSERT_EQ(poses.size(), 3U);
  // Given the same weight as the best one, the second is a rival; the third is not.
  poses[1].log_prior -= logOdds(poses[1], poses[0], scans.posteriorModel());
  poses[2].log_prior -= logOdds(poses[2], poses[0], scans.posteriorModel());
  poses[2].log_prior += 1.01 * std::log(1 - scans.config().judgement.decided);
  const std::vector<ScoredPose> polished = polishLeaders(scans, poses, stages_);
  ASSERT_FALSE(polished.empty());
  EXPECT_TRUE(polished[0].polish);
  EXPECT_GT(polished[0].polish->matches, 0U);
  EXPECT_LT(rotationBetween(polished[0].T_target_source, scans.toInner(scans_->T_target_source)), 0.003);
  const auto third = std::find_if(polished.begin(), polished.end(), [&](const ScoredPose& pose) {
    return pose.T_target_source.matrix() == poses[2].T_target_source.matrix();
  });
  ASSERT_NE(third, polished.end()); // as it was
  EXPECT_FALSE(third->polish);
  EXPECT_GT(uncertaintyOf(scans, polished[0]).information.norm(), 0);
  EXPECT_EQ(uncertaintyOf(scans, *third).information.norm(), 0);
}

TEST_F(PosesOfARoom, WhenALeaderLosesByItsPolishTheNextIsPolished)
{
  const PatchPair scans = pair();
  const PosteriorModel model = scans.posteriorModel();
  ScoredPose leader = scored(scans, 0.2 * scans.scale()), other = scored(scans, 1.0);
  // The other one has the lead over the first where the polish of that ends, and is no rival of it before: the first is
  // scored again when it moves.
  const ScoredPose truth = scored(scans, 0);
  other.log_prior += 5 + logOdds(truth, other, model);
  leader.log_prior += 20 + logOdds(other, leader, model);
  ASSERT_LT(logOdds(other, leader, model), -19);
  ASSERT_LT(logOdds(truth, other, model), -4);
  const std::vector<ScoredPose> polished = polishLeaders(scans, {leader, other}, stages_);
  ASSERT_EQ(polished.size(), 2U);
  EXPECT_TRUE(scans.isSamePlace(polished[0].T_target_source, other.T_target_source)) << "it leads";
  EXPECT_TRUE(polished[0].polish) << "and is polished";
  EXPECT_TRUE(scans.isSamePlace(polished[1].T_target_source, truth.T_target_source));
  EXPECT_TRUE(polished[1].polish);
}

TEST_F(PosesOfARoom, WhatWillNotBeAcceptedIsNotMadeMoreExact)
{
  const auto polished = [&] {
    const PatchPair scans = pair();
    std::vector<ScoredPose> poses = {scored(scans, 0.05 * scans.scale()), scored(scans, 1.0)};
    poses[1].log_prior += logOdds(poses[0], poses[1], scans.posteriorModel()) - 0.01; // a rival, just behind
    const Eigen::Matrix4d start = poses[0].T_target_source.matrix();
    poses = polishLeaders(scans, poses, stages_);
    EXPECT_TRUE(poses[0].polish);
    EXPECT_GT(uncertaintyOf(scans, poses[0]).information.norm(), 0);
    return std::make_pair(poses, poses[0].T_target_source.matrix() == start);
  };
  const auto [likely, likely_stays] = polished();
  EXPECT_FALSE(likely_stays);
  EXPECT_TRUE(likely[1].polish);
  PosteriorConfig& posterior = options_.patch_profile.judgement.posterior;
  posterior.known -= 50; // "none of them" is far more probable
  const auto [unlikely, unlikely_stays] = polished();
  EXPECT_TRUE(unlikely_stays);
  ASSERT_EQ(unlikely.size(), 2U); // no other optimum was looked for
  EXPECT_FALSE(unlikely[1].polish);
}

/// A corridor between rows of fins that repeat: one period along it, the same surfaces meet again.
TEST(NeighbouringOptima, AreRivalsOfTheBestPose)
{
  constexpr double kPeriod = 1;
  testing::Scene scene;
  testing::Box corridor;
  corridor.centre = Eigen::Vector3d(0, 0, 1.5);
  corridor.half_size = Eigen::Vector3d(15, 1.6, 1.5);
  corridor.inward = true;
  scene.boxes.push_back(corridor);
  for (int k = -14; k <= 14; ++k)
    for (const double side : {-1.45, 1.45})
      scene.addBlock({k * kPeriod, side, 0}, {0.3, 0.3, 3});
  const TwoScans scans(
      scene, testing::sensorPose({0.5, 0.1, 1.4}, 0.05), testing::sensorPose({-0.5, -0.1, 1.5}, 0), 0.0175);
  Options options;
  RefinementConfig& config = options.patch_profile.refinement;
  config.explored_deviation = 0; // along every motion, however well it seems to be known
  options.patch_profile.judgement.decided = 1 - 1e-6;
  config.distinct_distance =
      0.9 * kPeriod / PatchPair(scans.source, scans.target, options, nullptr, Deadline()).scale();
  const PatchPair pair(scans.source, scans.target, options, nullptr, Deadline());
  ScoredPose truth;
  truth.T_target_source = pair.toInner(scans.T_target_source);
  pair.scoreFine(truth);
  std::vector<StageReport> reports;
  StageLog stages(reports);
  const std::vector<ScoredPose> poses = polishLeaders(pair, {truth}, stages);
  for (const double shift : {-kPeriod, 0.0, kPeriod}) { // one of them is the best
    const Eigen::Isometry3d alias = moved(truth.T_target_source, shift);
    EXPECT_TRUE(std::any_of(poses.begin(), poses.end(), [&](const ScoredPose& pose) {
      return pose.polish && translationBetween(pose.T_target_source, alias, scans.source.viewpoint) < 0.1;
    })) << shift;
  }
  const Posterior posterior = computePosterior(poses, pair.posteriorModel());
  EXPECT_LT(posterior.poses[0], 1 - posterior.none);

  // Where every motion is determined well enough, none is looked for.
  config.explored_deviation = 1;
  const PatchPair sure(scans.source, scans.target, options, nullptr, Deadline());
  EXPECT_EQ(polishLeaders(sure, {truth}, stages).size(), 1U);
}

} // namespace
} // namespace pcl_ssfr::test_pose_refinement
