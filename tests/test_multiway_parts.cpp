// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Parts of a map: the odds of a place against its rivals, sure links that contradict a part, pieces of parts.

#include "multiway/parts.h"

#include <made_up_maps.h>
#include <scan_views.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

namespace pcl_ssfr::test_multiway_parts {
namespace {

using ::testing::ElementsAre;

/// The upper tail by adding up all ways that links can be wrong.
double
tailByCounting(int all, int contradicted, double wrong)
{
  double sum = 0;
  for (int pattern = 0; pattern < 1 << all; ++pattern) {
    int count = 0;
    for (int k = 0; k < all; ++k)
      count += (pattern >> k) & 1;
    if (count >= contradicted)
      sum += std::pow(wrong, count) * std::pow(1 - wrong, all - count);
  }
  return sum;
}

std::vector<double>
claims(int all, double wrong)
{
  return std::vector<double>(static_cast<std::size_t>(all), wrong);
}

TEST(SureLinks, areRefutedWhenChanceDoesNotExplainWhatContradicts)
{
  const ChoiceConfig config;
  int refuted = 0;
  for (int all = 0; all <= 12; ++all)
    for (int contradicted = 0; contradicted <= all; ++contradicted)
      for (const double wrong : {0.05, 1.0 / 101}) {
        const bool expected = tailByCounting(all, contradicted, wrong) < 0.01;
        EXPECT_EQ(isRefuted({claims(all, wrong), contradicted}, config), expected) << all << ", " << contradicted;
        refuted += expected ? 1 : 0;
      }
  EXPECT_GT(refuted, 100);
  EXPECT_FALSE(isRefuted({{}, 0}, config));
  EXPECT_FALSE(isRefuted({claims(1000, 1.0 / 101), 0}, config));
  EXPECT_FALSE(isRefuted({claims(1000, 1.0 / 101), 10}, config)); // as many as they claim
  EXPECT_TRUE(isRefuted({claims(1000, 1.0 / 101), 25}, config));
  // Each by its own claim: 0.02 * 0.03 = 0.0006 is too little, 0.2 * 0.3 = 0.06 is not.
  EXPECT_TRUE(isRefuted({{0.02, 0.03}, 2}, config));
  EXPECT_FALSE(isRefuted({{0.2, 0.3}, 2}, config));
}

/// Six scans of which 0 to 3 are one part; all pairs are linked, those with 4 and 5 at poses of no use.
class Parts : public ::testing::Test {
protected:
  Parts() : job_(6)
  {
    for (int i = 0; i < 6; ++i)
      for (int j = i + 1; j < 6; ++j)
        job_.add(i, j, job_.relative(i, j), 0.97);
    assembly_.part = {7, 7, 7, 7, 4, 5};
    assembly_.poses = job_.truth;
    for (const PairLink& link : job_.links)
      assembly_.used.push_back(link.target < 4 ? 0 : -1);
    // No loops: beliefs by hand.
    for (std::size_t k = 0; k < job_.links.size(); ++k) {
      graph_.first.push_back(k);
      graph_.hypotheses.push_back({k, 0, 0.97, k % 2 == 0 ? 0.995 : 0.9});
    }
    graph_.first.push_back(job_.links.size());
  }
  SureLinks
  count(int part, SureBy by) const
  {
    return countSureLinks(assembly_, job_.links, graph_, part, by, ChoiceConfig());
  }

  testing::MadeUpJob job_;
  Assembly assembly_;
  HypothesisGraph graph_;
};

TEST_F(Parts, sureLinksAreCountedWhereTheyTouch)
{
  const SureLinks whole = count(7, SureBy::Pair); // all but that of 4 and 5
  EXPECT_EQ(whole.wrong.size(), 14U);
  EXPECT_EQ(whole.contradicted, 8);
  for (const double wrong : whole.wrong)
    EXPECT_NEAR(wrong, 0.03, 1e-12);
  for (const double wrong : count(7, SureBy::Loops).wrong)
    EXPECT_NEAR(wrong, 1.0 / 101, 1e-12); // no belief claims more than clear odds
  EXPECT_EQ(count(4, SureBy::Pair).wrong.size(), 5U);
  EXPECT_EQ(count(4, SureBy::Pair).contradicted, 5);
  job_.links[0].confidence = 0.9;            // too doubtful by itself
  job_.links[1].status = Status::LowOverlap; // not aligned
  EXPECT_EQ(count(7, SureBy::Pair).wrong.size(), 12U);
  EXPECT_EQ(count(7, SureBy::Loops).wrong.size(), 7U); // every second one, without that of 4 and 5
  assembly_.used[0] = 1;                               // the map has another pose of the pair
  EXPECT_EQ(count(7, SureBy::Loops).contradicted, count(7, SureBy::Pair).contradicted == 8 ? 5 : -1);
}

TEST_F(Parts, linksThatAreRejectedDoNotCount)
{
  for (std::size_t k = 1; k < graph_.hypotheses.size(); ++k) // all but 0 - 1
    graph_.hypotheses[k].prior = 0;
  for (const SureBy by : {SureBy::Pair, SureBy::Loops}) {
    EXPECT_EQ(count(7, by).wrong.size(), 1U);
    EXPECT_EQ(count(7, by).contradicted, 0);
  }
}

TEST_F(Parts, piecesThatNothingHoldsTogetherFallApart)
{
  for (std::size_t k = 0; k < job_.links.size(); ++k) // only 0 - 2 and 1 - 3 are left
    if (!(job_.links[k].source + 2 == job_.links[k].target && job_.links[k].target < 4))
      assembly_.used[k] = -1;
  splitUnconnected(assembly_, job_.links, graph_, ChoiceConfig());
  EXPECT_THAT(assembly_.part, ElementsAre(0, 1, 0, 1, 4, 5));
  EXPECT_EQ(std::count_if(assembly_.used.begin(), assembly_.used.end(), [](int used) { return used >= 0; }), 2);
  EXPECT_EQ(nextPart(assembly_), 6);
  EXPECT_EQ(membersOf(assembly_).at(1), (std::vector<int>{1, 3}));
  EXPECT_THAT(pairsOf({2, 5, 6}), ElementsAre(std::make_pair(2, 5), std::make_pair(2, 6), std::make_pair(5, 6)));
}

TEST_F(Parts, linksThatAreNotSureHoldNothingTogether)
{
  for (std::size_t k = 0; k < job_.links.size(); ++k)
    if (job_.links[k].source == 3 || job_.links[k].target == 3)
      graph_.hypotheses[k].belief = 0.4;
  splitUnconnected(assembly_, job_.links, graph_, ChoiceConfig());
  EXPECT_THAT(assembly_.part, ElementsAre(0, 0, 0, 3, 4, 5));
  for (std::size_t k = 0; k < job_.links.size(); ++k)
    if (job_.links[k].source == 3 || job_.links[k].target == 3) {
      EXPECT_EQ(assembly_.used[k], -1) << "a link between two parts";
    }
}

TEST(WeakestCuts, comeLightestFirstAndAreTheSmallerSides)
{
  // 1 - 3 - 4 in a row, 7 - 8 - 9 in another, held together by 4 - 7; 3 - 8 is lighter, and in no tree.
  const std::vector<WeightedEdge> edges = {{1, 3, 5}, {4, 3, 6}, {4, 7, 0.5}, {3, 8, 0.4}, {7, 8, 3}, {8, 9, 4}};
  const std::vector<std::vector<int>> expected = {{7, 8, 9}, {8, 9}, {9}, {1}, {1, 3}};
  const std::vector<std::vector<int>> cuts = weakestCuts({1, 3, 4, 7, 8, 9}, edges);
  EXPECT_EQ(cuts[0], expected[0]); // of equal sides the one without the first scan
  EXPECT_EQ(cuts[1], expected[1]);
  EXPECT_EQ(cuts[2], expected[2]);
  EXPECT_EQ(cuts[3], expected[3]);
  EXPECT_EQ(cuts[4], expected[4]);
  EXPECT_EQ(cuts.size(), 5U);
  EXPECT_TRUE(weakestCuts({3}, {}).empty());
  EXPECT_EQ(weakestCuts({3, 5}, {{5, 3, -1}, {3, 5, -2}}), (std::vector<std::vector<int>>{{5}}));
}

TEST(WeakestCuts, areThoseOfTheHeaviestOfAllTrees)
{
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> weight(-3, 5);
  const std::vector<int> members = {0, 2, 3, 5, 6};
  const auto pieces = [&](const std::vector<WeightedEdge>& edges) { // of each member
    std::vector<std::size_t> piece(members.size());
    std::iota(piece.begin(), piece.end(), std::size_t(0));
    for (std::size_t round = 0; round < members.size(); ++round)
      for (const WeightedEdge& e : edges) {
        const auto a = std::lower_bound(members.begin(), members.end(), e.a) - members.begin();
        const auto b = std::lower_bound(members.begin(), members.end(), e.b) - members.begin();
        piece[a] = piece[b] = std::min(piece[a], piece[b]);
      }
    return piece;
  };
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<WeightedEdge> edges;
    for (const auto& [a, b] : pairsOf(members))
      edges.push_back({a, b, weight(generator)});
    std::vector<WeightedEdge> heaviest;
    double most = -1e9;
    for (int set = 0; set < 1 << edges.size(); ++set) {
      std::vector<WeightedEdge> tree;
      double sum = 0;
      for (std::size_t k = 0; k < edges.size(); ++k)
        if ((set >> k) & 1) {
          tree.push_back(edges[k]);
          sum += edges[k].weight;
        }
      const std::vector<std::size_t> piece = pieces(tree);
      if (tree.size() + 1 == members.size() && std::count(piece.begin(), piece.end(), 0U) == 5 && sum > most) {
        most = sum;
        heaviest = tree;
      }
    }
    std::sort(heaviest.begin(), heaviest.end(), [](const auto& a, const auto& b) { return a.weight < b.weight; });
    std::vector<std::vector<int>> expected;
    for (std::size_t cut = 0; cut < heaviest.size(); ++cut) {
      std::vector<WeightedEdge> left = heaviest;
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(cut));
      const std::vector<std::size_t> piece = pieces(left);
      std::vector<int> with_first, rest;
      for (std::size_t i = 0; i < members.size(); ++i)
        (piece[i] == 0 ? with_first : rest).push_back(members[i]);
      expected.push_back(rest.size() < with_first.size() ? rest : with_first);
    }
    EXPECT_EQ(weakestCuts(members, edges), expected) << trial;
  }
}

/// Scans 2, 4, 5 and 8 at 0, 0.6, 0.9 and 1.2 m; scan 5 sees something else than the others.
Piles
pilesOf(std::size_t least, double within, double least_matched)
{
  const std::vector<int> members = {2, 4, 5, 8};
  std::vector<Eigen::Vector3d> stations;
  for (const double x : {0.0, 0.6, 0.9, 1.2})
    stations.emplace_back(x, 7, -1);
  const auto pairs = pairsOf(members);
  std::vector<PlacementEvidence> evidence;
  for (const auto& [i, j] : pairs) {
    PlacementEvidence e;
    e.matched = i == 5 || j == 5 ? 40 : 90;
    evidence.push_back(e);
  }
  const auto counts = [&](const PlacementEvidence& e) { return e.matched >= least_matched; };
  return findPiles(members, stations, within, pairs, evidence, counts, least);
}

TEST(ScansAtOnePlace, arePilesOfThoseThatCount)
{
  const Piles all = pilesOf(3, 1, 0);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_THAT(all.at(2), ElementsAre(2, 4, 5)); // 8 is 1.2 m away
  EXPECT_THAT(all.at(4), ElementsAre(2, 4, 5, 8));
  EXPECT_THAT(all.at(8), ElementsAre(4, 5, 8));
  EXPECT_TRUE(pilesOf(5, 1, 0).empty());
  const Piles near = pilesOf(3, 0.4, 0);
  ASSERT_EQ(near.size(), 1U);
  EXPECT_THAT(near.at(5), ElementsAre(4, 5, 8));
  const Piles alike = pilesOf(3, 1, 50);
  ASSERT_EQ(alike.size(), 1U); // without 5
  EXPECT_THAT(alike.at(4), ElementsAre(2, 4, 8));
  EXPECT_TRUE(pilesOf(2, 1, 100).empty());
  EXPECT_TRUE(findPiles(
                  {}, {}, 1, {}, {}, [](const PlacementEvidence&) { return true; }, 2)
                  .empty());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_parts
