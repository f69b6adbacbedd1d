// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Scans of places that look alike, put together by what distinguishes these.

#include "judgement/scored_pose.h"
#include "multiway/same_place.h"

#include <made_up_maps.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_multiway_same_place {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Eigen::Isometry3d
shifted(double x)
{
  return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0));
}

TEST(SamePlaceOdds, addUpAndAreLookedAtOnce)
{
  const std::vector<Eigen::Vector3d> places(4, Eigen::Vector3d::Zero());
  for (const unsigned threads : {1U, 4U}) {
    MultiwayOptions options;
    options.threads = threads;
    std::atomic<int> looks{0};
    SamePlaceOdds odds(
        [&](const PlacedPair& pair) {
          EXPECT_LT(pair.source, pair.target);
          ++looks;
          return 10.0 * pair.source + pair.target + pair.T_target_source.translation().x();
        },
        places,
        options);
    EXPECT_EQ(odds.of({}), 0);
    EXPECT_NEAR(odds.of({{0, 1, shifted(0.5)}, {1, 3, shifted(2)}}), 1 + 0.5 + 13 + 2, 1e-12);
    EXPECT_EQ(looks, 2);
    EXPECT_NEAR(odds.of({{1, 0, shifted(-0.5)}}), 1.5, 1e-12); // the other way round is the same pair
    EXPECT_NEAR(odds.of({{0, 1, shifted(0.53)}}), 1.5, 1e-12); // within a tenth of 0.4 m
    EXPECT_EQ(looks, 2);
    EXPECT_NEAR(odds.of({{0, 1, shifted(0.55)}}), 1.55, 1e-12);
    EXPECT_EQ(looks, 3);
  }
}

TEST(SamePlaceOdds, whatIsUnrelatedSaysNothing)
{
  const std::vector<Eigen::Vector3d> places(3, Eigen::Vector3d::Zero());
  int looks = 0;
  MultiwayOptions options;
  options.threads = 1;
  SamePlaceOdds odds(
      [&](const PlacedPair&) {
        ++looks;
        return 1.0;
      },
      places,
      options,
      [](int, int, double distance) { return distance > 5; });
  EXPECT_EQ(odds.of({{0, 1, shifted(6)}, {0, 2, shifted(1)}, {2, 1, shifted(7)}}), 1);
  EXPECT_EQ(looks, 1);
}

TEST(SamePlaceOdds, whereThereIsNoHopeNobodyElseIsAsked)
{
  constexpr int kScans = 300;
  const std::vector<Eigen::Vector3d> places(kScans, Eigen::Vector3d::Zero());
  std::vector<PlacedPair> pairs;
  for (int k = 1; k < kScans; ++k)
    pairs.push_back({0, k, shifted(k)});
  for (const double each : {-10.0, -0.1, 0.2}) {
    double sums[2] = {};
    for (const unsigned threads : {1U, 4U}) {
      MultiwayOptions options;
      options.threads = threads;
      std::vector<char> is_asked(kScans, 0);
      const auto look = [&](const PlacedPair& pair) {
        is_asked[static_cast<std::size_t>(pair.target)] = 1;
        return each;
      };
      SamePlaceOdds all(look, places, options);
      const double expected = all.of(pairs);
      is_asked.assign(kScans, 0);
      SamePlaceOdds hopeful(look, places, options);
      const double sum = hopeful.of(pairs, -100);
      sums[threads == 1 ? 0 : 1] = sum;
      const auto count = std::count(is_asked.begin(), is_asked.end(), 1);
      if (each < -1) {
        EXPECT_LT(count, 100);
        EXPECT_LT(sum, -100);
      }
      else {
        EXPECT_EQ(count, kScans - 1);
        EXPECT_EQ(sum, expected);
      }
    }
    EXPECT_EQ(sums[0], sums[1]);
  }
}

/** Two rooms alike, 30 m apart, with three scans each that see all of each other; scan 6 stands between the rooms and
 * sees 2 and 3. The sensors stand at other places in the one room than in the other.
 */
class RoomsAlike : public ::testing::Test {
protected:
  RoomsAlike()
  {
    for (std::size_t i = 0; i < 3; ++i) {
      job_.truth[i + 3] = Eigen::Translation3d(kApart + 1, 0.6, 0) * job_.truth[i];
      job_.truth[i + 3].rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
    }
    job_.truth[6].translation() << 18, 0, 0;
    for (const int room : {0, 3})
      for (int i = room; i < room + 3; ++i)
        for (int j = i + 1; j < room + 3; ++j)
          job_.addTrue(i, j, 0.9);
    job_.addTrue(2, 6, 0.8);
    job_.addTrue(3, 6, 0.8);
    for (int i = 0; i < 3; ++i)
      for (int j = 3; j < 6; ++j)
        job_.addFalse(i, j, {kApart, 0, 0}, 0.99); // surer than the right ones, and they all agree
    options_.threads = 2;
  }

  /// What furniture says: something for one room, more against two, nothing where no other room is laid onto this one.
  double
  oddsOf(const PlacedPair& pair) const
  {
    const Eigen::Isometry3d T_map = job_.truth[static_cast<std::size_t>(pair.target)] * pair.T_target_source *
                                    job_.truth[static_cast<std::size_t>(pair.source)].inverse();
    const auto roomOf = [](int scan) { return scan == 6 ? 2 : scan / 3; };
    const bool is_right = translationBetween(T_map, Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero()) < 0.5;
    if (is_right)
      return roomOf(pair.source) == roomOf(pair.target) || pair.target == 6 ? for_ : 0;
    return pair.target == 6 || unknown_ == std::pair(pair.source, pair.target) ? 0 : -against_;
  }

  Assembly
  assembled(const Decisions& decisions = {}, const JoinTest& join_test = nullptr)
  {
    graph_ = weighHypotheses(job_.links, job_.places, decisions, options_);
    SamePlaceOdds odds([this](const PlacedPair& pair) { return oddsOf(pair); }, job_.places, options_);
    const JoinRule rule = {0, 0, false}; // half of the sure links are false: they say nothing
    return assemble(job_.links, graph_, job_.places, odds, rule, decisions, job_.names, options_, join_test);
  }

  std::vector<int>
  withRivals(const Assembly& assembly, const Decisions& decisions = {})
  {
    graph_ = weighHypotheses(job_.links, job_.places, decisions, options_);
    SamePlaceOdds odds([this](const PlacedPair& pair) { return oddsOf(pair); }, job_.places, options_);
    const EvidenceFunction evidence = [this](int source, int target, const Eigen::Isometry3d& T, double) {
      PlacementEvidence seen;
      seen.total = 100;
      const Eigen::Isometry3d off = job_.relative(source, target).inverse() * T;
      seen.matched = off.translation().norm() < 0.5 ? matched_ : 20;
      return seen;
    };
    const PlacedScans placed = {assembly, job_.links, graph_, job_.places};
    groups_ = groupsOf({0, 1, 2, 3, 4, 5, 6}, placed, odds);
    group_with_rival_ = findGroupWithRivalAlike(groups_, placed, odds, evidence, most_by_links_, options_);
    return findScansWithRivalsAlike({0, 1, 2, 3, 4, 5, 6}, placed, odds, evidence, most_by_links_, decisions, options_);
  }

  /// All as they are, the second room and its scans in a part of their own where asked for.
  Assembly
  asTheyAre(const std::vector<int>& part = {0, 0, 0, 0, 0, 0, 0}) const
  {
    Assembly assembly;
    assembly.poses = job_.truth;
    assembly.part = part;
    assembly.used.assign(job_.links.size(), -1);
    return assembly;
  }

  static constexpr double kApart = 30; // [m]
  testing::MadeUpJob job_{7};
  MultiwayOptions options_;
  HypothesisGraph graph_;
  double for_ = 1, against_ = 3;
  double matched_ = 20; // surface of two scans that meets where they are, of 20 elsewhere
  double most_by_links_ = 0;
  std::pair<int, int> unknown_{-1, -1};
  std::vector<std::vector<int>> groups_; // of what withRivals() was asked about last ...
  std::vector<int> group_with_rival_;    // ... and the first of them that has one
};

TEST_F(RoomsAlike, surerLinksOfPlacesAlikeJoinNothing)
{
  const Assembly assembly = assembled();
  EXPECT_THAT(assembly.part, Each(assembly.part[0]));
  for (int i = 1; i < 7; ++i)
    EXPECT_LT(((assembly.poses[static_cast<std::size_t>(i)].inverse() * assembly.poses[0]).translation() -
               job_.relative(0, i).translation())
                  .norm(),
              0.1)
        << i;
  for (std::size_t k = 0; k < job_.links.size(); ++k)
    EXPECT_EQ(assembly.used[k],
              job_.links[k].source < 3 && job_.links[k].target >= 3 && job_.links[k].target < 6 ? -1 : 0);
}

TEST_F(RoomsAlike, areTheSameForAnyThreads)
{
  options_.threads = 1;
  const Assembly one = assembled();
  options_.threads = 3;
  const Assembly three = assembled();
  for (std::size_t i = 0; i < one.poses.size(); ++i)
    EXPECT_TRUE(one.poses[i].matrix() == three.poses[i].matrix());
  EXPECT_EQ(one.part, three.part);
}

TEST_F(RoomsAlike, withoutWhatDistinguishesThemNothingIsJoined)
{
  for_ = against_ = 0;
  const Assembly assembly = assembled();
  EXPECT_EQ(std::set<int>(assembly.part.begin(), assembly.part.end()).size(), 7U);
  EXPECT_THAT(assembly.refusal, Each(HasSubstr("look alike")));
}

TEST_F(RoomsAlike, anAcceptedLinkJoinsWhateverIsSeen)
{
  against_ = for_ = 0;
  Decisions decisions;
  decisions.accepted.insert({2, 6});
  const Assembly assembly = assembled(decisions);
  EXPECT_EQ(assembly.part[2], assembly.part[6]);
  EXPECT_NE(assembly.part[2], assembly.part[0]);
}

TEST_F(RoomsAlike, whatAPersonExcludesIsNotJoined)
{
  const Assembly assembly = assembled({}, [](const std::vector<PlacedPair>& pairs) {
    for (const PlacedPair& pair : pairs)
      if ((pair.source == 3 && pair.target == 6) || (pair.source == 6 && pair.target == 3))
        return "known to be elsewhere";
    return "";
  });
  EXPECT_EQ(assembly.part[0], assembly.part[6]);
  EXPECT_EQ(assembly.part[3], assembly.part[5]);
  EXPECT_NE(assembly.part[0], assembly.part[3]);
}

TEST_F(RoomsAlike, scansWithoutARivalThatCountsAreClear)
{
  EXPECT_THAT(withRivals(asTheyAre()), IsEmpty());
  against_ = 0; // what speaks for here is worth less than 100 to one
  EXPECT_THAT(withRivals(asTheyAre()), ElementsAre(0, 1, 2, 3, 4, 5));
  Decisions decisions;
  decisions.accepted.insert({1, 2}); // rivals of 1 come before it
  EXPECT_THAT(withRivals(asTheyAre(), decisions), ElementsAre(0, 3, 4, 5));
}

TEST_F(RoomsAlike, linksAndSurfacesAddToWhatIsSeenOfThem)
{
  against_ = 0;
  matched_ = 40; // the ninth power of the scores: sums over all others, which do not all meet
  EXPECT_THAT(withRivals(asTheyAre()), IsEmpty());
  matched_ = 20;
  job_.links.erase(std::remove_if(job_.links.begin(),
                                  job_.links.end(),
                                  [](const PairLink& link) { return link.source == 1 && link.target == 4; }),
                   job_.links.end());
  for (PairLink& link : job_.links)
    if (link.source < 3 && link.target >= 3 && link.target < 6)
      link.hypotheses.front().probability = 0.15; // still a rival
  EXPECT_THAT(withRivals(asTheyAre()), ElementsAre(0, 1, 2, 3, 4, 5));
  most_by_links_ = std::log(100);
  EXPECT_THAT(withRivals(asTheyAre()), ElementsAre(0, 5)); // of which one more link says another place
}

TEST_F(RoomsAlike, aRivalInAnotherPartMustBeBetter)
{
  // Scan 6 was laid to the first room, and would fit the second one as well: no better, so it stays.
  EXPECT_THAT(withRivals(asTheyAre({0, 0, 0, 1, 1, 1, 0})), IsEmpty());
  // A scan of the second room was laid to the first one, which has nothing to say for it.
  against_ = 0;
  Assembly assembly = asTheyAre({0, 0, 0, 0, 1, 1, 2});
  assembly.poses[3] = Eigen::Translation3d(-kApart, 0, 0) * assembly.poses[3];
  EXPECT_THAT(withRivals(assembly), ElementsAre(3));
}

TEST_F(RoomsAlike, whoIsDisplacedIsAskedAsWell)
{
  // Scans 1 and 4 stand at the same place of their rooms, and were exchanged. Each alone would displace the other.
  job_.truth[4] = Eigen::Translation3d(kApart, 0, 0) * job_.truth[1];
  std::vector<PairLink> others;
  for (const PairLink& link : job_.links)
    if (link.source != 4 && link.target != 4)
      others.push_back(link);
  job_.links = others;
  for (const int i : {3, 5})
    job_.addTrue(std::min(i, 4), std::max(i, 4), 0.9);
  for (const int i : {0, 2})
    job_.addFalse(i, 4, {kApart, 0, 0}, 0.9);
  unknown_ = {1, 3}; // a rival of 1 and 3: nothing is known of it between these two
  against_ = 0.5;    // what is said of 1 alone is not enough, 4.5 of 4.6; of both it is
  Assembly assembly = asTheyAre();
  EXPECT_THAT(withRivals(assembly), IsEmpty());
  against_ = 5;
  std::swap(assembly.poses[1], assembly.poses[4]);
  EXPECT_THAT(withRivals(assembly), ElementsAre(1, 4));
}

TEST_F(RoomsAlike, aGroupThatSpeaksForEachOfItsScansIsAskedAsOne)
{
  // The second room was laid onto the first one. Furniture says nothing of that, and of each scan the two others of its
  // room say more than scan 6, which alone sees where the room belongs.
  against_ = 0;
  for_ = 6;
  Assembly assembly = asTheyAre();
  for (const std::size_t i : {3, 4, 5})
    assembly.poses[i] = Eigen::Translation3d(-kApart, 0, 0) * assembly.poses[i];
  graph_ = weighHypotheses(job_.links, job_.places, {}, options_);
  chooseLinks(assembly, job_.links, graph_, job_.places, options_.choice);
  EXPECT_THAT(withRivals(assembly), ElementsAre(6)); // which the other room might have taken along
  EXPECT_THAT(group_with_rival_, ElementsAre(3, 4, 5));

  // As they are, with furniture against the other place, no group has a rival; without, each has.
  assembly = asTheyAre();
  chooseLinks(assembly, job_.links, graph_, job_.places, options_.choice);
  for_ = 1;
  against_ = 3;
  withRivals(assembly);
  EXPECT_THAT(groups_, SizeIs(::testing::Ge(2U)));
  EXPECT_THAT(group_with_rival_, IsEmpty());
  for_ = against_ = 0;
  withRivals(assembly);
  EXPECT_EQ(group_with_rival_, groups_.front());
}

TEST_F(RoomsAlike, aPartOfOneScanHasNoGroups)
{
  const Assembly assembly = asTheyAre({0, 1, 2, 3, 4, 5, 6});
  SamePlaceOdds odds([](const PlacedPair&) { return 1.0; }, job_.places, options_);
  graph_ = weighHypotheses(job_.links, job_.places, {}, options_);
  EXPECT_THAT(groupsOf({4}, {assembly, job_.links, graph_, job_.places}, odds), IsEmpty());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_same_place
