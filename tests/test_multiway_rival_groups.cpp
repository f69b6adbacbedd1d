// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Groups of scans that contradict each other more than they do among themselves.

#include "multiway/parts.h"
#include "multiway/rival_groups.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <random>

namespace pcl_ssfr::test_multiway_rival_groups {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

/// A part of scans, each pair with 200 matched patches of 400, 150 in view, and a share of both contradicted.
struct Part {
  std::vector<int> members;
  std::vector<std::pair<int, int>> pairs;
  std::vector<PlacementEvidence> evidence;
  RivalGroupsConfig config;
  std::vector<int> tied; ///< tiedScans()

  Part(const std::vector<int>& scans, const std::function<double(int, int)>& share)
      : members(scans), pairs(pairsOf(scans))
  {
    for (const auto& [a, b] : pairs)
      evidence.push_back({400, 200, 200 * share(a, b), 0.5, 150, 150 * share(a, b)});
  }
  std::optional<RivalGroups>
  find() const
  {
    return findRivalGroups(members, pairs, evidence, config, tied);
  }
};

/// A share that varies about a mean from pair to pair, the same in every run.
double
about(double mean, int a, int b)
{
  std::mt19937 random(static_cast<unsigned>(100 * a + b));
  return mean * (0.5 + static_cast<double>(random()) / 4294967296.0);
}

/// Even scans show one storey, odd ones the other.
double
ofStoreys(int a, int b)
{
  return about((a + b) % 2 == 0 ? 0.003 : 0.02, a, b);
}

TEST(RivalGroups, storeysOnOneAnother)
{
  const auto groups = Part({0, 1, 2, 3, 4, 5, 6, 7}, ofStoreys).find();
  ASSERT_TRUE(groups);
  EXPECT_THAT((std::vector<std::vector<int>>{groups->first, groups->second}),
              UnorderedElementsAre(ElementsAre(0, 2, 4, 6), ElementsAre(1, 3, 5, 7)));
  EXPECT_NEAR(groups->within, 0.003, 0.0015);
  EXPECT_NEAR(groups->between, 0.02, 0.01);
}

TEST(RivalGroups, scansThatAPersonTiedAreOfOneGroup)
{
  Part part({0, 1, 2, 3, 4, 5, 6, 7}, ofStoreys);
  part.tied = {0, 1, 2, 3, 4, 5, 0, 5}; // one pair of either storey
  auto groups = part.find();
  ASSERT_TRUE(groups);
  EXPECT_THAT((std::vector<std::vector<int>>{groups->first, groups->second}),
              UnorderedElementsAre(ElementsAre(0, 2, 4, 6), ElementsAre(1, 3, 5, 7)));
  part.tied = {0, 1, 2, 3, 4, 5, 6, 6}; // scan 6 of the one and scan 7 of the other
  groups = part.find();
  ASSERT_TRUE(groups);
  EXPECT_EQ(std::count(groups->first.begin(), groups->first.end(), 6),
            std::count(groups->first.begin(), groups->first.end(), 7));
  part.tied.assign(8, 3);
  EXPECT_FALSE(part.find());
}

TEST(RivalGroups, numbersOfScansDoNotMatter)
{
  const auto groups = Part({10, 20, 31, 43, 50, 61}, ofStoreys).find();
  ASSERT_TRUE(groups);
  EXPECT_THAT((std::vector<std::vector<int>>{groups->first, groups->second}),
              UnorderedElementsAre(ElementsAre(10, 20, 50), ElementsAre(31, 43, 61)));
}

TEST(RivalGroups, threeStoreys)
{
  const auto share = [](int a, int b) { return about(a % 3 == b % 3 ? 0.003 : 0.02, a, b); };
  const auto groups = Part({0, 1, 2, 3, 4, 5, 6, 7, 8}, share).find();
  ASSERT_TRUE(groups);
  for (const std::vector<int>* group : {&groups->first, &groups->second})
    for (const int scan : *group)
      EXPECT_EQ(scan % 3, group->front() % 3);
}

TEST(RivalGroups, onePlaceHasNone)
{
  for (const double mean : {0.0, 0.003, 0.009, 0.05}) // the last is noisy, but all pairs are alike
    EXPECT_FALSE(Part({0, 1, 2, 3, 4, 5, 6, 7}, [mean](int a, int b) { return about(mean, a, b); }).find()) << mean;
}

TEST(RivalGroups, whatIsContradictedLittleIsNoRival)
{
  const auto share = [](int a, int b) { return ofStoreys(a, b) / 4; }; // 0.005 between the groups
  EXPECT_FALSE(Part({0, 1, 2, 3, 4, 5, 6, 7}, share).find());
}

TEST(RivalGroups, oneScanIsNoGroup)
{
  const auto share = [](int a, int b) { return about(a == 3 || b == 3 ? 0.04 : 0.003, a, b); };
  EXPECT_FALSE(Part({0, 1, 2, 3, 4, 5}, share).find());
}

TEST(RivalGroups, pairsThatHardlyMeetDoNotCount)
{
  Part part({0, 1, 2, 3, 4, 5, 6, 7}, ofStoreys);
  for (std::size_t k = 0; k < part.pairs.size(); ++k)
    if ((part.pairs[k].first + part.pairs[k].second) % 2 == 1)
      part.evidence[k].matched = 0.1 * part.evidence[k].total;
  EXPECT_FALSE(part.find());
}

TEST(RivalGroups, tooFewPairsProveNothing)
{
  // Two and two: the ranks of four pairs between and two within differ by 1.9 standard deviations at most.
  EXPECT_FALSE(Part({0, 1, 2, 3}, ofStoreys).find());
  EXPECT_FALSE(Part({0, 1, 2}, ofStoreys).find());
  EXPECT_FALSE(Part({5}, ofStoreys).find());
  EXPECT_FALSE(Part({}, ofStoreys).find());
  Part apart({0, 1, 2, 3, 4, 5}, ofStoreys);
  apart.pairs.clear();
  apart.evidence.clear();
  EXPECT_FALSE(apart.find());
}

TEST(Hanging, theWorstScanGoesFirstAndClearsTheOthers)
{
  // Scan 2 contradicts all; without it nobody hangs, though 1 did with it.
  const auto share = [](int a, int b) { return a == 2 || b == 2 ? (a == 1 || b == 1 ? 0.3 : 0.12) : 0.01; };
  const Part part({0, 1, 2, 3}, share);
  EXPECT_THAT(findHanging(part.members, part.pairs, part.evidence, 14), ElementsAre(2));
  const Part all({0, 1, 2}, [](int, int) { return 0.1; });
  EXPECT_THAT(findHanging(all.members, all.pairs, all.evidence, 14), ElementsAre(0, 1)); // the last has nobody left
  const Part none({0, 1, 2}, [](int, int) { return 0.07; });                             // 1 / 14 is 0.0714
  EXPECT_TRUE(findHanging(none.members, none.pairs, none.evidence, 14).empty());
  EXPECT_TRUE(findHanging({}, {}, {}, 14).empty());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_rival_groups
