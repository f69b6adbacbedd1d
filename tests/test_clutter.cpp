// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/patch_profile.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

namespace pcl_ssfr::test_clutter {
namespace {

using testing::viewOfPoints;

constexpr float kBushX = 4, kBushRadius = 1.5F;

/// A wall and the ground, seen from the origin, and a bush in front of them if there is one: points all over a ball.
Eigen::Matrix3Xf
gardenWith(int leaves)
{
  testing::Random random(3);
  constexpr int kPlanes = 20000;
  Eigen::Matrix3Xf points(3, kPlanes + leaves);
  for (Eigen::Index i = 0; i < kPlanes; ++i)
    points.col(i) = (i % 2 ? Eigen::Vector3d(8, random.uniform(-6, 6), random.uniform(-1.5, 3))
                           : Eigen::Vector3d(random.uniform(-6, 8), random.uniform(-6, 6), -1.5))
                        .cast<float>();
  for (Eigen::Index i = kPlanes; i < points.cols();) {
    const Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (p.norm() < 1)
      points.col(i++) = Eigen::Vector3f(kBushX, 0, 1) + kBushRadius * p.cast<float>();
  }
  return points;
}

Eigen::Matrix3Xf
clutterOf(const Eigen::Matrix3Xf& points, int most)
{
  Options options;
  options.patch_profile.preparation.clutter_points = most;
  const PatchScan scan = preparePatchScan(viewOfPoints(points), options);
  EXPECT_GT(scan.patches.size(), 50);
  return scan.clutter.colwise() + scan.origin.cast<float>();
}

int
countInBush(const Eigen::Matrix3Xf& points)
{
  int count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    count += (points.col(i) - Eigen::Vector3f(kBushX, 0, 1)).norm() < kBushRadius + 0.1F;
  return count;
}

TEST(Clutter, IsWhatFitsNoPlaneOnePointOfACell)
{
  constexpr int kLeaves = 20000;
  const Eigen::Matrix3Xf clutter = clutterOf(gardenWith(kLeaves), 100000);
  EXPECT_GT(clutter.cols(), 300);
  EXPECT_GT(countInBush(clutter), 0.8 * static_cast<double>(clutter.cols()));
  // A cell has an edge of 0.2 m: one of another grid that is as wide meets eight of them.
  std::map<std::array<int, 3>, int> places;
  for (Eigen::Index i = 0; i < clutter.cols(); ++i) {
    const Eigen::Array3i place = (clutter.col(i).array() / 0.2F).floor().cast<int>();
    EXPECT_LE((++places[{place.x(), place.y(), place.z()}]), 8);
  }
  EXPECT_GT(kLeaves, 4 * clutter.cols()); // many points share one
}

TEST(Clutter, IsDrawnEvenlyWhereItIsMore)
{
  const Eigen::Matrix3Xf all = clutterOf(gardenWith(5000), 100000), some = clutterOf(gardenWith(5000), 100);
  ASSERT_EQ(some.cols(), 100);
  const double share = static_cast<double>(countInBush(all)) / static_cast<double>(all.cols());
  EXPECT_NEAR(countInBush(some), 100 * share, 8);
  EXPECT_TRUE(((some.rowwise().maxCoeff() - some.rowwise().minCoeff()).array() > 1.5F * kBushRadius).all());
  EXPECT_EQ(clutterOf(gardenWith(5000), 0).cols(), 0);
}

TEST(Clutter, OfPlanesThereIsHardlyAny)
{
  EXPECT_LT(clutterOf(gardenWith(0), 100000).cols(), 100);
}

} // namespace
} // namespace pcl_ssfr::test_clutter
