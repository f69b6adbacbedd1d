// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/correspondence_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

namespace pcl_ssfr::test_correspondence_distance {
namespace {

constexpr double kMost = 0.3; // [m]

/// Patches of an area [m^2] with a number of points each.
PlanarPatches
patchesOf(std::initializer_list<std::pair<double, std::uint32_t>> area_and_count)
{
  PlanarPatches patches;
  const auto n = static_cast<Eigen::Index>(area_and_count.size());
  patches.samples.points = Points3::Zero(3, n);
  patches.samples.weights.resize(n);
  Eigen::Index i = 0;
  for (const auto& [area, count] : area_and_count) {
    patches.samples.weights[i++] = area;
    patches.counts.push_back(count);
  }
  return patches;
}

Refinement
polishWith(double rms)
{
  Refinement polish;
  polish.rms = rms;
  polish.matches = 100;
  return polish;
}

PoseUncertainty
uncertaintyOf(std::initializer_list<double> deviations)
{
  PoseUncertainty uncertainty;
  for (const double deviation : deviations)
    uncertainty.motions.push_back({Eigen::Matrix<double, 6, 1>::Unit(0), deviation});
  return uncertainty;
}

TEST(Spacing, isThatOfHalfTheSurface)
{
  EXPECT_EQ(spacingOf(PlanarPatches()), 0);
  EXPECT_NEAR(spacingOf(patchesOf({{4, 100}})), 0.2, 1e-12);
  // Many small dense patches do not outvote the surface.
  EXPECT_NEAR(spacingOf(patchesOf({{0.1, 1000}, {0.1, 1000}, {0.1, 1000}, {9, 100}})), 0.3, 1e-12);
  EXPECT_NEAR(spacingOf(patchesOf({{1, 100}, {1, 25}, {1, 4}})), 0.2, 1e-12);
}

TEST(CorrespondenceDistance, AddsWhatIsIndependentInSquares)
{
  // 3 deviations of 0.02 m of noise, and of 0.003 and 0.004 m of the pose; half the diagonal of 0.1 m.
  const double distance = correspondenceDistance(polishWith(0.02), uncertaintyOf({0.003, 0.004}), 0.1, kMost);
  EXPECT_NEAR(distance, std::sqrt(0.06 * 0.06 + 0.015 * 0.015 + 0.005), 1e-12);
  UncertaintyConfig config;
  config.bound_deviations = 2;
  EXPECT_NEAR(correspondenceDistance(polishWith(0.02), uncertaintyOf({0.005}), 0, kMost, config),
              std::hypot(0.04, 0.01),
              1e-12);
}

TEST(CorrespondenceDistance, GrowsWithEachOfThem)
{
  const double base = correspondenceDistance(polishWith(0.02), uncertaintyOf({0.01}), 0.05, kMost);
  EXPECT_GT(correspondenceDistance(polishWith(0.03), uncertaintyOf({0.01}), 0.05, kMost), base);
  EXPECT_GT(correspondenceDistance(polishWith(0.02), uncertaintyOf({0.02}), 0.05, kMost), base);
  EXPECT_GT(correspondenceDistance(polishWith(0.02), uncertaintyOf({0.01}), 0.06, kMost), base);
}

TEST(CorrespondenceDistance, LeavesOutWhatNothingDeterminesAndBoundsTheRest)
{
  const double known = correspondenceDistance(polishWith(0.02), uncertaintyOf({0.01}), 0.05, kMost);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(correspondenceDistance(polishWith(0.02), uncertaintyOf({infinite, 0.01}), 0.05, kMost), known);
  EXPECT_NEAR(correspondenceDistance(polishWith(0.02), uncertaintyOf({7}), 0, kMost), std::hypot(0.06, kMost), 1e-12);
}

TEST(CorrespondenceDistance, IsNothingWithoutMatchesAndNoLessThanTheNoiseFloor)
{
  EXPECT_EQ(correspondenceDistance(Refinement(), PoseUncertainty(), 0.1, kMost), 0);
  const UncertaintyConfig config;
  EXPECT_NEAR(correspondenceDistance(polishWith(0), PoseUncertainty(), 0, kMost),
              config.bound_deviations * config.noise_floor,
              1e-12);
}

} // namespace
} // namespace pcl_ssfr::test_correspondence_distance
