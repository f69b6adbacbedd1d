// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "synthetic_scene.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <gtest/gtest.h>

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

TEST(NeighborIndex, AgreesWithBruteForce)
{
  for (const Eigen::Index count : {1, 7, 9, 800}) {
    Points3 points = randomPoints(count, 10, static_cast<std::uint64_t>(count));
    points.row(2) *= 0.1; // boxes that are no cubes
    if (count > 100)
      points.rightCols(50) = points.leftCols(50); // doubles: the lower column counts
    const Points3 queries = randomPoints(300, 11, 2);
    const NeighborIndex index(points);
    ASSERT_EQ(index.size(), count);
    for (Eigen::Index q = 0; q < queries.cols(); ++q) {
      const Eigen::Vector3d query = queries.col(q);
      Eigen::Index expected = -1;
      const double squared = (points.colwise() - query).colwise().squaredNorm().minCoeff(&expected);
      const NeighborIndex::Neighbor found = index.nearest(query);
      EXPECT_EQ(found.index, expected);
      EXPECT_EQ(found.point, points.col(expected));
      EXPECT_DOUBLE_EQ(found.squared_distance, squared);
      EXPECT_EQ(index.nearest(query, 1.01 * std::sqrt(squared)).index, expected);
      EXPECT_EQ(index.nearest(query, 0.99 * std::sqrt(squared)).index, -1);
    }
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
  }
  const NeighborIndex few(randomPoints(3, 1, 3));
  EXPECT_EQ(few.nearest(Eigen::Vector3d::Zero(), 0).index, -1);
  EXPECT_EQ(few.nearest(Eigen::Vector3d::Zero(), kNan).index, -1);
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
