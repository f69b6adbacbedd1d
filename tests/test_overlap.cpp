// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/overlap.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::test_overlap {
namespace {

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

TEST(Overlap, ByHand)
{
  Points3 target(3, 2), source(3, 4);
  target << 0, 10, 0, 0, 0, 0;
  source << 0.3, 9.6, 5, -0.5, 0, 0, 0, 0, 0, 0, 0, 0;
  const Overlap overlap = computeOverlap(source, NeighborIndex(target), Eigen::Isometry3d::Identity(), 0.5);
  EXPECT_EQ(overlap.inliers, 2); // -0.5 lies at the radius, not nearer
  EXPECT_DOUBLE_EQ(overlap.ratio, 0.5);
  EXPECT_NEAR(overlap.rmse, std::sqrt((0.09 + 0.16) / 2), 1e-9);
  EXPECT_NEAR(overlap.kernel_sum, std::exp(-0.6) + std::exp(-0.8), 1e-9);
}

TEST(Overlap, AgreesWithBruteForceUnderAnyPose)
{
  testing::Random random(6);
  const Points3 source = randomPoints(400, 5, 7), target = randomPoints(500, 5, 8);
  const NeighborIndex index(target);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 2);
    Eigen::Index inliers = 0;
    double kernel_sum = 0;
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      const double distance = std::sqrt(sortedSquaredDistances(target, T * source.col(i))[0]);
      if (distance >= 0.6)
        continue;
      ++inliers;
      kernel_sum += std::exp(-distance / 0.6);
    }
    const Overlap overlap = computeOverlap(source, index, T, 0.6);
    EXPECT_EQ(overlap.inliers, inliers);
    EXPECT_NEAR(overlap.kernel_sum, kernel_sum, 1e-4);
    EXPECT_DOUBLE_EQ(overlap.ratio, static_cast<double>(inliers) / 400);
  }
}

TEST(Overlap, WholeAtTheTruthAndTheSameForAnyNumberOfThreads)
{
  testing::Random random(9);
  const Points3 target = randomPoints(3000, 5, 10);
  const Eigen::Isometry3d T = testing::randomMotion(random, 3);
  const Points3 source = (T.inverse() * target.colwise().homogeneous()).topRows<3>();
  const NeighborIndex index(target);
  const Overlap one = computeOverlap(source, index, T, 0.05, 1), many = computeOverlap(source, index, T, 0.05, 8);
  EXPECT_EQ(one.ratio, 1);
  EXPECT_LT(one.rmse, 1e-6);
  EXPECT_EQ(one.kernel_sum, many.kernel_sum);
  EXPECT_EQ(one.rmse, many.rmse);
}

TEST(Overlap, EmptyIn)
{
  const Points3 points = randomPoints(5, 1, 11);
  for (const Overlap& overlap : {computeOverlap(Points3(3, 0), NeighborIndex(points), Eigen::Isometry3d::Identity(), 1),
                                 computeOverlap(points, NeighborIndex(), Eigen::Isometry3d::Identity(), 1)}) {
    EXPECT_EQ(overlap.ratio, 0);
    EXPECT_EQ(overlap.inliers, 0);
    EXPECT_EQ(overlap.rmse, 0);
  }
}

} // namespace
} // namespace pcl_ssfr::test_overlap
