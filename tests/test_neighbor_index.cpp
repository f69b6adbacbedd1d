// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/neighbor_index.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr::test_neighbor_index {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Points3
randomPoints(Eigen::Index count, double size, std::uint64_t seed)
{
  testing::Random random(seed);
  Points3 points(3, count);
  for (Eigen::Index i = 0; i < count; ++i)
    points.col(i) << random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size);
  return points;
}

std::vector<double>
sortedSquaredDistances(const Points3& points, const Eigen::Vector3d& query)
{
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    distances.push_back((points.col(i) - query).squaredNorm());
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(NeighborIndex, AgreesWithBruteForce)
{
  const Points3 points = randomPoints(800, 10, 1), queries = randomPoints(100, 11, 2);
  const NeighborIndex index(points);
  ASSERT_EQ(index.size(), 800);
  for (Eigen::Index q = 0; q < queries.cols(); ++q) {
    const Eigen::Vector3d query = queries.col(q);
    const std::vector<double> expected = sortedSquaredDistances(points, query);

    const NeighborIndex::Neighbor nearest = index.nearest(query, 100);
    EXPECT_NEAR(nearest.squared_distance, expected[0], 1e-5);
    EXPECT_EQ(nearest.squared_distance, (points.col(nearest.index) - query).squaredNorm());
    EXPECT_EQ(index.nearest(query, 0.9 * std::sqrt(expected[0])).index, -1);

    const std::vector<NeighborIndex::Neighbor> seven = index.kNearest(query, 7);
    ASSERT_EQ(seven.size(), 7U);
    for (std::size_t k = 0; k < 7; ++k)
      EXPECT_NEAR(seven[k].squared_distance, expected[k], 1e-5);
  }
}

TEST(NeighborIndex, NearestExcludesItsBound)
{
  Points3 points(3, 2);
  points << 0, 0.5, 0, 0, 0, 0;
  const NeighborIndex index(points);
  EXPECT_EQ(index.nearest(Eigen::Vector3d(-0.5, 0, 0), 0.5).index, -1);
  EXPECT_EQ(index.nearest(Eigen::Vector3d(-0.5, 0, 0), 0.5001).index, 0);
}

TEST(NeighborIndex, AnswersNothingWhereThereIsNothing)
{
  const NeighborIndex unset, empty{Points3(3, 0)};
  for (const NeighborIndex* index : {&unset, &empty}) {
    EXPECT_EQ(index->size(), 0);
    EXPECT_EQ(index->nearest(Eigen::Vector3d::Zero(), 1).index, -1);
    EXPECT_TRUE(index->kNearest(Eigen::Vector3d::Zero(), 3).empty());
  }
  const NeighborIndex few(randomPoints(3, 1, 3));
  EXPECT_EQ(few.kNearest(Eigen::Vector3d::Zero(), 10).size(), 3U);
  EXPECT_TRUE(few.kNearest(Eigen::Vector3d::Zero(), 0).empty());
  EXPECT_TRUE(few.kNearest(Eigen::Vector3d(kNan, 0, 0), 2).empty());
  EXPECT_EQ(few.nearest(Eigen::Vector3d(0, kNan, 0), 2).index, -1);
}

TEST(NeighborIndex, RefusesPointsThatAreNotFinite)
{
  Points3 points = randomPoints(5, 1, 4);
  points(1, 3) = kNan;
  EXPECT_THROW(NeighborIndex{points}, std::invalid_argument);
}

TEST(NeighborIndex, CopiesShareTheTree)
{
  NeighborIndex copy;
  const Points3 points = randomPoints(50, 1, 5);
  {
    const NeighborIndex index(points);
    copy = index;
  }
  EXPECT_EQ(copy.nearest(points.col(7), 1).index, 7);
}

} // namespace
} // namespace pcl_ssfr::test_neighbor_index
