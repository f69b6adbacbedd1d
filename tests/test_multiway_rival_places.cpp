// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/rival_places.h"

#include <made_up_maps.h>

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_multiway_rival_places {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ClearOdds, areThoseOfLinksTimesThoseOfSurfaces)
{
  MultiwayOptions options; // odds of 100, the ninth power of the scores
  // By links alone: a hundred times the belief of the rival at equal scores.
  EXPECT_TRUE(isClear({50.1, 0.3}, {0.5, 0.3}, options));
  EXPECT_FALSE(isClear({49.9, 0.3}, {0.5, 0.3}, options));
  // By surfaces: 1.67^9 = 101 at equal beliefs, 1.66^9 = 96.
  EXPECT_TRUE(isClear({1, 1.67 * 0.2}, {1, 0.2}, options));
  EXPECT_FALSE(isClear({1, 1.66 * 0.2}, {1, 0.2}, options));
  // Both: 1.3^9 = 10.6, so ten times the belief is enough and nine times is not.
  EXPECT_TRUE(isClear({10, 0.26}, {1, 0.2}, options));
  EXPECT_FALSE(isClear({9, 0.26}, {1, 0.2}, options));
  options.choice.clear_odds = 10;
  EXPECT_TRUE(isClear({1, 0.26}, {1, 0.2}, options));
}

TEST(ClearOdds, aRivalThatScoresMoreCompetesWhateverTheLinksSay)
{
  const MultiwayOptions options;
  EXPECT_FALSE(isClear({1e9, 0.2}, {1e-9, 0.21}, options));
  EXPECT_FALSE(isClear({1e9, -0.2}, {1e-9, -0.1}, options)); // both hang in free space
}

TEST(ClearOdds, aRivalWhoseSurfacesHangIsNone)
{
  const MultiwayOptions options;
  EXPECT_TRUE(isClear({0, 0.1}, {5, 0}, options));
  EXPECT_TRUE(isClear({0, 0.1}, {5, -1}, options));
  EXPECT_FALSE(isClear({0, 0.1}, {5, 0.01}, options)); // no link says so, and the surfaces do not make up for it
}

TEST(ClearOdds, linksSayNoMoreThanTheyAreTrusted)
{
  const ChoiceConfig config;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(logOdds({20, 0.3}, {1, 0.3}, kInfinity, config), std::log(20), 1e-12);
  EXPECT_NEAR(logOdds({20, 0.3}, {1, 0.3}, 2, config), 2, 1e-12);
  EXPECT_NEAR(logOdds({1, 0.3}, {20, 0.3}, 2, config), -std::log(20), 1e-12); // what they say against it counts
  EXPECT_NEAR(logOdds({20, 0.4}, {1, 0.2}, 0, config), config.score_power * std::log(2), 1e-12);
  EXPECT_EQ(logOdds({1, 0.1}, {1, 0}, 2, config), kInfinity);
  EXPECT_EQ(logOdds({1, 0}, {1, 0.1}, 2, config), -kInfinity);
  EXPECT_EQ(logOdds({0, 0.3}, {0, 0.1}, 2, config), -kInfinity); // no link says either
}

/// Five scans that are placed as they are; scan 4 may stand elsewhere. What the others see of it decides.
class RivalPlaces : public ::testing::Test {
protected:
  RivalPlaces()
  {
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        job_.addTrue(i, j);
  }

  /// Scans that have rivals, of those whose links are in the job.
  std::vector<int>
  find(const Piles& piles = {}, const Decisions& decisions = {}, const std::vector<int>& part = {0, 0, 0, 0, 0}) const
  {
    Assembly assembly;
    assembly.poses = job_.truth;
    assembly.part = part;
    HypothesisGraph graph;
    for (std::size_t k = 0; k < job_.links.size(); ++k) {
      graph.first.push_back(graph.hypotheses.size());
      for (std::size_t rank = 0; rank < job_.links[k].hypotheses.size(); ++rank) {
        const double p = job_.links[k].hypotheses[rank].probability;
        graph.hypotheses.push_back({k, rank, p, p});
      }
    }
    graph.first.push_back(graph.hypotheses.size());
    const EvidenceFunction evidence = [this](int source, int target, const Eigen::Isometry3d& T, double looseness) {
      EXPECT_EQ(looseness, ChoiceConfig().loose);
      PlacementEvidence e;
      e.total = 100;
      const bool is_here = (T.translation() - job_.relative(source, target).translation()).norm() < 0.5;
      const bool is_of_pile = is_pile_ && source >= 3 && target >= 3;
      e.matched = is_of_pile ? 90 : is_here ? here_ : there_;
      return e;
    };
    std::vector<int> found;
    MultiwayOptions options;
    for (const unsigned threads : {1U, 3U}) {
      options.threads = threads;
      const std::vector<int> now = findScansWithRivals(
          {0, 1, 2, 3, 4}, {assembly, job_.links, graph, job_.places}, evidence, piles, decisions, options);
      EXPECT_TRUE(threads == 1U || now == found);
      found = now;
    }
    return found;
  }

  testing::MadeUpJob job_{5};
  const Eigen::Vector3d elsewhere_{0, 9, 0}; // [m] off in the map
  double here_ = 30, there_ = 25;            // of 100, of scan 4 that the others match
  bool is_pile_ = false;                     // scans 3 and 4 see the same
};

TEST_F(RivalPlaces, noOtherPlaceNoRival)
{
  job_.addTrue(0, 4, 0.9);
  EXPECT_THAT(find(), IsEmpty());
}

TEST_F(RivalPlaces, areCloseInLinksAndSurfaces)
{
  job_.addTrue(0, 4, 0.9);
  job_.addFalse(1, 4, elsewhere_, 0.6);
  EXPECT_THAT(find(), ElementsAre(1, 4)); // a link moves both of its scans
  there_ = 15;                            // 2^9 to one
  EXPECT_THAT(find(), IsEmpty());
  there_ = 31; // explains more, whatever the links say
  EXPECT_THAT(find(), ElementsAre(1, 4));
}

TEST_F(RivalPlaces, linksThatAgreeAddUp)
{
  for (const int i : {0, 1, 2})
    job_.addTrue(i, 4, 0.9);
  job_.addFalse(3, 4, elsewhere_, 0.3);
  there_ = 22; // (30 / 22)^9 = 16.3, times 2.7 / 0.3 it is clear
  EXPECT_THAT(find(), IsEmpty());
  job_.links.erase(job_.links.begin() + 3); // the link 0, 4: times 1.8 / 0.3 it is not
  EXPECT_THAT(find(), ElementsAre(4));
}

TEST_F(RivalPlaces, ofLittleProbabilityAreNone)
{
  job_.addTrue(0, 4, 0.9);
  job_.addFalse(1, 4, elsewhere_, 0.09);
  there_ = 40;
  EXPECT_THAT(find(), IsEmpty());
}

TEST_F(RivalPlaces, aPersonKnowsBetter)
{
  job_.addTrue(0, 4, 0.9);
  job_.addFalse(1, 4, elsewhere_, 0.6);
  Decisions decisions;
  decisions.accepted = {{0, 4}};
  EXPECT_THAT(find({}, decisions), ElementsAre(1));
}

TEST_F(RivalPlaces, areOfOnePart)
{
  job_.addTrue(0, 4, 0.9);
  job_.addFalse(1, 4, elsewhere_, 0.6);
  EXPECT_THAT(find({}, {}, {0, 1, 0, 0, 0}), IsEmpty());
  EXPECT_THAT(find({}, {}, {1, 0, 2, 2, 0}), IsEmpty()); // two scans: nothing else says which
}

TEST_F(RivalPlaces, scansOfAPileDoNotConfirmEachOther)
{
  // Scans 3 and 4 see the same and stand where scan 3 is; scan 4 is as probably at another place by what it sees of 0,
  // though its link hardly says so.
  is_pile_ = true;
  job_.truth[4] = job_.truth[3];
  job_.addTrue(3, 4, 0.99);
  job_.addTrue(0, 4, 0.9);
  job_.addFalse(1, 4, elsewhere_, 0.02);
  EXPECT_THAT(find(), IsEmpty());
  const Piles piles = {{3, {3, 4}}, {4, {3, 4}}};
  EXPECT_THAT(find(piles), ElementsAre(4));
  there_ = 15; // clear by the surfaces of the others
  EXPECT_THAT(find(piles), IsEmpty());
}

TEST_F(RivalPlaces, aPileByItselfHasOneWhereThereAreOthers)
{
  // Scans 0 to 2 see the same; 3 and 4 are in parts of their own.
  const Piles piles = {{0, {0, 1, 2}}, {1, {0, 1, 2}}, {2, {0, 1, 2}}};
  job_.links.clear();
  for (const auto& [i, j] : {std::pair(0, 1), {0, 2}, {1, 2}})
    job_.addTrue(i, j);
  EXPECT_THAT(find(piles, {}, {0, 0, 0, 3, 4}), IsEmpty()); // a sensor that stood there
  job_.addTrue(0, 3, 0.01);                                 // it was looked at whether scan 3 shows them
  EXPECT_THAT(find(piles, {}, {0, 0, 0, 3, 4}), ElementsAre(0));
  EXPECT_THAT(find({}, {}, {0, 0, 0, 3, 4}), IsEmpty());
}

TEST_F(RivalPlaces, ofNothingAreNone)
{
  HypothesisGraph graph;
  graph.first.push_back(0);
  EXPECT_THAT(findScansWithRivals({}, {Assembly(), {}, graph, {}}, nullptr, {}, {}, MultiwayOptions()), IsEmpty());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_rival_places
