// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/matched_planes.h"
#include "patch_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace pcl_ssfr::test_matched_planes {
namespace {

using Indices = std::vector<Eigen::Index>;

/// Samples of which each stands for \p area.
struct Scene {
  OrientedSamples samples;

  void
  add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double area)
  {
    const Eigen::Index i = samples.points.cols();
    samples.points.conservativeResize(3, i + 1);
    samples.normals.conservativeResize(3, i + 1);
    samples.weights.conservativeResize(i + 1);
    samples.points.col(i) = point;
    samples.normals.col(i) = normal.normalized();
    samples.weights[i] = area;
  }
};

Indices
all(const OrientedSamples& samples)
{
  Indices indices(static_cast<std::size_t>(samples.size()));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

/// Two samples each of the floor (0, 1) and of two walls (2, 3 and 4, 5) of a corner.
Scene
corner()
{
  Scene scene;
  scene.add({1, 1, 0}, {0, 0, 1}, 4);
  scene.add({3, 2, 0.05}, {0.1, 0, 1}, 1);
  scene.add({0, 1, 1}, {1, 0, 0}, 3);
  scene.add({0, 3, 2}, {-1, 0, 0}, 1); // seen from behind: the same plane
  scene.add({1, 0, 1}, {0, 1, 0}, 2);
  scene.add({4, 0, 2}, {0, 1, 0}, 1);
  return scene;
}

const PatchIndex::Tolerance kTolerance = {0.9f, 0.1f, 0.3f, false};

TEST(BeyondThreePlanes, OfACornerNothingIsLeft)
{
  const Scene scene = corner();
  EXPECT_TRUE(beyondThreePlanes(scene.samples, all(scene.samples), kTolerance).empty());
}

TEST(BeyondThreePlanes, WhatIsInNoneOfThemIsLeft)
{
  Scene scene = corner();
  scene.add({2, 2, 0.7}, {0, 0, 1}, 1);  // 6: a table
  scene.add({0, 2, 1}, {1, 1, 0}, 1);    // 7: leans on a wall
  scene.add({0.09, 2, 1}, {1, 0, 0}, 1); // a picture on it
  scene.add({0.12, 2, 1}, {1, 0, 0}, 1); // 9: a cupboard
  scene.add({3, 3, 3}, {1, 1, 1}, 1);    // 10
  EXPECT_EQ(beyondThreePlanes(scene.samples, all(scene.samples), kTolerance), (Indices{6, 7, 9, 10}));
  // Of those that are asked for, in their order.
  EXPECT_EQ(beyondThreePlanes(scene.samples, {10, 0, 6, 2, 4}, kTolerance), (Indices{10, 6}));
}

TEST(BeyondThreePlanes, TheThirdIsNotTheOppositeWall)
{
  // A corridor: the largest planes are all across two directions. The small end is the third, and one wall is left.
  Scene scene;
  scene.add({5, 0, 0}, {0, 0, 1}, 30);
  scene.add({5, 0, 2}, {0, 0, -1}, 29);
  scene.add({5, 1, 1}, {0, -1, 0}, 28);
  scene.add({5, -1, 1}, {0, 1, 0}, 27);
  scene.add({10, 0, 1}, {-1, 0, 0}, 2);
  EXPECT_EQ(beyondThreePlanes(scene.samples, all(scene.samples), kTolerance), (Indices{1, 3}));
}

TEST(BeyondThreePlanes, NothingAndLess)
{
  EXPECT_TRUE(beyondThreePlanes({}, {}, kTolerance).empty());
  const Scene scene = corner();
  EXPECT_TRUE(beyondThreePlanes(scene.samples, {}, kTolerance).empty());
  EXPECT_TRUE(beyondThreePlanes(scene.samples, {3}, kTolerance).empty());
  // One direction only: three planes of it at most.
  Scene shelves;
  for (int k = 0; k < 5; ++k)
    shelves.add({0, 0, 0.5 * k}, {0, 0, 1}, 5 - k);
  const Indices left = beyondThreePlanes(shelves.samples, all(shelves.samples), kTolerance);
  EXPECT_GE(left.size(), 2u);
  EXPECT_EQ(std::count(left.begin(), left.end(), 0), 0);
}

TEST(BeyondThreePlanes, IsTheSameInAnyFrame)
{
  testing::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    Scene scene = corner();
    for (int i = 0; i < 30; ++i)
      scene.add(testing::randomMotion(random, 3).translation(),
                testing::randomRotation(random).col(0),
                random.uniform(0.01, 5));
    Scene moved = scene;
    const Eigen::Isometry3d T = testing::randomMotion(random, 20);
    for (Eigen::Index i = 0; i < scene.samples.size(); ++i) {
      moved.samples.points.col(i) = T * scene.samples.points.col(i);
      moved.samples.normals.col(i) = T.linear() * scene.samples.normals.col(i) * (random.index(2) ? 1 : -1);
    }
    const Indices left = beyondThreePlanes(scene.samples, all(scene.samples), kTolerance);
    EXPECT_EQ(beyondThreePlanes(moved.samples, all(moved.samples), kTolerance), left);
    EXPECT_GT(left.size(), 20u);
    EXPECT_LT(left.size(), 34u);
  }
}

TEST(BeyondThreePlanes, AgreesWithPlanesFoundOneByOne)
{
  testing::Random random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const OrientedSamples samples = testing::randomPatches(60, 2, 0.4, 100 + static_cast<unsigned>(trial)).samples;
    // Each plane with the largest product of area and squared sine to what was before, by determinants.
    Indices left = all(samples);
    std::vector<Eigen::Vector3d> normals;
    while (normals.size() < 3 && !left.empty()) {
      const auto product = [&](Eigen::Index i) {
        const Eigen::Vector3d n = samples.normals.col(i);
        if (normals.empty())
          return samples.weights[i];
        const double across = normals.size() == 1 ? normals[0].cross(n).squaredNorm()
                                                  : std::pow(normals[0].cross(normals[1]).normalized().dot(n), 2);
        return samples.weights[i] * across;
      };
      const Eigen::Index seed = *std::max_element(
          left.begin(), left.end(), [&](Eigen::Index a, Eigen::Index b) { return product(a) < product(b); });
      Indices others;
      for (const Eigen::Index i : left) {
        const double cosine = std::abs(samples.normals.col(seed).dot(samples.normals.col(i)));
        const double offset = samples.normals.col(seed).dot(samples.points.col(i)) -
                              samples.normals.col(seed).dot(samples.points.col(seed));
        if (cosine < 0.9 || std::abs(offset) > 0.1)
          others.push_back(i);
      }
      left = others;
      normals.push_back(samples.normals.col(seed));
    }
    EXPECT_EQ(beyondThreePlanes(samples, all(samples), kTolerance), left);
  }
}

} // namespace
} // namespace pcl_ssfr::test_matched_planes
