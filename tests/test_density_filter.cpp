// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/density_filter.h"
#include "processor_time.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::test_density_filter {
namespace {

/// A unit vector near \p centre: Gaussian noise of \p sigma in each coordinate, normalised.
Eigen::Vector3d
scatter(const Eigen::Vector3d& centre, double sigma, testing::Random& random)
{
  return (centre + sigma * Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian())).normalized();
}

/// \p counts[k] directions scattered around axis k of (x, y, z, -x, -y, -z), and \p noise uniform ones.
DirectionSet
makeCaps(const std::vector<int>& counts, int noise, double sigma, std::uint64_t seed)
{
  testing::Random random(seed);
  std::vector<Eigen::Vector3d> directions;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    Eigen::Vector3d axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k % 3));
    if (k >= 3)
      axis = -axis;
    for (int i = 0; i < counts[k]; ++i)
      directions.push_back(scatter(axis, sigma, random));
  }
  for (int i = 0; i < noise; ++i)
    directions.emplace_back(testing::randomRotation(random).col(0));
  DirectionSet set;
  set.directions.resize(3, static_cast<Eigen::Index>(directions.size()));
  for (std::size_t i = 0; i < directions.size(); ++i)
    set.directions.col(static_cast<Eigen::Index>(i)) = directions[i];
  set.weights = Eigen::VectorXd::Ones(set.size());
  return set;
}

Eigen::VectorXd
bruteForceDensity(const DirectionSet& set, const DensityOptions& options)
{
  Eigen::VectorXd density = Eigen::VectorXd::Zero(set.size());
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    for (Eigen::Index j = 0; j < set.size(); ++j) {
      const double distance = (set.directions.col(i) - set.directions.col(j)).norm();
      if (distance > options.radius)
        continue;
      const double scaled = distance / (options.radius / 2);
      density[i] += set.weights[j] * (options.kernel == DensityOptions::Kernel::Count ? 1 : std::exp(-scaled * scaled));
    }
  }
  return density;
}

TEST(DensityFilter, CountsAsBruteForceDoes)
{
  const DirectionSet set = makeCaps({700, 300, 100}, 400, 0.03, 2);
  DensityOptions options;
  for (const double radius : {0.02, 0.06, 0.3, 1.0}) {
    options.radius = radius;
    EXPECT_EQ(computeDensity(set, options), bruteForceDensity(set, options)) << radius;
  }
}

TEST(DensityFilter, WeighsAsBruteForceDoes)
{
  DirectionSet set = makeCaps({400, 200}, 300, 0.02, 3);
  testing::Random random(4);
  for (Eigen::Index i = 0; i < set.size(); ++i)
    set.weights[i] = random.uniform(0.01, 5);
  DensityOptions options;
  for (const auto kernel : {DensityOptions::Kernel::Count, DensityOptions::Kernel::Gaussian}) {
    options.kernel = kernel;
    const Eigen::VectorXd expected = bruteForceDensity(set, options);
    const Eigen::VectorXd density = computeDensity(set, options);
    EXPECT_LT(((density - expected).array() / expected.array()).abs().maxCoeff(), 1e-12);
  }
}

TEST(DensityFilter, SameBitsForAnyNumberOfThreads)
{
  DirectionSet set = makeCaps({3000, 1000}, 2000, 0.03, 5);
  set.weights.setLinSpaced(0.1, 3);
  for (const auto kernel : {DensityOptions::Kernel::Count, DensityOptions::Kernel::Gaussian}) {
    DensityOptions options;
    options.kernel = kernel;
    const Eigen::VectorXd serial = computeDensity(set, options, 1);
    EXPECT_EQ(serial, computeDensity(set, options, 2));
    EXPECT_EQ(serial, computeDensity(set, options, 8));
  }
}

TEST(DensityFilter, AsksAsManyAsItMay)
{
  const DirectionSet set = makeCaps({300, 200, 100, 50}, 350, 0.05, 3); // 1000
  DensityOptions options;
  options.kernel = DensityOptions::Kernel::Gaussian;
  options.radius = 0.3;
  const Eigen::VectorXd of_all = computeDensity(set, options);
  for (const auto& [most, stride] :
       {std::pair(1000, 1), {5000, 1}, {999, 3}, {334, 3}, {333, 5}, {100, 11}, {1, 1001}}) {
    options.max_queries = most;
    for (const unsigned threads : {1U, 3U}) {
      const Eigen::VectorXd density = computeDensity(set, options, threads);
      for (Eigen::Index i = 0; i < set.size(); ++i)
        EXPECT_EQ(density[i], i % stride == 0 ? of_all[i] : 0) << most << " " << i; // each against all others
    }
  }
}

/// The density at the peak of a region.
double
densityAtPeak(const DenseRegion& region, const DirectionSet& set, const Eigen::VectorXd& density)
{
  double highest = 0;
  for (Eigen::Index i = 0; i < set.size(); ++i)
    if (set.directions.col(i) == region.peak)
      highest = std::max(highest, density[i]);
  return highest;
}

TEST(DensityFilter, WhatWasNotAskedIsNoPeak)
{
  const DirectionSet set = makeCaps({}, 300, 0, 5); // all over the sphere
  DensityOptions options;
  options.silence_chord = 0.05;
  options.max_regions = 300;
  options.max_queries = 20;
  const Eigen::VectorXd density = computeDensity(set, options);
  const std::vector<DenseRegion> regions = findDensestRegions(set, density, options);
  EXPECT_GT(regions.size(), 10U);
  EXPECT_LE(regions.size(), 20U);
  for (const DenseRegion& region : regions)
    EXPECT_GT(densityAtPeak(region, set, density), 0);
}

TEST(DensityFilter, AsksBothWaysOfUnorientedNormals)
{
  // n and -n take turns in the image of unoriented samples: whichever is skipped, peaks come in opposite pairs.
  DirectionSet set = makeCaps({600, 300}, 100, 0.03, 4);
  const DirectionSet one_way = set;
  set.directions.resize(3, 2 * one_way.size());
  for (Eigen::Index i = 0; i < one_way.size(); ++i) {
    set.directions.col(2 * i) = one_way.directions.col(i);
    set.directions.col(2 * i + 1) = -one_way.directions.col(i);
  }
  set.weights = Eigen::VectorXd::Ones(set.size());
  DensityOptions options;
  options.kernel = DensityOptions::Kernel::Gaussian;
  options.radius = 0.1;
  options.max_regions = 4;
  for (const int most : {2000, 1000, 500, 300}) {
    options.max_queries = most;
    const std::vector<DenseRegion> regions = findDensestRegions(set, computeDensity(set, options), options);
    ASSERT_EQ(regions.size(), 4U) << most;
    for (const std::size_t k : {0U, 2U}) {
      const Eigen::Vector3d axis = k == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
      EXPECT_LT(regions[k].peak.dot(regions[k + 1].peak), -0.99) << most;
      EXPECT_GT(std::abs(regions[k].peak.dot(axis)), 0.99) << most;
    }
  }
}

TEST(DensityFilter, ManyEqualDirectionsAreCountedWholesale)
{
  // Normals of one exact wall and a noisy one: a search of all neighbours would take 2e10 steps for 200,000.
  const auto makeWalls = [](Eigen::Index half) {
    DirectionSet set = makeCaps({static_cast<int>(half)}, 0, 0.01, 6);
    set.directions.conservativeResize(3, 2 * half);
    set.directions.rightCols(half).colwise() = Eigen::Vector3d::UnitY();
    set.weights = Eigen::VectorXd::Ones(2 * half);
    return set;
  };
  const DirectionSet set = makeWalls(100000), small = makeWalls(1562);
  Eigen::VectorXd density;
  const double seconds = testing::processorSeconds([&] { density = computeDensity(set, DensityOptions()); });
  const double of_small = testing::processorSeconds([&] { computeDensity(small, DensityOptions()); });
  EXPECT_EQ(density[199999], 100000);
  EXPECT_GT(density[0], 50000);
  EXPECT_LT(seconds, 1500 * of_small); // 64 times the directions: 4096 when every one meets every other
}

TEST(DensityFilter, RegionsComeInOrderOfDensity)
{
  const DirectionSet set = makeCaps({500, 900, 300, 700}, 200, 0.015, 7);
  DensityOptions options;
  options.max_regions = 4;
  const Eigen::VectorXd density = computeDensity(set, options);
  const std::vector<DenseRegion> regions = findDensestRegions(set, density, options);
  ASSERT_EQ(regions.size(), 4U);
  const Eigen::Vector3d expected[] = {
      Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  for (std::size_t k = 0; k < regions.size(); ++k) {
    EXPECT_LT((regions[k].peak - expected[k]).norm(), 0.03) << k;
    // The region is exactly what lies within r_d of its peak.
    std::size_t inside = 0;
    for (Eigen::Index i = 0; i < set.size(); ++i)
      inside += (set.directions.col(i) - regions[k].peak).norm() <= options.radius ? 1 : 0;
    EXPECT_EQ(regions[k].members.size(), inside);
    EXPECT_EQ(regions[k].weight, static_cast<double>(inside));
    EXPECT_EQ(densityAtPeak(regions[k], set, density), static_cast<double>(inside));
  }
}

TEST(DensityFilter, PeaksKeepTheirDistance)
{
  const DirectionSet set = makeCaps({}, 3000, 0.01, 8);
  DensityOptions options;
  options.max_regions = 50;
  const Eigen::VectorXd density = computeDensity(set, options);
  const std::vector<DenseRegion> regions = findDensestRegions(set, density, options);
  ASSERT_GT(regions.size(), 20U);
  for (std::size_t i = 0; i < regions.size(); ++i)
    for (std::size_t j = i + 1; j < regions.size(); ++j) {
      EXPECT_GT((regions[i].peak - regions[j].peak).norm(), options.silence_chord);
      EXPECT_GE(densityAtPeak(regions[i], set, density), densityAtPeak(regions[j], set, density));
    }
}

TEST(DensityFilter, StopsAtWeakPeaks)
{
  const DirectionSet set = makeCaps({1000, 600, 30}, 0, 0.01, 9);
  DensityOptions options;
  options.min_relative_density = 0.1;
  EXPECT_EQ(findDensestRegions(set, computeDensity(set, options), options).size(), 2U);
  options.min_relative_density = 0;
  EXPECT_EQ(findDensestRegions(set, computeDensity(set, options), options).size(), 3U);
}

TEST(DensityFilter, ThinsLargeRegionsEvenly)
{
  const DirectionSet set = makeCaps({5000}, 0, 0.005, 10);
  DensityOptions options;
  options.max_region_points = 100;
  const std::vector<DenseRegion> regions = findDensestRegions(set, computeDensity(set, options), options);
  ASSERT_EQ(regions.size(), 1U);
  const std::vector<Eigen::Index>& members = regions[0].members;
  ASSERT_EQ(members.size(), 100U);
  EXPECT_EQ(regions[0].weight, 5000);
  EXPECT_TRUE(std::is_sorted(members.begin(), members.end()));
  EXPECT_EQ(members.front(), 0);
  EXPECT_GE(members.back(), 4900);
}

TEST(DensityFilter, RejectsCurvedSurfacesWhenAsked)
{
  // A floor and an upright cylinder, whose normals fill the equator evenly.
  testing::Random random(11);
  DirectionSet set = makeCaps({0, 0, 400}, 0, 0.01, 12);
  set.directions.conservativeResize(3, 10400);
  for (Eigen::Index i = 400; i < set.directions.cols(); ++i) {
    const double angle = random.uniform(0, 6.2832);
    set.directions.col(i) = scatter(Eigen::Vector3d(std::cos(angle), std::sin(angle), 0), 0.005, random);
  }
  set.weights = Eigen::VectorXd::Ones(set.size());
  DensityOptions options;
  options.max_regions = 30;
  const Eigen::VectorXd density = computeDensity(set, options);
  EXPECT_GT(findDensestRegions(set, density, options).size(), 10U);
  options.reject_elongated = true;
  const std::vector<DenseRegion> regions = findDensestRegions(set, density, options);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_LT((regions[0].peak - Eigen::Vector3d::UnitZ()).norm(), 0.05);
}

TEST(DensityFilter, EmptyAndSingle)
{
  const DensityOptions options;
  EXPECT_EQ(computeDensity(DirectionSet(), options).size(), 0);
  EXPECT_TRUE(findDensestRegions(DirectionSet(), Eigen::VectorXd(), options).empty());
  DirectionSet one;
  one.directions = Eigen::Vector3d::UnitZ();
  one.weights = Eigen::VectorXd::Constant(1, 2.5);
  const Eigen::VectorXd density = computeDensity(one, options);
  ASSERT_EQ(density.size(), 1);
  EXPECT_EQ(density[0], 2.5);
  const std::vector<DenseRegion> regions = findDensestRegions(one, density, options);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].members, std::vector<Eigen::Index>{0});
}

TEST(DensityFilter, TiesGoToTheSmallerColumn)
{
  DirectionSet set;
  set.directions.resize(3, 2);
  set.directions << 0, 1, 0, 0, 1, 0;
  set.weights = Eigen::VectorXd::Ones(2);
  DensityOptions options;
  options.max_regions = 1;
  const std::vector<DenseRegion> regions = findDensestRegions(set, computeDensity(set, options), options);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].peak, Eigen::Vector3d::UnitZ());
}

} // namespace
} // namespace pcl_ssfr::test_density_filter
