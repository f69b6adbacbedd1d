// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/scene_directions.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace pcl_ssfr::test_scene_directions {
namespace {

using Eigen::Vector3d;

OrientedSamples
samplesFacing(const std::vector<Vector3d>& normals, const std::vector<double>& weights = {})
{
  const auto n = static_cast<Eigen::Index>(normals.size());
  OrientedSamples samples;
  samples.points = Eigen::Matrix3Xd::Zero(3, n);
  samples.normals.resize(3, n);
  samples.weights = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    samples.normals.col(i) = normals[static_cast<std::size_t>(i)].normalized();
    if (!weights.empty())
      samples.weights[i] = weights[static_cast<std::size_t>(i)];
  }
  return samples;
}

/// \p count normals evenly around \p axis.
std::vector<Vector3d>
around(const Vector3d& axis, int count)
{
  const Vector3d x = axis.unitOrthogonal();
  std::vector<Vector3d> normals;
  normals.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    normals.push_back(Eigen::AngleAxisd(6.283185307179586 * (i + 0.5) / count, axis) * x);
  return normals;
}

std::vector<MainNormal>
mainNormals(const std::vector<Vector3d>& directions)
{
  std::vector<MainNormal> normals;
  for (std::size_t k = 0; k < directions.size(); ++k)
    normals.push_back({directions[k].normalized(), 10.0 - static_cast<double>(k)});
  return normals;
}

TEST(ParallelCos, IsOfTwiceWhatADirectionIsGoodTo)
{
  SearchConfig config;
  config.direction_error = 0.2;
  EXPECT_NEAR(std::acos(parallelCos(config)), 0.4, 1e-12);
  config.direction_error = 1.5; // good to nothing: all surface
  EXPECT_NEAR(parallelCos(config), 0, 1e-12);
}

TEST(WithVertical, OneMoreUnlessOneIsThere)
{
  const Vector3d up = Vector3d::UnitZ();
  const std::vector<MainNormal> walls = mainNormals({Vector3d::UnitX(), Vector3d::UnitY()});
  const std::vector<MainNormal> more = withVertical(walls, up);
  ASSERT_EQ(more.size(), 3U);
  EXPECT_EQ(more[2].direction, up);
  EXPECT_EQ(more[2].support, 10); // as much as the heaviest
  const auto tilted = [](double angle) { return Vector3d(std::sin(angle), 0, std::cos(angle)); };
  EXPECT_EQ(withVertical(mainNormals({Vector3d::UnitY(), tilted(0.11)}), up).size(), 2U);
  EXPECT_EQ(withVertical(mainNormals({Vector3d::UnitY(), tilted(0.13)}), up).size(), 3U);
  EXPECT_EQ(withVertical(mainNormals({Vector3d::UnitY(), -up}), up).size(), 3U); // a ceiling is no floor
  ASSERT_EQ(withVertical({}, up).size(), 1U);
  EXPECT_GT(withVertical({}, up)[0].support, 0);
}

TEST(IsRoundAbout, ARoundWallButNoBox)
{
  testing::Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Vector3d axis = testing::randomRotation(random).col(0);
    EXPECT_TRUE(isRoundAbout(samplesFacing(around(axis, 72)), axis));
    EXPECT_FALSE(isRoundAbout(samplesFacing(around(axis, 4)), axis)); // the walls of a box
    // What faces along the axis does not count.
    std::vector<Vector3d> hall = around(axis, 72);
    std::vector<double> weights(hall.size(), 1);
    hall.push_back(axis);
    weights.push_back(100);
    EXPECT_TRUE(isRoundAbout(samplesFacing(hall, weights), axis));
    // Walls of a box, and things at all angles: the walls decide while they are most of it.
    std::vector<Vector3d> box = around(axis, 72);
    std::vector<double> of_box(box.size(), 1);
    for (const Vector3d& wall : around(axis, 4)) {
      box.push_back(wall);
      of_box.push_back(40);
    }
    EXPECT_FALSE(isRoundAbout(samplesFacing(box, of_box), axis));
  }
  EXPECT_FALSE(isRoundAbout(OrientedSamples(), Vector3d::UnitZ()));
}

TEST(IsRoundAbout, TwoThirdsOfARoundWallAreEnoughAndAThirdIsNot)
{
  const std::vector<Vector3d> all = around(Vector3d::UnitZ(), 360);
  const auto first = [&](std::ptrdiff_t count) {
    return samplesFacing(std::vector<Vector3d>(all.begin(), all.begin() + count));
  };
  EXPECT_TRUE(isRoundAbout(first(240), Vector3d::UnitZ()));
  EXPECT_FALSE(isRoundAbout(first(120), Vector3d::UnitZ()));
}

TEST(SweepAxes, RoundOnesOrTheBestTwo)
{
  const OrientedSamples round = samplesFacing(around(Vector3d::UnitZ(), 72));
  const OrientedSamples box = samplesFacing({Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()});
  const std::vector<MainNormal> normals = mainNormals({Vector3d::UnitX(), Vector3d::UnitZ(), Vector3d::UnitY()});
  ASSERT_EQ(sweepAxes(normals, round, false).size(), 1U);
  EXPECT_EQ(sweepAxes(normals, round, false)[0], Vector3d::UnitZ());
  EXPECT_TRUE(sweepAxes(normals, box, false).empty());
  const std::vector<Vector3d> both = sweepAxes(normals, box, true);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0], Vector3d::UnitX());
  EXPECT_EQ(both[1], Vector3d::UnitZ());
  EXPECT_EQ(sweepAxes(mainNormals({Vector3d::UnitY()}), box, true).size(), 1U);
  EXPECT_TRUE(sweepAxes({}, round, true).empty());
}

} // namespace
} // namespace pcl_ssfr::test_scene_directions
