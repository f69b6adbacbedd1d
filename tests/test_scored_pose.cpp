// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/scored_pose.h"
#include "patch_scenes.h"

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::test_scored_pose {
namespace {

constexpr double kContradictionWeight = 14;

/// Ten votes and 12 square metres; \p matched and \p contradicted votes, half of the matches facing their sensor.
SurfaceEvidence
evidenceOf(double matched, double contradicted)
{
  SurfaceEvidence e;
  e.total = 12;
  e.patches = {10, matched, contradicted};
  e.facing = {5, matched / 2, contradicted / 4, 0, matched / 8};
  return e;
}

TEST(Rate, WeighsContradictions)
{
  ScoredPose pose;
  for (const double weight : {0.0, 1.0, 14.0}) {
    rate(pose, evidenceOf(6, 0.1), weight);
    EXPECT_NEAR(pose.score, 0.6 - weight * 0.01, 1e-12);
    EXPECT_NEAR(pose.facing_score, 0.6 - weight * 0.005, 1e-12);
    EXPECT_EQ(pose.evidence.patches.matched, 6);
  }
}

TEST(Rate, MoreForItIsBetterAndMoreAgainstItWorse)
{
  testing::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const double matched = random.uniform(0, 5), contradicted = random.uniform(0, 5);
    ScoredPose pose, more, against;
    rate(pose, evidenceOf(matched, contradicted), kContradictionWeight);
    rate(more, evidenceOf(matched + random.uniform(0.01, 1), contradicted), kContradictionWeight);
    rate(against, evidenceOf(matched, contradicted + random.uniform(0.01, 1)), kContradictionWeight);
    EXPECT_GT(more.score, pose.score);
    EXPECT_LT(against.score, pose.score);
  }
}

TEST(Rate, NoSurfaceNoScore)
{
  ScoredPose pose;
  rate(pose, SurfaceEvidence(), kContradictionWeight);
  EXPECT_EQ(pose.score, 0);
  EXPECT_EQ(pose.facing_score, 0);
}

TEST(PoseDistance, OfARotationAboutTheOrigin)
{
  const double angle = 0.5;
  const Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d b(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(rotationBetween(a, b), angle, 1e-12);
  EXPECT_NEAR(translationBetween(a, b, Eigen::Vector3d(2, 0, 7)), 4 * std::sin(angle / 2), 1e-12);
  EXPECT_NEAR(translationBetween(a, b, Eigen::Vector3d(0, 0, 7)), 0, 1e-12); // on the axis
  EXPECT_EQ(rotationBetween(b, b), 0);
}

TEST(PoseDistance, IsTheSameBothWaysAndInAnyTargetFrame)
{
  testing::Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d a = testing::randomMotion(random, 20), b = testing::randomMotion(random, 20),
                            frame = testing::randomMotion(random, 100);
    const Eigen::Vector3d place(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5));
    EXPECT_NEAR(rotationBetween(a, b), rotationBetween(b, a), 1e-9);
    EXPECT_NEAR(rotationBetween(frame * a, frame * b), rotationBetween(a, b), 1e-7);
    EXPECT_NEAR(translationBetween(frame * a, frame * b, place), translationBetween(b, a, place), 1e-9);
  }
}

TEST(HeldSurface, ByHand)
{
  SurfaceEvidence e;
  HeldSurface held = heldSurface(e); // nothing matches: no direction is the third
  EXPECT_EQ(held.second, 0);
  EXPECT_EQ(held.third, 0);
  e.matched_normals = Eigen::Vector3d(3, 1, 2).asDiagonal();
  held = heldSurface(e);
  EXPECT_NEAR(held.second, 2, 1e-12);
  EXPECT_NEAR(held.third, 1, 1e-12);
  e.matched_normals(1, 1) = 0; // a corridor
  EXPECT_NEAR(heldSurface(e).third, 0, 1e-12);
  e.matched_normals = 4 * Eigen::Matrix3d::Identity(); // all of it, evenly
  EXPECT_NEAR(heldSurface(e).third, 4, 1e-12);
}

TEST(HeldSurface, ThirdIsTheMinimumOverAllDirectionsAndRotatesWithTheScene)
{
  testing::Random random(6);
  for (int trial = 0; trial < 10; ++trial) {
    SurfaceEvidence e;
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d n = testing::randomRotation(random).col(0);
      const double weight = random.uniform(0.1, 2);
      e.total += weight;
      if (random.uniform(0, 1) < 0.3 + 0.6 * std::abs(n.x())) // more of what faces x
        e.matched_normals += weight * n * n.transpose();
    }
    const HeldSurface held = heldSurface(e);
    double smallest = e.total;
    for (int i = 0; i < 20000; ++i) {
      const Eigen::Vector3d v = testing::randomRotation(random).col(0);
      smallest = std::min(smallest, v.dot(e.matched_normals * v));
    }
    EXPECT_LE(held.third, smallest + 1e-12);
    EXPECT_NEAR(held.third, smallest, 2e-3 * e.total);
    EXPECT_LE(held.third, e.total / 3);
    EXPECT_NEAR(held.second + held.third, e.matched_normals.trace() - e.matched_normals.operatorNorm(), 1e-9);
    const Eigen::Matrix3d R = testing::randomRotation(random);
    e.matched_normals = (R * e.matched_normals * R.transpose()).eval();
    const HeldSurface rotated = heldSurface(e);
    EXPECT_NEAR(rotated.second, held.second, 1e-9);
    EXPECT_NEAR(rotated.third, held.third, 1e-9);
  }
}

TEST(Describe, GivesSharesOfTheSurface)
{
  ScoredPose pose;
  SurfaceEvidence e = evidenceOf(6, 0.1);
  e.matched = 6;
  e.contradicted = 0.3;
  e.unmatched = 1.2;
  e.matched_normals = Eigen::Vector3d(3, 1, 2).asDiagonal();
  rate(pose, e, kContradictionWeight);
  pose.T_target_source.translation().x() = 3;
  pose.from_guess = true;
  const Candidate c = describe(pose);
  EXPECT_NEAR(c.overlap, 0.5, 1e-12);
  EXPECT_NEAR(c.contradiction, 0.025, 1e-12);
  EXPECT_NEAR(c.evidence.unmatched, 0.1, 1e-12);
  EXPECT_NEAR(c.evidence.patches_matched, 0.6, 1e-12);
  EXPECT_NEAR(c.evidence.patches_contradicted, 0.01, 1e-12);
  EXPECT_NEAR(c.evidence.facing_matched, 0.6, 1e-12);
  EXPECT_NEAR(c.evidence.beyond_planes, 0.15, 1e-12);
  EXPECT_EQ(c.evidence.facing_score, pose.facing_score);
  EXPECT_NEAR(c.evidence.third_direction, 1.0 / 12, 1e-12);
  EXPECT_NEAR(c.evidence.held_second, 2, 1e-12);
  EXPECT_NEAR(c.evidence.held_third, 1, 1e-12);
  EXPECT_EQ(c.evidence.clutter, pose.evidence.clutter);
  EXPECT_EQ(c.evidence.patches, 10);
  EXPECT_EQ(c.evidence.facing_patches, 5);
  EXPECT_EQ(c.probability, 0); // for the caller to fill in
  EXPECT_TRUE(c.T_target_source.isApprox(Eigen::Isometry3d::Identity(), 0));
  EXPECT_EQ(c.score, pose.score);
  EXPECT_TRUE(c.from_guess);
}

TEST(Describe, NoSurface)
{
  const Candidate c = describe(ScoredPose());
  EXPECT_EQ(c.overlap, 0);
  EXPECT_EQ(c.contradiction, 0);
  EXPECT_EQ(c.evidence.facing_matched, 0);
  EXPECT_EQ(c.evidence.beyond_planes, 0);
}

} // namespace
} // namespace pcl_ssfr::test_scored_pose
