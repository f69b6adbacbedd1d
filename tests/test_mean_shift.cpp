// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/mean_shift.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

namespace pcl_ssfr::test_mean_shift {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Directions scattered around some centres, and one region a centre that holds them all, started off its centre.
struct Sphere {
  DirectionSet directions;
  std::vector<DenseRegion> regions;
};

Sphere
makeSphere(const std::vector<Eigen::Vector3d>& centres, int count, double sigma, double start_offset)
{
  testing::Random random(3);
  Sphere sphere;
  const auto total = static_cast<Eigen::Index>(centres.size()) * count;
  sphere.directions.directions.resize(3, total);
  sphere.directions.weights = Eigen::VectorXd::Ones(total);
  Eigen::Index column = 0;
  for (const Eigen::Vector3d& centre : centres) {
    DenseRegion region;
    region.peak = (centre + start_offset * centre.unitOrthogonal()).normalized();
    for (int i = 0; i < count; ++i, ++column) {
      const Eigen::Vector3d noise(random.gaussian(), random.gaussian(), random.gaussian());
      sphere.directions.directions.col(column) = (centre + sigma * noise).normalized();
      region.members.push_back(column);
      region.weight += 1;
    }
    sphere.regions.push_back(region);
  }
  return sphere;
}

TEST(MeanShift, ClimbsToTheMode)
{
  const Eigen::Vector3d centre = Eigen::Vector3d(1, 2, -1).normalized();
  const Sphere sphere = makeSphere({centre}, 4000, 0.03, 0.05);
  const std::vector<MainNormal> normals = findMainNormals(sphere.directions, sphere.regions, MeanShiftOptions());
  ASSERT_EQ(normals.size(), 1U);
  EXPECT_NEAR(normals[0].direction.norm(), 1, 1e-12);
  EXPECT_LT((normals[0].direction - centre).norm(), 0.2 * kDegree);
  EXPECT_EQ(normals[0].support, 4000);
}

TEST(MeanShift, StaysAtAFixedPoint)
{
  // The defining property: the mode is the mean of the members within the bandwidth.
  const Sphere sphere = makeSphere({Eigen::Vector3d::UnitZ()}, 500, 0.05, 0.1);
  MeanShiftOptions options;
  options.bandwidth = 0.08;
  const Eigen::Vector3d mode = findMainNormals(sphere.directions, sphere.regions, options).at(0).direction;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < sphere.directions.size(); ++i)
    if ((sphere.directions.directions.col(i) - mode).norm() <= options.bandwidth)
      sum += sphere.directions.directions.col(i);
  EXPECT_LT((sum.normalized() - mode).norm(), 2e-3); // the unnormalised mode lies a little inside the sphere
}

TEST(MeanShift, WeightsPull)
{
  DirectionSet directions;
  directions.directions.resize(3, 2);
  directions.directions.col(0) = Eigen::Vector3d(0.02, 0, 1).normalized();
  directions.directions.col(1) = Eigen::Vector3d(-0.02, 0, 1).normalized();
  directions.weights = Eigen::Vector2d(3, 1);
  DenseRegion region;
  region.peak = Eigen::Vector3d::UnitZ();
  region.members = {0, 1};
  region.weight = 4;
  const Eigen::Vector3d mode = findMainNormals(directions, {region}, MeanShiftOptions()).at(0).direction;
  EXPECT_NEAR(mode.x(), 0.01, 1e-5); // (3 x 0.02 - 0.02) / 4
}

TEST(MeanShift, SmallBandwidthIgnoresTheFarMembers)
{
  Sphere sphere = makeSphere({Eigen::Vector3d::UnitX()}, 300, 0.01, 0);
  // An outlying clump in the same region.
  for (int i = 0; i < 200; ++i) {
    sphere.directions.directions.conservativeResize(3, 301 + i);
    sphere.directions.directions.col(300 + i) = Eigen::Vector3d(1, 0.3, 0).normalized();
    sphere.regions[0].members.push_back(300 + i);
  }
  sphere.directions.weights = Eigen::VectorXd::Ones(500);
  MeanShiftOptions options;
  EXPECT_LT(
      (findMainNormals(sphere.directions, sphere.regions, options).at(0).direction - Eigen::Vector3d::UnitX()).norm(),
      0.005);
  options.bandwidth = 1;
  EXPECT_GT(
      (findMainNormals(sphere.directions, sphere.regions, options).at(0).direction - Eigen::Vector3d::UnitX()).norm(),
      0.05);
}

TEST(MeanShift, ModesThatMeetAreOneAndTheHeavierStays)
{
  Sphere sphere = makeSphere(
      {Eigen::Vector3d::UnitX(), Eigen::Vector3d(1, 0.3, 0).normalized(), Eigen::Vector3d::UnitY()}, 100, 0.01, 0);
  sphere.regions[1].weight = 250;
  sphere.regions[2].weight = 170;
  MeanShiftOptions options; // merges below a chord of 0.5
  const std::vector<MainNormal> merged = findMainNormals(sphere.directions, sphere.regions, options);
  ASSERT_EQ(merged.size(), 2U);
  EXPECT_EQ(merged[0].support, 250);
  EXPECT_GT(merged[0].direction.y(), 0.2);
  EXPECT_EQ(merged[1].support, 170);
  options.merge_chord = 0.1;
  const std::vector<MainNormal> all = findMainNormals(sphere.directions, sphere.regions, options);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[2].support, 100);
}

TEST(MeanShift, EmptyAndDegenerate)
{
  EXPECT_TRUE(findMainNormals(DirectionSet(), {}, MeanShiftOptions()).empty());
  DenseRegion bare; // no members: its peak is all that is known
  bare.peak = Eigen::Vector3d::UnitY();
  const std::vector<MainNormal> normals = findMainNormals(DirectionSet(), {bare}, MeanShiftOptions());
  ASSERT_EQ(normals.size(), 1U);
  EXPECT_EQ(normals[0].direction, Eigen::Vector3d::UnitY());
}

TEST(MeanShift, EndsAtTheBoundOfIterations)
{
  const Sphere sphere = makeSphere({Eigen::Vector3d::UnitZ()}, 2000, 0.1, 0.3);
  MeanShiftOptions options;
  options.bandwidth = 0.2;
  options.max_iterations = 1;
  const Eigen::Vector3d one = findMainNormals(sphere.directions, sphere.regions, options).at(0).direction;
  options.max_iterations = 200;
  const Eigen::Vector3d many = findMainNormals(sphere.directions, sphere.regions, options).at(0).direction;
  EXPECT_GT((one - Eigen::Vector3d::UnitZ()).norm(), 5 * (many - Eigen::Vector3d::UnitZ()).norm());
}

} // namespace
} // namespace pcl_ssfr::test_mean_shift
