// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/place_block.h"
#include "patch_scenes.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <array>

namespace pcl_ssfr::test_place_block {
namespace {

constexpr Eigen::Index kPlaces = 300;
constexpr Eigen::Index kFirst = 41, kCount = 251;

/// Columns of Gaussian coordinates.
Eigen::Matrix3Xd
randomColumns(testing::Random& random, double size)
{
  Eigen::Matrix3Xd columns(3, kPlaces);
  for (double& coordinate : columns.reshaped())
    coordinate = size * random.gaussian();
  return columns;
}

TEST(PlaceBlock, MovesAsTheTransformDoes)
{
  testing::Random random(6);
  const Eigen::Matrix3Xd places = randomColumns(random, 100), normals = randomColumns(random, 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = testing::randomRotation(random);
  T.translation() = Eigen::Vector3d(30, -20, 1000);
  PlaceBlock block, rounded;
  block.move(places.col(kFirst).data(), normals.col(kFirst).data(), kCount, T);
  const Eigen::Matrix3Xf rounded_places = places.cast<float>(), rounded_normals = normals.cast<float>();
  rounded.move(rounded_places.col(kFirst).data(), rounded_normals.col(kFirst).data(), kCount, T);
  ASSERT_EQ(block.count, static_cast<std::size_t>(kCount));
  ASSERT_EQ(rounded.count, block.count);
  for (std::size_t i = 0; i < block.count; ++i) {
    const Eigen::Index column = kFirst + static_cast<Eigen::Index>(i);
    const Eigen::Vector3d p = T * places.col(column), n = T.linear() * normals.col(column);
    EXPECT_LT((Eigen::Vector3d(block.x[i], block.y[i], block.z[i]) - p).norm(), 1e-10);
    EXPECT_LT((Eigen::Vector3d(block.nx[i], block.ny[i], block.nz[i]) - n).norm(), 1e-12);
    EXPECT_LT((Eigen::Vector3d(rounded.x[i], rounded.y[i], rounded.z[i]) - p).norm(), 1e-3);
    EXPECT_LT((Eigen::Vector3d(rounded.nx[i], rounded.ny[i], rounded.nz[i]) - n).norm(), 1e-5);
  }
  block.move(places.data(), normals.data(), 0, T);
  EXPECT_EQ(block.count, 0U);
}

TEST(PlaceBlock, FindsWhatTheIndexFinds)
{
  testing::Random random(7);
  const PatchIndex index(testing::randomPatches(300, 4, 1, 7), 0.5);
  const Eigen::Matrix3Xd places = randomColumns(random, 2), normals = randomColumns(random, 1).colwise().normalized();
  PatchIndex::Tolerance tolerance;
  tolerance.min_cos = 0.5f;
  PlaceBlock block;
  block.move(places.col(kFirst).data(), normals.col(kFirst).data(), kCount, Eigen::Isometry3d::Identity());
  std::array<int, PlaceBlock::kSize> found{};
  block.find(index, tolerance, found.data());
  int some = 0;
  for (Eigen::Index i = 0; i < kCount; ++i) {
    const int expected =
        index.find(places.col(kFirst + i).cast<float>(), normals.col(kFirst + i).cast<float>(), tolerance);
    EXPECT_EQ(found[static_cast<std::size_t>(i)], expected) << i;
    some += expected >= 0;
  }
  EXPECT_GT(some, 20);
}

} // namespace
} // namespace pcl_ssfr::test_place_block
