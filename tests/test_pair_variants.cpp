// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pair_variants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

namespace {

using namespace pcl_ssfr;
using namespace pcl_ssfr::benchmarks;

/// Points on a circle of 360, one a degree, at ranges 1, 2, 3, ... [m].
pcl::PointCloud<pcl::PointXYZ>
spiral()
{
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (int i = 0; i < 360; ++i) {
    const double angle = (i + 0.5) / 180 * std::acos(-1.0);
    const double range = i + 1;
    scan.push_back({static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)), 0.f});
  }
  return scan;
}

std::vector<int>
rangesOf(const pcl::PointCloud<pcl::PointXYZ>& scan)
{
  std::vector<int> ranges;
  for (const pcl::PointXYZ& p : scan)
    ranges.push_back(static_cast<int>(std::lround(p.getVector3fMap().norm())));
  return ranges;
}

TEST(Spoiled, NothingByDefault)
{
  EXPECT_EQ(spoiled(spiral(), Spoil(), 1)->size(), 360u);
  EXPECT_TRUE(spoiled(pcl::PointCloud<pcl::PointXYZ>(), Spoil{3, 90, 0.5}, 1)->empty());
}

TEST(Spoiled, EveryNth)
{
  const auto ranges = rangesOf(*spoiled(spiral(), Spoil{100, 360, 1}, 1));
  EXPECT_THAT(ranges, ::testing::ElementsAre(1, 101, 201, 301));
}

TEST(Spoiled, NearestShareInItsOrder)
{
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (const float range : {5.f, 1.f, 4.f, 2.f, 3.f})
    scan.push_back({0, range, 0});
  EXPECT_THAT(rangesOf(*spoiled(scan, Spoil{1, 360, 0.6}, 1)), ::testing::ElementsAre(1, 2, 3));
  EXPECT_TRUE(spoiled(scan, Spoil{1, 360, 0}, 1)->empty());
}

TEST(Spoiled, ASectorInOnePiece)
{
  std::set<std::vector<int>> sectors;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto kept = rangesOf(*spoiled(spiral(), Spoil{1, 90, 1}, seed));
    EXPECT_NEAR(static_cast<double>(kept.size()), 90, 1);
    int gaps = 0; // around the circle
    for (std::size_t i = 0; i < kept.size(); ++i)
      gaps += (kept[(i + 1) % kept.size()] - kept[i] + 360) % 360 != 1;
    EXPECT_EQ(gaps, 1);
    EXPECT_EQ(kept, rangesOf(*spoiled(spiral(), Spoil{1, 90, 1}, seed)));
    sectors.insert(kept);
  }
  EXPECT_GT(sectors.size(), 3u);
  EXPECT_TRUE(spoiled(spiral(), Spoil{1, 0, 1}, 1)->empty());
}

TEST(Spoiled, NamesWhatIsOutOfRange)
{
  for (const auto& [spoil, name] : std::vector<std::pair<Spoil, std::string>>{
           {{0, 360, 1}, "every"}, {{1, 361, 1}, "sector"}, {{1, -1, 1}, "sector"}, {{1, 360, 1.5}, "nearest"}})
    try {
      spoiled(spiral(), spoil, 1);
      FAIL() << name;
    }
    catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(name));
    }
}

io::ScanPair
pairOf(const char* source, const char* target, double x)
{
  io::ScanPair pair{source, target, Eigen::Isometry3d::Identity()};
  pair.T_target_source.translation().x() = x;
  return pair;
}

TEST(OtherPairs, TheOtherWayRoundAndAlongChains)
{
  // c -> b -> a in steps of 1 and 2 m; y -> x apart from them.
  const auto others = otherPairs({pairOf("b", "a", 2), pairOf("c", "b", 1), pairOf("y", "x", 7)});
  std::vector<std::string> found;
  found.reserve(others.size());
  for (const io::ScanPair& pair : others)
    found.push_back(pair.source + pair.target + " " +
                    std::to_string(std::lround(pair.T_target_source.translation().x())));
  EXPECT_THAT(found, ::testing::UnorderedElementsAre("ab -2", "bc -1", "ca 3", "ac -3", "xy -7"));
}

TEST(OtherPairs, NoneOfNothing)
{
  EXPECT_TRUE(otherPairs({}).empty());
  EXPECT_TRUE(otherPairs({pairOf("a", "b", 1), pairOf("b", "a", -1)}).empty());
}

} // namespace
