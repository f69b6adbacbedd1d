// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/angles.h"
#include "patch_scenes.h"
#include "pose_matchers.h"
#include "search/plan_search.h"
#include "searched_scans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace pcl_ssfr::test_plan_search {
namespace {

using Eigen::Vector3d;

TEST(PairedAxes, AreEachOfTheBestWithEachOfTheBest)
{
  const std::vector<MainNormal> source = {
      {Vector3d::UnitX(), 1}, {Vector3d::UnitZ(), 10}, {Vector3d::UnitY(), 3}, {Vector3d(0.6, 0.8, 0), 2.5}};
  const std::vector<MainNormal> target = {{Vector3d::UnitY(), 4}, {Vector3d::UnitX(), 0.5}};
  const std::vector<AxisPair> pairs = pairAxes(source, {target.front()}, SearchConfig());
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].source, Vector3d::UnitZ());
  EXPECT_EQ(pairs[1].source, Vector3d::UnitY());
  EXPECT_EQ(pairs[0].target, Vector3d::UnitY());
  SearchConfig config;
  config.sweep_axes = 3;
  EXPECT_EQ(pairAxes(source, target, config).size(), 6U);
  config.sweep_axes = 1;
  EXPECT_EQ(pairAxes(source, target, config).size(), 1U);
  EXPECT_TRUE(pairAxes(source, {}, config).empty());
  EXPECT_TRUE(pairAxes({}, target, config).empty());
}

TEST(PairedAxes, OppositeInBothScansAreOne)
{
  const std::vector<MainNormal> both_signs = {{Vector3d::UnitZ(), 2}, {-Vector3d::UnitZ(), 2}};
  const std::vector<AxisPair> pairs = pairAxes(both_signs, both_signs, SearchConfig());
  ASSERT_EQ(pairs.size(), 2U); // the same side up, and upside down
  EXPECT_EQ(pairs[0].source, pairs[1].source);
  EXPECT_EQ(pairs[0].target, -pairs[1].target);
}

/// An open place: ground, and boards that face every way, so that the ground's is the only main normal.
std::vector<testing::Rectangle>
openPlace()
{
  testing::Random random(4);
  std::vector<testing::Rectangle> rectangles = {{Vector3d(0, 0, 0), Vector3d(22, 0, 0), Vector3d(0, 22, 0)}};
  for (int i = 0; i < 40; ++i) {
    const double heading = random.uniform(-kPi, kPi);
    const double distance = random.uniform(4, 20), around = random.uniform(-kPi, kPi);
    const double height = random.uniform(0.5, 1.5);
    rectangles.push_back({Vector3d(distance * std::cos(around), distance * std::sin(around), height),
                          Vector3d(std::cos(heading), std::sin(heading), 0),
                          Vector3d(0, 0, height)});
  }
  return rectangles;
}

testing::SearchedScan
makeScan(const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed)
{
  const Vector3d up = T_world_sensor.linear().transpose() * Vector3d::UnitZ();
  return testing::makeSearchedScan(openPlace(), T_world_sensor, {{up, 1}}, {40, 0.1, 0.02, 0.03}, seed);
}

class PlanSearch : public ::testing::Test {
protected:
  PlanSearch() { options_.reach = 20; }

  std::vector<PoseHypothesis>
  search(bool with_image = true) const
  {
    return searchPlans({source_.patches.samples, no_points_},
                       source_.votes,
                       {target_.patches.samples, no_points_},
                       target_.index,
                       with_image ? &target_.image : nullptr,
                       {up_source_, up_target_},
                       options_);
  }

  const Eigen::Isometry3d T_world_target_ = testing::sensorPose(Vector3d(0.3, 0.4, 1.7), 0.7, 0.1);
  const Eigen::Isometry3d T_world_source_ = testing::sensorPose(Vector3d(-5.2, 3.6, 2.1), -1.3, 0.4);
  const testing::SearchedScan target_ = makeScan(T_world_target_, 1);
  const testing::SearchedScan source_ = makeScan(T_world_source_, 2);
  const Vector3d up_source_ = source_.main_normals.front().direction;
  const Vector3d up_target_ = target_.main_normals.front().direction;
  const Eigen::Matrix3Xf no_points_;
  const Eigen::Isometry3d truth_ = testing::relativePose(T_world_target_, T_world_source_);
  PlanSearchOptions options_;
};

TEST_F(PlanSearch, FindsThePoseByTheGroundAndWhatStandsOnIt)
{
  for (const bool with_image : {true, false}) {
    const std::vector<PoseHypothesis> found = search(with_image);
    ASSERT_FALSE(found.empty());
    EXPECT_THAT(found[0].T_target_source, testing::IsPoseNear(truth_, 0.03, 0.4)) << with_image;
    EXPECT_LE(found.size(), static_cast<std::size_t>(options_.matches));
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_TRUE(testing::isRigid(found[i].T_target_source, 1e-9));
      EXPECT_GT(found[i].votes, 0);
      EXPECT_TRUE(i == 0 || found[i - 1].score >= found[i].score);
      EXPECT_TRUE((found[i].T_target_source.linear() * up_source_).isApprox(up_target_, 1e-9));
    }
  }
}

TEST_F(PlanSearch, IsTheSameForAnyThreadCount)
{
  const std::vector<PoseHypothesis> expected = search();
  options_.threads = 3;
  const std::vector<PoseHypothesis> found = search();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].T_target_source.matrix(), expected[i].T_target_source.matrix());
    EXPECT_EQ(found[i].score, expected[i].score);
  }
}

TEST_F(PlanSearch, OnlyWhatIsAllowedIsLookedAt)
{
  // Three metres from the truth: what lies there is looked at, though much else matches better.
  const Eigen::Isometry3d elsewhere = Eigen::Translation3d(up_target_.unitOrthogonal() * 3) * truth_;
  options_.is_allowed = [&](const Eigen::Isometry3d& T) {
    return (T.translation() - elsewhere.translation()).norm() < 1.5;
  };
  options_.matches = 5;
  std::vector<PoseHypothesis> found = search(false);
  ASSERT_FALSE(found.empty());
  for (const PoseHypothesis& pose : found)
    EXPECT_LT((pose.T_target_source.translation() - elsewhere.translation()).norm(), 1.5);
  options_.is_allowed = [](const Eigen::Isometry3d&) { return false; };
  EXPECT_TRUE(search().empty());
}

TEST_F(PlanSearch, NothingToSeeNothingFound)
{
  EXPECT_TRUE(searchPlans({OrientedSamples(), no_points_},
                          VotingSamples(),
                          {target_.patches.samples, no_points_},
                          target_.index,
                          &target_.image,
                          {up_source_, up_target_},
                          options_)
                  .empty());
  // Nothing stands on the ground.
  PlanarPatches ground;
  testing::addPatch(ground, {Vector3d(0, 0, -1), Vector3d(9, 0, 0), Vector3d(0, 9, 0)});
  EXPECT_TRUE(searchPlans({ground.samples, no_points_},
                          drawVotingSamples(ground.samples, {{Vector3d::UnitZ(), 1}}, 8),
                          {target_.patches.samples, no_points_},
                          target_.index,
                          nullptr,
                          {Vector3d::UnitZ(), up_target_},
                          options_)
                  .empty());
  options_.voting.deadline = Deadline::after(1e-9);
  EXPECT_TRUE(search().empty());
}

} // namespace
} // namespace pcl_ssfr::test_plan_search
