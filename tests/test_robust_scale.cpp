// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/robust_scale.h"

#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ssfr::test_robust_scale {
namespace {

/// Normal distances of \p deviation; every \p strays-th one lies \p off from the plane besides (0: none does).
WeightedDistances
noisy(std::size_t count, double deviation, std::size_t strays = 0, double off = 0)
{
  testing::Random random(3);
  WeightedDistances matches;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_stray = strays > 0 && i % strays == 0;
    matches.distances.push_back(deviation * random.gaussian() + (is_stray ? off : 0));
    matches.weights.push_back(1 + static_cast<double>(i % 3));
  }
  return matches;
}

double
distanceOf(const WeightedDistances& matches, double least, double most, double deviations, double pose_deviation = 0)
{
  NoiseRule rule;
  rule.least = least;
  rule.most = most;
  rule.deviations = deviations;
  rule.pose_deviation = pose_deviation;
  return matchDistanceByNoise(matches, rule);
}

/// The root mean square distance that matches within \p farthest leave, as the definition has it.
double
rmsWithin(const WeightedDistances& matches, double farthest)
{
  double weight = 0, squares = 0;
  for (std::size_t i = 0; i < matches.distances.size(); ++i) {
    const double r = matches.distances[i];
    if (std::abs(r) >= farthest)
      continue;
    const double w = matches.weights[i] / std::pow(1 + 4 * r * r / (farthest * farthest), 2);
    weight += w;
    squares += w * r * r;
  }
  return std::sqrt(squares / weight);
}

TEST(RobustScale, IsTheSmallestOneThatItsMatchesConfirm)
{
  for (const double deviation : {0.001, 0.003, 0.004}) {
    const WeightedDistances matches = noisy(3000, deviation, 7, 0.04);
    const double found = distanceOf(matches, 1e-4, 0.1, 3);
    EXPECT_GT(found, 3 * deviation);
    EXPECT_LT(found, 6.1 * deviation);
    // Brute force: no smaller distance that takes in most is enough times what it leaves.
    double smallest = 1e-4;
    const auto isConfirmed = [&](double distance) {
      const auto within = std::count_if(
          matches.distances.begin(), matches.distances.end(), [&](double r) { return std::abs(r) < distance; });
      return 2 * within >= 3000 && distance >= 6 * rmsWithin(matches, distance);
    };
    while (!isConfirmed(smallest))
      smallest *= 1.001;
    EXPECT_NEAR(found, smallest, 0.03 * smallest) << deviation;
  }
}

TEST(RobustScale, FollowsTheNoiseAndNotWhatLiesOffThePlanes)
{
  const double alone = distanceOf(noisy(3000, 0.002), 1e-4, 0.1, 3);
  EXPECT_NEAR(distanceOf(noisy(3000, 0.002, 4, 0.05), 1e-4, 0.1, 3), alone, 0.1 * alone);
  EXPECT_NEAR(distanceOf(noisy(3000, 0.004), 1e-4, 0.1, 3), 2 * alone, 0.05 * alone);
  // Lengths of another unit.
  WeightedDistances larger = noisy(3000, 0.002);
  for (double& r : larger.distances)
    r *= 10;
  EXPECT_NEAR(distanceOf(larger, 1e-3, 1, 3), 10 * alone, 1e-9);
  // Weights are relative.
  WeightedDistances heavier = noisy(3000, 0.002);
  for (double& w : heavier.weights)
    w *= 1000;
  EXPECT_NEAR(distanceOf(heavier, 1e-4, 0.1, 3), alone, 1e-9);
}

TEST(RobustScale, CoversWhatThePoseMayBeOffBy)
{
  const WeightedDistances matches = noisy(3000, 0.001);
  EXPECT_NEAR(distanceOf(matches, 1e-4, 0.1, 3, 0.01), 6 * std::hypot(0.001, 0.01), 2e-4);
  EXPECT_EQ(distanceOf(matches, 1e-4, 0.1, 3, 0.02), 0.1);
  EXPECT_EQ(distanceOf(matches, 1e-4, 0.1, 3, std::numeric_limits<double>::infinity()), 0.1);
}

TEST(RobustScale, StaysWithinItsBounds)
{
  EXPECT_EQ(distanceOf(noisy(1000, 0), 0.006, 0.1, 3), 0.006);       // exact
  EXPECT_EQ(distanceOf(noisy(1000, 0.03), 0.006, 0.1, 3), 0.1);      // too noisy
  EXPECT_EQ(distanceOf(noisy(1000, 0.002), 0.1, 0.1, 3), 0.1);       // no choice
  EXPECT_EQ(distanceOf({}, 0.006, 0.1, 3), 0.1);                     // nothing
  EXPECT_EQ(distanceOf(noisy(100, 0.01, 1, 5), 0.006, 0.1, 3), 0.1); // nothing near
  EXPECT_EQ(distanceOf(noisy(1, 0.01), 0.006, 0.1, 1e9), 0.1);       // one
  // Few that meet exactly do not make a scale where most do not.
  WeightedDistances chance = noisy(1000, 0.04);
  for (std::size_t i = 0; i < 200; ++i)
    chance.distances[i] = 0;
  EXPECT_EQ(distanceOf(chance, 0.006, 0.1, 3), 0.1);
}

} // namespace
} // namespace pcl_ssfr::test_robust_scale
