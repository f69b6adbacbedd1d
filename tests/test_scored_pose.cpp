// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/scored_pose.h"
#include "patch_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace pcl_ssfr {
namespace {

/// Ten voices and 12 square metres; \p matched and \p contradicted voices, half of each facing their sensor.
SurfaceEvidence
evidenceOf(double matched, double contradicted)
{
  SurfaceEvidence e;
  e.total = 12;
  e.patches = {10, matched, contradicted};
  e.facing = {5, matched / 2, contradicted / 4};
  return e;
}

TEST(Rate, CountsContradictionsFourteenTimes)
{
  ScoredPose pose;
  rate(pose, evidenceOf(6, 0.1));
  EXPECT_NEAR(pose.score, 0.6 - 14 * 0.01, 1e-12);
  EXPECT_NEAR(pose.facing_score, 0.6 - 14 * 0.005, 1e-12);
  EXPECT_EQ(pose.evidence.patches.matched, 6);
}

TEST(Rate, MoreForItIsBetterAndMoreAgainstItWorse)
{
  testing::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const double matched = random.uniform(0, 5), contradicted = random.uniform(0, 5);
    ScoredPose pose, more, against;
    rate(pose, evidenceOf(matched, contradicted));
    rate(more, evidenceOf(matched + random.uniform(0.01, 1), contradicted));
    rate(against, evidenceOf(matched, contradicted + random.uniform(0.01, 1)));
    EXPECT_GT(more.score, pose.score);
    EXPECT_LT(against.score, pose.score);
  }
}

TEST(Rate, NoSurfaceNoScore)
{
  ScoredPose pose;
  rate(pose, SurfaceEvidence());
  EXPECT_EQ(pose.score, 0);
  EXPECT_EQ(pose.facing_score, 0);
}

TEST(SortByScore, BestFirstAndEqualsInTheirOrder)
{
  testing::Random random(2);
  std::vector<ScoredPose> poses(300);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].score = random.index(20) - 10;
    poses[i].facing_score = static_cast<double>(i); // where it stood
  }
  sortByScore(poses);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    ASSERT_GE(poses[i - 1].score, poses[i].score);
    if (poses[i - 1].score == poses[i].score) {
      ASSERT_LT(poses[i - 1].facing_score, poses[i].facing_score);
    }
  }
  std::vector<ScoredPose> none;
  sortByScore(none);
  EXPECT_TRUE(none.empty());
}

TEST(PoseDistance, OfATurnAboutTheOrigin)
{
  const double turn = 0.5;
  const Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d b(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(turnBetween(a, b), turn, 1e-12);
  EXPECT_NEAR(shiftBetween(a, b, Eigen::Vector3d(2, 0, 7)), 4 * std::sin(turn / 2), 1e-12);
  EXPECT_NEAR(shiftBetween(a, b, Eigen::Vector3d(0, 0, 7)), 0, 1e-12); // on the axis
  EXPECT_EQ(turnBetween(b, b), 0);
}

TEST(PoseDistance, IsTheSameBothWaysAndInAnyTargetFrame)
{
  testing::Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d a = testing::randomMotion(random, 20), b = testing::randomMotion(random, 20),
                            frame = testing::randomMotion(random, 100);
    const Eigen::Vector3d place(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5));
    EXPECT_NEAR(turnBetween(a, b), turnBetween(b, a), 1e-9);
    EXPECT_NEAR(turnBetween(frame * a, frame * b), turnBetween(a, b), 1e-7);
    EXPECT_NEAR(shiftBetween(frame * a, frame * b, place), shiftBetween(b, a, place), 1e-9);
  }
}

TEST(Describe, TellsSharesOfTheSurface)
{
  ScoredPose pose;
  SurfaceEvidence e = evidenceOf(6, 0.1);
  e.matched = 6;
  e.contradicted = 0.3;
  e.unmatched = 1.2;
  e.matched_normals = Eigen::Vector3d(3, 1, 2).asDiagonal();
  e.visible_normals = Eigen::Vector3d(4, 2, 2).asDiagonal();
  rate(pose, e);
  pose.from_guess = true;
  const Candidate c = describe(pose);
  EXPECT_NEAR(c.overlap, 0.5, 1e-12);
  EXPECT_NEAR(c.contradiction, 0.025, 1e-12);
  EXPECT_NEAR(c.evidence.unmatched, 0.1, 1e-12);
  EXPECT_NEAR(c.evidence.patches_matched, 0.6, 1e-12);
  EXPECT_NEAR(c.evidence.patches_contradicted, 0.01, 1e-12);
  EXPECT_NEAR(c.evidence.facing_matched, 0.6, 1e-12);
  EXPECT_EQ(c.evidence.facing_score, pose.facing_score);
  EXPECT_NEAR(c.evidence.third_direction, 1.0 / 12, 1e-12);
  EXPECT_NEAR(c.evidence.weakest_direction, 0.5, 1e-12);
  EXPECT_EQ(c.score, pose.score);
  EXPECT_TRUE(c.from_guess);
}

TEST(Describe, NoSurface)
{
  const Candidate c = describe(ScoredPose());
  EXPECT_EQ(c.overlap, 0);
  EXPECT_EQ(c.contradiction, 0);
  EXPECT_EQ(c.evidence.facing_matched, 0);
}

} // namespace
} // namespace pcl_ssfr
