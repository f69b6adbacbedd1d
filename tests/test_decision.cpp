// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/decision.h"
#include "made_up_matches.h"
#include "patch_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace pcl_ssfr {
namespace {

using ::testing::HasSubstr;
using testing::matchesOn;
using ::testing::MatchesRegex;
using ::testing::Not;
using testing::refinementOf;

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(), kZ = Eigen::Vector3d::UnitZ();

/// A pose that lays the source's sensor at \p place; shares of the surface that meets its like and that contradicts.
ScoredPose
poseAt(const Eigen::Vector3d& place, double matched, double contradicted = 0)
{
  SurfaceEvidence e;
  e.total = 1;
  e.matched = matched;
  e.contradicted = contradicted;
  e.unmatched = 0.1;
  e.patches = e.facing = {1, matched, contradicted};
  e.matched_normals = matched * Eigen::Matrix3d::Identity() / 3;
  e.visible_normals = (matched + contradicted + 0.1) * Eigen::Matrix3d::Identity() / 3;
  ScoredPose pose;
  pose.T_target_source = Eigen::Translation3d(place);
  rate(pose, e);
  return pose;
}

/// As polished in a room, with matches that err by \p deviation [m]: every motion is told.
Refinement
polishInARoom(double deviation = 0.01)
{
  return refinementOf(matchesOn({kX, kY, kZ}, 200, kX, 1), deviation);
}

/// As polished in a corridor along x without an end.
Refinement
polishInACorridor()
{
  return refinementOf(matchesOn({kY, kZ}, 200, kX, 2));
}

TEST(Decision, BelievesAClearPose)
{
  const Decision d = decide({poseAt(kX, 0.6), poseAt(9 * kX, 0.2)}, polishInARoom(), DecisionContext());
  EXPECT_EQ(d.status, Status::Converged);
  EXPECT_GT(d.confidence, 0.9);
  EXPECT_LE(d.confidence, 1);
  EXPECT_EQ(d.equals, 1U);
  EXPECT_TRUE(d.unobservable.empty());
  EXPECT_THAT(d.message, HasSubstr("60 % of the surface"));
}

TEST(Decision, LittleSurfaceInCommon)
{
  const Decision d = decide({poseAt(kX, 0.01), poseAt(9 * kX, 0.005)}, polishInARoom(), DecisionContext());
  EXPECT_EQ(d.status, Status::LowOverlap);
  EXPECT_LT(d.confidence, 0.6);
  EXPECT_THAT(d.message, HasSubstr("only 1 %"));
}

TEST(Decision, NamesTheDirectionThatIsNotTold)
{
  const Decision d = decide({poseAt(kX, 0.6)}, polishInACorridor(), DecisionContext());
  EXPECT_EQ(d.status, Status::Unobservable);
  EXPECT_LE(d.confidence, 0.3);
  ASSERT_EQ(d.unobservable.size(), 1U);
  EXPECT_NEAR(std::abs(d.unobservable[0].direction.x()), 1, 1e-9);
  EXPECT_THAT(d.message, HasSubstr("translation along"));
  // Little in common comes first; the direction is told all the same.
  const Decision little = decide({poseAt(kX, 0.01)}, polishInACorridor(), DecisionContext());
  EXPECT_EQ(little.status, Status::LowOverlap);
  EXPECT_EQ(little.unobservable.size(), 1U);
}

TEST(Decision, NamesTheTurnThatIsHardlyTold)
{
  const Refinement polish = polishInARoom(5); // [m]: two degrees or so
  DecisionContext context;
  const Decision d = decide({poseAt(kX, 0.6)}, polish, context);
  EXPECT_EQ(d.status, Status::Unobservable);
  ASSERT_FALSE(d.unobservable.empty());
  EXPECT_TRUE(d.unobservable[0].rotation);
  EXPECT_THAT(d.message, HasSubstr("hardly determines the rotation about"));
  // A prior tells it when it is exact enough, and of the axes that it binds.
  const auto with = [&](const Eigen::Matrix3d& prior) {
    context.rotation_prior = prior;
    return decide({poseAt(kX, 0.6)}, polish, context).status;
  };
  const double exact = 1 / (0.003 * 0.003), rough = 1 / (0.1 * 0.1); // [1/rad^2]
  EXPECT_EQ(with(exact * Eigen::Matrix3d::Identity()), Status::Converged);
  EXPECT_EQ(with(rough * Eigen::Matrix3d::Identity()), Status::Unobservable);
  EXPECT_EQ(with(exact * (Eigen::Matrix3d::Identity() - kZ * kZ.transpose())), Status::Unobservable); // not the heading
}

TEST(Decision, NothingIsSaidOfDirectionsBeforeThePolish)
{
  const Decision d = decide({poseAt(kX, 0.6)}, Refinement(), DecisionContext());
  EXPECT_EQ(d.status, Status::Converged);
  EXPECT_TRUE(d.unobservable.empty());
}

TEST(Decision, TwoThatExplainTheScansAlike)
{
  ScoredPose rival = poseAt(kX + 6.5 * kY, 0.59);
  rival.T_target_source.linear() = Eigen::AngleAxisd(0.5 * 3.14159265358979, kZ).toRotationMatrix();
  DecisionContext context;
  const Decision d = decide({poseAt(kX, 0.6), rival}, polishInARoom(), context);
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_EQ(d.equals, 2U);
  EXPECT_LE(d.confidence, 0.5);
  EXPECT_THAT(d.message, HasSubstr("2 distinct poses"));
  EXPECT_THAT(d.message, HasSubstr("6.50 m and 90.0 degrees away"));
  // The guess may tell them apart.
  context.guess_decides = true;
  EXPECT_EQ(decide({poseAt(kX, 0.6), rival}, polishInARoom(), context).status, Status::Converged);
}

TEST(Decision, WithoutFreeSpaceARivalNeedsLess)
{
  const std::vector<ScoredPose> poses = {poseAt(kX, 0.6), poseAt(9 * kX, 0.56)};
  DecisionContext context;
  EXPECT_EQ(decide(poses, polishInARoom(), context).equals, 1U);
  context.free_space = false;
  EXPECT_EQ(decide(poses, polishInARoom(), context).equals, 2U);
}

TEST(Decision, OneThatMatchesMoreButIsContradictedALittle)
{
  EXPECT_EQ(decide({poseAt(kX, 0.6), poseAt(9 * kX, 0.63, 0.005)}, polishInARoom(), DecisionContext()).equals, 2U);
  EXPECT_EQ(decide({poseAt(kX, 0.6), poseAt(9 * kX, 0.55)}, polishInARoom(), DecisionContext()).equals, 1U);
}

TEST(Decision, ThreeThatComeNearMakeARepeatedScene)
{
  const std::vector<ScoredPose> two = {poseAt(kX, 0.6), poseAt(9 * kX, 0.55)};
  std::vector<ScoredPose> three = two;
  three.push_back(poseAt(-9 * kX, 0.55));
  EXPECT_EQ(decide(two, polishInARoom(), DecisionContext()).equals, 1U);
  const Decision d = decide(three, polishInARoom(), DecisionContext());
  EXPECT_EQ(d.equals, 3U);
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_LE(d.confidence, 1.0 / 3);
}

TEST(Decision, APoseThatLaysSensorOnSensorIsDoubtedEarlier)
{
  DecisionContext context;
  const std::vector<ScoredPose> apart = {poseAt(kX, 0.6), poseAt(9 * kX, 0.53)};
  const std::vector<ScoredPose> together = {poseAt(0.05 * kX, 0.6), poseAt(9 * kX, 0.53)};
  EXPECT_EQ(decide(apart, polishInARoom(), context).equals, 1U);
  EXPECT_EQ(decide(together, polishInARoom(), context).equals, 2U);
  context.free_space = false; // where the sensors are is not known
  EXPECT_EQ(decide(together, polishInARoom(), context).equals, 1U);
  // Still earlier where little tells the place along some direction.
  context.free_space = true;
  Refinement weak = polishInACorridor();
  weak.hessian(3, 3) = 2; // of 200 along the others
  const std::vector<ScoredPose> far_behind = {poseAt(0.05 * kX, 0.6), poseAt(9 * kX, 0.35)};
  EXPECT_EQ(decide(far_behind, polishInARoom(), context).equals, 1U);
  EXPECT_EQ(decide(far_behind, weak, context).equals, 2U);
}

TEST(Decision, ARivalThatTakesAwayTheConfidence)
{
  const Decision d =
      decide({poseAt(kX, 0.2, 0.009), poseAt(9 * kX, 0.19, 0.00855)}, polishInARoom(), DecisionContext());
  EXPECT_EQ(d.equals, 1U);
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_THAT(d.message, HasSubstr("nearly as well: the strongest rival lies 8.00 m"));
  EXPECT_EQ(decide({poseAt(kX, 0.2, 0.009)}, polishInARoom(), DecisionContext()).status, Status::Converged);
}

TEST(Decision, LessConfidenceThanIsAskedFor)
{
  DecisionContext context;
  context.min_confidence = 1;
  const Decision sure = decide({poseAt(kX, 0.6)}, polishInARoom(), context);
  EXPECT_EQ(sure.status, Status::LowOverlap);
  EXPECT_GT(sure.confidence, 0.99);
  EXPECT_THAT(sure.message, HasSubstr("that is asked for: 60 % of the surface meets its counterpart"));
  EXPECT_THAT(sure.message, HasSubstr("confidence 0.9")); // not 1.00
  EXPECT_THAT(sure.message, Not(HasSubstr("same place")));
  const double confidence = decide({poseAt(kX, 0.3, 0.017)}, polishInARoom(), DecisionContext()).confidence;
  ASSERT_GT(confidence, 0.1);
  ASSERT_LT(confidence, 0.95);
  context.min_confidence = confidence + 0.04;
  EXPECT_THAT(decide({poseAt(kX, 0.3, 0.017)}, polishInARoom(), context).message,
              MatchesRegex("confidence 0\\.[0-9][0-9] is less than the 0\\.[0-9]+ that .*"));
}

TEST(Decision, NextToNoSurfaceInCommonIsNeverBelieved)
{
  // However clear it looks, and however little confidence is asked for.
  DecisionContext context;
  for (const double least : {0.7, 0.1, 0.0}) {
    context.min_confidence = least;
    const Decision d = decide({poseAt(kX, 0.04)}, polishInARoom(), context);
    EXPECT_EQ(d.status, Status::LowOverlap);
    EXPECT_LE(d.confidence, 0.3);
    EXPECT_THAT(d.message, HasSubstr("only 4 % of the surface"));
    EXPECT_EQ(decide({poseAt(kX, 0.06)}, polishInARoom(), context).status, Status::Converged);
  }
}

TEST(Decision, SurfaceInFreeSpace)
{
  const Decision d = decide({poseAt(kX, 0.5, 0.1)}, polishInARoom(), DecisionContext());
  EXPECT_EQ(d.status, Status::Contradicted);
  EXPECT_EQ(d.confidence, 0);
  EXPECT_THAT(d.message, HasSubstr("10.0 % of the surface into space"));
}

TEST(Decision, PlanesInTooFewDirections)
{
  DecisionContext context;
  context.few_directions = "the source scan has planes in fewer than two directions";
  const Decision d = decide({poseAt(kX, 0.01)}, polishInARoom(), context);
  EXPECT_EQ(d.status, Status::TooFewDirections);
  EXPECT_THAT(d.message, HasSubstr(context.few_directions));
  // What stands on the plane may tell it all the same.
  EXPECT_EQ(decide({poseAt(kX, 0.6)}, polishInARoom(), context).status, Status::Converged);
}

TEST(Decision, NoEvidenceAtAll)
{
  const Decision d = decide({ScoredPose()}, Refinement(), DecisionContext());
  EXPECT_EQ(d.status, Status::LowOverlap);
  EXPECT_EQ(d.confidence, 0);
}

TEST(Decision, BelievesOnlyWhatItIsSureOfAndForAnyUnitOfLength)
{
  testing::Random random(4);
  int believed = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<ScoredPose> poses, larger;
    for (int k = random.index(6); k >= 0; --k)
      poses.push_back(poseAt(Eigen::Vector3d(random.uniform(-9, 9), 0, random.uniform(-9, 9)),
                             random.uniform(0, 0.8),
                             random.uniform(0, 0.01)));
    sortByScore(poses);
    DecisionContext context;
    context.free_space = random.index(4) > 0;
    context.guess_decides = random.index(4) == 0;
    const Refinement polish = random.index(4) ? polishInARoom() : polishInACorridor();
    const Decision d = decide(poses, polish, context);
    ASSERT_TRUE(d.confidence >= 0 && d.confidence <= 1);
    ASSERT_FALSE(d.message.empty());
    ASSERT_GE(d.equals, 1U);
    ASSERT_LE(d.equals, poses.size());
    if (d.status == Status::Converged) {
      ++believed;
      ASSERT_GE(d.confidence, context.min_confidence);
      ASSERT_TRUE(d.unobservable.empty());
      ASSERT_TRUE(d.equals == 1 || context.guess_decides);
    }
    // The same scene, ten times as large.
    larger = poses;
    for (ScoredPose& pose : larger)
      pose.T_target_source.translation() *= 10;
    Refinement wide = polish;
    wide.rms *= 10;
    wide.hessian.topLeftCorner<3, 3>() *= 100;
    wide.hessian.topRightCorner<3, 3>() *= 10;
    wide.hessian.bottomLeftCorner<3, 3>() *= 10;
    context.scale *= 10;
    context.noise_floor *= 10;
    const Decision again = decide(larger, wide, context);
    ASSERT_EQ(again.status, d.status);
    ASSERT_EQ(again.confidence, d.confidence);
  }
  EXPECT_GT(believed, kTrials / 10);
  EXPECT_LT(believed, kTrials * 9 / 10);
}

} // namespace
} // namespace pcl_ssfr
