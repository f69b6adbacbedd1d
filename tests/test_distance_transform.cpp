// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baselines/distance_transform.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <tuple>
#include <vector>

namespace pcl_ssfr::baselines::test_distance_transform {
namespace {

using testing::Random;

Points3
randomPoints(Eigen::Index count, const Eigen::Vector3d& size, std::uint64_t seed)
{
  Random random(seed);
  Points3 points(3, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      points(axis, i) = size[axis] * random.uniform(-1, 1);
  return points;
}

double
nearestDistance(const Points3& points, const Eigen::Vector3d& x)
{
  return std::sqrt((points.colwise() - x).colwise().squaredNorm().minCoeff());
}

/// The voxels that hold a point, by the definition of the grid.
std::vector<Eigen::Vector3d>
occupiedCentres(const DistanceTransform& transform, const Points3& points)
{
  std::set<std::tuple<int, int, int>> voxels;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d place = transform.toGrid(points.col(i));
    const auto along = [&](int axis) {
      return std::min(static_cast<int>(std::floor(place[axis])), transform.size()[static_cast<std::size_t>(axis)] - 1);
    };
    voxels.emplace(along(0), along(1), along(2));
  }
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(voxels.size());
  for (const auto& [i, j, k] : voxels)
    centres.push_back(transform.centre(i, j, k));
  return centres;
}

void
expectExactEverywhere(const Points3& points, int voxels)
{
  const DistanceTransform transform(points, voxels, 1);
  const std::vector<Eigen::Vector3d> occupied = occupiedCentres(transform, points);
  int wrong = 0;
  for (int k = 0; k < transform.size()[2]; ++k)
    for (int j = 0; j < transform.size()[1]; ++j)
      for (int i = 0; i < transform.size()[0]; ++i) {
        double expected = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector3d& centre : occupied)
          expected = std::min(expected, (centre - transform.centre(i, j, k)).norm());
        const double found = transform.voxelSize() * static_cast<double>(transform.inVoxels(i, j, k));
        if (std::abs(found - expected) > 1e-6 * (1 + expected))
          ++wrong;
      }
  EXPECT_EQ(wrong, 0) << points.cols() << " points, " << voxels << " voxels";
}

TEST(DistanceTransform, OnePointInAFlatGridByHand)
{
  Points3 points(3, 2);
  points << 0, 4, 0, 3, 0, 0;
  const DistanceTransform transform(points, 5, 1);
  EXPECT_DOUBLE_EQ(transform.voxelSize(), 1);
  ASSERT_EQ(transform.size(), (std::array<int, 3>{5, 4, 1}));
  EXPECT_EQ(transform.inVoxels(0, 0, 0), 0);
  EXPECT_EQ(transform.inVoxels(4, 3, 0), 0);
  EXPECT_EQ(transform.inVoxels(2, 0, 0), 2);
  EXPECT_FLOAT_EQ(transform.inVoxels(1, 1, 0), std::sqrt(2.0F));
  EXPECT_FLOAT_EQ(transform.inVoxels(2, 2, 0), std::sqrt(5.0F)); // 5 from (4, 3), 8 from (0, 0)
  EXPECT_DOUBLE_EQ(transform.slack(), std::sqrt(0.75));          // both points lie in the centre of their voxel
  // 3 above the grid, whose upper side is at 0.5.
  EXPECT_DOUBLE_EQ(transform.estimate(Eigen::Vector3d(2, 0, 3.5)), std::sqrt(9.0 + 4.0));
}

TEST(DistanceTransform, AgreesWithBruteForceAtEveryVoxel)
{
  for (const Eigen::Index count : {1, 2, 5, 40, 400})
    expectExactEverywhere(randomPoints(count, Eigen::Vector3d(3, 2, 1), static_cast<std::uint64_t>(count)), 24);
  expectExactEverywhere(randomPoints(60, Eigen::Vector3d(1, 2, 3), 7), 33);
  expectExactEverywhere(randomPoints(60, Eigen::Vector3d(0.01, 2, 3), 8), 40);
  expectExactEverywhere(randomPoints(10, Eigen::Vector3d(1, 1, 1), 9), 2);
}

TEST(DistanceTransform, LowerBoundHoldsInsideBetweenAndOutside)
{
  Random random(3);
  for (const int voxels : {5, 20, 50}) {
    const Points3 points = randomPoints(100, Eigen::Vector3d(1, 0.7, 0.2), 5);
    const DistanceTransform transform(points, voxels, 1);
    double tightest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3000; ++i) {
      const double reach = i % 3 == 0 ? 1 : (i % 3 == 1 ? 3 : 50); // in the grid, around it, far away
      const Eigen::Vector3d x(
          random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
      const double exact = nearestDistance(points, x);
      const double lower = transform.lowerBound(x);
      ASSERT_LE(lower, exact + 1e-6 * exact) << x.transpose();
      ASSERT_GE(lower, exact - 2 * transform.slack() - 0.5 * exact); // not an empty promise
      tightest = std::min(tightest, exact - lower);
      if (reach <= 1) {
        const Eigen::Vector3d place = transform.toGrid(x);
        const bool is_inside = (place.array() >= 0).all() && place.x() <= transform.size()[0] &&
                               place.y() <= transform.size()[1] && place.z() <= transform.size()[2];
        if (is_inside) {
          ASSERT_NEAR(transform.estimate(x), exact, transform.slack() + 1e-6);
        }
      }
    }
    EXPECT_LT(tightest, transform.slack());
  }
}

TEST(DistanceTransform, SlackShrinksWithTheVoxels)
{
  const Points3 points = randomPoints(100, Eigen::Vector3d(1, 1, 1), 5);
  EXPECT_LT(DistanceTransform(points, 101, 1).slack(), 0.11 * DistanceTransform(points, 11, 1).slack() * 1.1);
}

TEST(DistanceTransform, SameForAnyNumberOfThreads)
{
  const Points3 points = randomPoints(300, Eigen::Vector3d(1, 0.6, 0.3), 11);
  const DistanceTransform one(points, 60, 1);
  for (const unsigned threads : {2U, 8U})
    EXPECT_EQ(DistanceTransform(points, 60, threads).distances(), one.distances());
}

TEST(DistanceTransform, DegenerateInput)
{
  const DistanceTransform none(Points3(3, 0), 10, 1);
  EXPECT_EQ(none.distances().size(), 1U);

  Points3 one(3, 1);
  one << 1e6, -2e6, 3;
  const DistanceTransform single(one, 10, 1);
  EXPECT_EQ(single.size(), (std::array<int, 3>{1, 1, 1}));
  EXPECT_EQ(single.inVoxels(0, 0, 0), 0);
  const Eigen::Vector3d far(1e6 + 30, -2e6 - 40, 3);
  EXPECT_LE(single.lowerBound(far), 50);
  EXPECT_GT(single.lowerBound(far), 49);

  const Points3 same = one.replicate(1, 5);
  EXPECT_EQ(DistanceTransform(same, 10, 1).distances().size(), 1U);

  Points3 line = Points3::Zero(3, 4);
  line.row(1) << 0, 1, 2, 9;
  const DistanceTransform thin(line, 10, 1);
  EXPECT_EQ(thin.size(), (std::array<int, 3>{1, 10, 1}));
  EXPECT_EQ(thin.inVoxels(0, 5, 0), 3);
}

TEST(DistanceTransform, BadArguments)
{
  const Points3 points = randomPoints(5, Eigen::Vector3d(1, 1, 1), 1);
  EXPECT_THROW(DistanceTransform(points, 1, 1), std::invalid_argument);
  EXPECT_THROW(DistanceTransform(points, DistanceTransform::kMaxVoxels + 1, 1), std::invalid_argument);
  Points3 broken = points;
  broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(DistanceTransform(broken, 10, 1), std::invalid_argument);
}

} // namespace
} // namespace pcl_ssfr::baselines::test_distance_transform
