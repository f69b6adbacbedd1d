// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/posterior.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/options.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace pcl_ssfr::test_posterior {
namespace {

constexpr double kContradictionWeight = 14;
constexpr double kPatches = 500; // weighted number of them, half of which face their sensor
constexpr double kSurface = 200; // [m^2]
constexpr double kClutter = 400; // points
constexpr double kBeyond = 0.5;  // share of the matches that is in none of three planes
const PosteriorModel kSeeing = makePosteriorModel(JudgementConfig(), true);
const PosteriorModel kBlind = makePosteriorModel(JudgementConfig(), false);

/// Evidence of a pose: shares of the surface that matches, that contradicts, and that matches in the third direction.
ScoredPose
poseOf(double matched, double contradicted = 0, double third = 0.05, double patches = kPatches)
{
  SurfaceEvidence e;
  e.total = kSurface;
  e.matched = matched * kSurface;
  e.contradicted = contradicted * kSurface;
  e.unmatched = 0.08 * kSurface;
  e.patches = {patches, matched * patches, contradicted * patches};
  e.facing = {patches / 2, matched * patches / 2, contradicted * patches / 2};
  e.facing.beyond = kBeyond * e.facing.matched;
  const double least = std::min(third, matched / 3), others = (matched - least) / 2;
  e.matched_normals = Eigen::Vector3d(others * kSurface, others * kSurface, least * kSurface).asDiagonal();
  e.clutter = matched * kClutter;
  ScoredPose pose;
  rate(pose, e, kContradictionWeight);
  return pose;
}

/// A pose as it looks when it is right: most surface meets, nothing hangs in free space.
ScoredPose
goodPose()
{
  return poseOf(0.6, 0.002, 0.15);
}

/// A pose as it looks when the scans have nothing to do with each other.
ScoredPose
badPose()
{
  return poseOf(0.12, 0.005, 0.01);
}

/// A pose with \p share of the matches of another one, and of its score.
ScoredPose
rivalOf(ScoredPose pose, double share)
{
  pose.score *= share;
  pose.facing_score *= share;
  pose.evidence.patches.matched *= share;
  for (double* part : {&pose.evidence.facing.beyond, &pose.held.second, &pose.held.third, &pose.evidence.clutter})
    *part *= share;
  return pose;
}

double
sumOf(const Posterior& posterior)
{
  return std::accumulate(posterior.poses.begin(), posterior.poses.end(), posterior.none);
}

/// Any pose: with shares that are often none or all, and scores down to far below zero.
ScoredPose
randomPose(testing::Random& random)
{
  const auto share = [&] { return random.index(4) == 0 ? random.index(2) : random.uniform(0, 1); };
  ScoredPose pose = poseOf(share(), random.index(2) * share() * random.uniform(0, 0.1), share() / 3);
  pose.evidence.patches.total = random.uniform(0, 1000);
  pose.evidence.facing.total = share() * pose.evidence.patches.total;
  pose.evidence.facing.matched = share() * pose.evidence.facing.total;
  pose.evidence.facing.beyond = share() * pose.evidence.facing.matched;
  pose.facing_score = share() - random.uniform(0, 20) * random.index(2);
  pose.log_prior = random.index(3) == 0 ? random.uniform(-50, 5) : 0;
  return pose;
}

std::vector<ScoredPose>
randomPoses(testing::Random& random)
{
  std::vector<ScoredPose> poses;
  for (int k = random.index(8); k >= 0; --k)
    poses.push_back(randomPose(random));
  return poses;
}

TEST(Posterior, NoPoses)
{
  const Posterior posterior = computePosterior({}, kSeeing);
  EXPECT_TRUE(posterior.poses.empty());
  EXPECT_EQ(posterior.none, 1);
  EXPECT_EQ(posterior.best(), 0);
}

TEST(Posterior, ByHand)
{
  const PosteriorModel config = {{-0.5, 0.75, 1, 1, 2, 3}, FreeSpaceConfig{1.5, 3}, 2, 0.125};
  ScoredPose first, second;
  SurfaceEvidence e;
  e.total = 20;
  e.matched = 12;
  e.matched_normals = Eigen::Vector3d(4, 6, 2).asDiagonal(); // a tenth in the third direction
  e.clutter = 3;
  e.patches = {16, 12, 0};
  e.facing = {10, 8, 0.1, 0, 5};
  rate(first, e, kContradictionWeight);
  e.patches = {16, 8, 0};
  rate(second, e, kContradictionWeight);
  // 5 matches of the first one are beyond three planes, in units of 2 m^2 2 and 1 face the second and the third
  // direction, and 3 points lie at the depth that was seen; 9, 3, 4 and 1 of the other one's, and four times as many
  // patches of it contradict as may do so by chance.
  second.log_prior = std::log(2);
  second.evidence.facing.beyond = 9;
  second.held = {6, 8};
  second.evidence.clutter = 1;
  second.evidence.patches.contradicted = 8;
  const double odds =
      (6.0 / 10) * std::pow(3.0 / 4, 2) * std::pow(2.0 / 5, 3) * std::pow(4.0 / 2, 1.5) * std::pow(17, 1.5) / 2;
  EXPECT_NEAR(logOdds(first, second, config), std::log(odds), 1e-12);
  EXPECT_NEAR(logOdds(second, first, config), -std::log(odds), 1e-12);
  const double log_odds_of_any = -0.5 + std::log(0.101) + 0.75 * std::log(6) + std::log(4) - std::log(1.1);
  const double any = 1 / (1 + std::exp(-log_odds_of_any));
  const Posterior posterior = computePosterior({first, second}, config);
  EXPECT_NEAR(posterior.none, 1 - any, 1e-12);
  ASSERT_EQ(posterior.poses.size(), 2U);
  EXPECT_NEAR(posterior.poses[0], any * odds / (1 + odds), 1e-12);
  EXPECT_NEAR(posterior.poses[1], any / (1 + odds), 1e-12);
  EXPECT_EQ(posterior.best(), posterior.poses[0]);
}

TEST(Posterior, SumsToOneForAnyEvidence)
{
  testing::Random random(1);
  int sure = 0, unsure = 0;
  constexpr int kTrials = 20000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::vector<ScoredPose> poses = randomPoses(random);
    const Posterior posterior = computePosterior(poses, trial % 2 ? kSeeing : kBlind);
    ASSERT_EQ(posterior.poses.size(), poses.size());
    ASSERT_NEAR(sumOf(posterior), 1, 1e-12);
    for (const double p : posterior.poses)
      ASSERT_TRUE(p >= 0 && p <= 1);
    ASSERT_TRUE(posterior.none >= 0 && posterior.none <= 1);
    sure += posterior.none < 0.1;
    unsure += posterior.none > 0.9;
  }
  EXPECT_GT(sure, kTrials / 100); // the inputs cover both ends
  EXPECT_GT(unsure, kTrials / 100);
}

TEST(Posterior, SurvivesPriorsThatExclude)
{
  const double infinity = std::numeric_limits<double>::infinity();
  ScoredPose excluded = goodPose(), improbable = goodPose();
  excluded.log_prior = -infinity;
  improbable.log_prior = -1e6;
  const Posterior posterior = computePosterior({excluded, improbable, badPose()}, kSeeing);
  EXPECT_EQ(posterior.poses[0], 0);
  EXPECT_EQ(posterior.poses[1], 0);
  EXPECT_GT(posterior.poses[2], 0);
  EXPECT_NEAR(sumOf(posterior), 1, 1e-12);
  // All of them improbable: how well they explain the scans is all the same for another question.
  EXPECT_EQ(computePosterior({improbable}, kSeeing).none, computePosterior({goodPose()}, kSeeing).none);
}

TEST(Posterior, DoesNotDependOnTheOrder)
{
  testing::Random random(2);
  for (int trial = 0; trial < 500; ++trial) {
    const std::vector<ScoredPose> poses = randomPoses(random);
    const Posterior posterior = computePosterior(poses, kSeeing);
    std::vector<std::size_t> order(poses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(random.index(static_cast<int>(i)))]);
    std::vector<ScoredPose> shuffled;
    for (const std::size_t i : order)
      shuffled.push_back(poses[i]);
    const Posterior again = computePosterior(shuffled, kSeeing);
    ASSERT_NEAR(again.none, posterior.none, 1e-15);
    for (std::size_t i = 0; i < order.size(); ++i)
      ASSERT_NEAR(again.poses[i], posterior.poses[order[i]], 1e-12);
  }
}

TEST(Posterior, AnEqualPoseTakesHalfAndLeavesNone)
{
  for (const PosteriorModel& config : {kSeeing, kBlind})
    for (const ScoredPose& pose : {goodPose(), badPose()}) {
      const Posterior alone = computePosterior({pose}, config);
      ASSERT_GT(alone.best(), 0.001);
      const Posterior two = computePosterior({pose, pose}, config);
      EXPECT_EQ(two.none, alone.none);
      EXPECT_NEAR(two.poses[0], alone.best() / 2, 1e-15);
      EXPECT_EQ(two.poses[1], two.poses[0]);
      const Posterior four = computePosterior({pose, pose, pose, pose}, config);
      EXPECT_EQ(four.none, alone.none);
      EXPECT_NEAR(four.best(), alone.best() / 4, 1e-15);
    }
}

TEST(Posterior, LogPriorMultipliesTheOdds)
{
  const Posterior even = computePosterior({goodPose(), rivalOf(goodPose(), 0.95)}, kSeeing);
  for (const double k : {0.05, 0.5, 2.0, 31.0}) {
    ScoredPose favoured = goodPose();
    favoured.log_prior = std::log(k);
    const Posterior posterior = computePosterior({favoured, rivalOf(goodPose(), 0.95)}, kSeeing);
    EXPECT_NEAR(posterior.poses[0] / posterior.poses[1],
                k * even.poses[0] / even.poses[1],
                1e-9 * k * even.poses[0] / even.poses[1]);
    // A constant of the pair is of no effect.
    ScoredPose rival = rivalOf(goodPose(), 0.95);
    rival.log_prior = favoured.log_prior;
    EXPECT_NEAR(computePosterior({favoured, rival}, kSeeing).best(), even.best(), 1e-12);
  }
}

TEST(Posterior, GroundOnGroundIsNoLeadOverWhatIsHeld)
{
  // More surface in two directions against what is held in all three.
  const ScoredPose ground = poseOf(0.3, 0, 0.0005), held = poseOf(0.25, 0, 0.08);
  ASSERT_GT(ground.score, held.score);
  for (const PosteriorModel& model : {kSeeing, kBlind}) {
    const Posterior posterior = computePosterior({ground, held}, model);
    EXPECT_GT(posterior.poses[1], 3 * posterior.poses[0]);
    EXPECT_GT(logOdds(held, ground, model), std::log(3));
  }
}

TEST(Posterior, NothingForTheBestPoseIsNoneOfThem)
{
  for (const PosteriorModel& config : {kSeeing, kBlind}) {
    EXPECT_EQ(computePosterior({ScoredPose()}, config).none, 1);
    EXPECT_EQ(computePosterior({ScoredPose()}, config).best(), 0);
    ScoredPose nothing = goodPose();
    for (const double matched : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
      nothing.evidence.matched = matched;
      EXPECT_EQ(computePosterior({nothing}, config).none, 1);
    }
  }
  // More contradictions than the matches are worth.
  EXPECT_GT(computePosterior({poseOf(0.28, 0.03), poseOf(0.1, 0.05)}, kSeeing).none, 1 - Options().min_confidence);
}

TEST(Posterior, SeparatesClearCases)
{
  EXPECT_GT(computePosterior({goodPose(), rivalOf(goodPose(), 0.5)}, kSeeing).best(), 0.9);
  EXPECT_GT(computePosterior({goodPose(), rivalOf(goodPose(), 0.5)}, kBlind).best(), 0.6); // nothing could contradict
  for (const PosteriorModel& config : {kSeeing, kBlind}) {
    EXPECT_LT(computePosterior({badPose(), rivalOf(badPose(), 0.95)}, config).best(), Options().min_confidence);
    EXPECT_GT(computePosterior({badPose()}, config).none, 1 - Options().min_confidence);
  }
}

TEST(Posterior, GrowsWithTheOverlapAndWithTheThirdDirection)
{
  for (const PosteriorModel& config : {kSeeing, kBlind})
    for (const bool has_rival : {false, true}) {
      const auto best = [&](double overlap, double third) {
        const ScoredPose pose = poseOf(overlap, 0, third), rival = poseOf(0.01);
        return computePosterior(has_rival ? std::vector<ScoredPose>{pose, rival} : std::vector<ScoredPose>{pose},
                                config)
            .best();
      };
      double before = 0;
      for (double overlap = 0.02; overlap < 0.9; overlap += 0.02) {
        EXPECT_GT(best(overlap, 0.05), before) << overlap;
        before = best(overlap, 0.05);
      }
      before = 0;
      for (double third = 0; third < 0.1; third += 0.01) {
        EXPECT_GT(best(0.3, third), before) << third;
        before = best(0.3, third);
      }
    }
}

TEST(Posterior, GrowsWithTheEvidenceAmongPoses)
{
  // Of the same matches: only their shares of what is sure change.
  for (const PosteriorModel& config : {kSeeing, kBlind}) {
    double before = 1;
    for (int percent = 5; percent <= 100; percent += 5) {
      const Posterior posterior = computePosterior({goodPose(), rivalOf(goodPose(), percent / 100.0)}, config);
      EXPECT_LT(posterior.best(), before) << percent;
      EXPECT_EQ(posterior.none, computePosterior({goodPose()}, config).none);
      before = posterior.best();
    }
    EXPECT_NEAR(before, computePosterior({goodPose()}, config).best() / 2, 1e-9);
    // A rival that contradicts itself away is next to none.
    EXPECT_NEAR(computePosterior({goodPose(), poseOf(0.3, 0.1, 0)}, config).best(),
                computePosterior({goodPose()}, config).best(),
                1e-3);
  }
}

TEST(Posterior, OnlyWhatMatchesBeyondThreePlanesSaysThatAnyPoseIsRight)
{
  // A corner fits any corner, however many patches it has.
  for (const PosteriorModel& config : {kSeeing, kBlind}) {
    ScoredPose corner = goodPose(), larger = corner, more = corner;
    corner.evidence.facing.beyond = larger.evidence.facing.beyond = 1;
    larger.evidence.facing.matched *= 2;
    EXPECT_EQ(computePosterior({larger}, config).none, computePosterior({corner}, config).none);
    EXPECT_GT(computePosterior({corner}, config).none, 2 * computePosterior({more}, config).none);
  }
}

TEST(Posterior, FallsWithContradictions)
{
  double before = 1;
  for (double contradicted = 0; contradicted < 0.6 / kContradictionWeight; contradicted += 0.004) {
    const Posterior posterior = computePosterior({poseOf(0.6, contradicted), poseOf(0.02)}, kSeeing);
    EXPECT_LT(posterior.best(), before) << contradicted;
    before = posterior.best();
  }
  // Nearly as much as the matches are worth.
  EXPECT_LT(computePosterior({poseOf(0.35, 0.024)}, kSeeing).best(), Options().min_confidence);
  // Two offices alike: most surface meets, but the desks stand elsewhere. As much evidence without contradictions is
  // worth more than with them.
  const ScoredPose alike = poseOf(0.7, 0.028), same_score = poseOf(alike.score);
  ASSERT_NEAR(alike.score, same_score.score, 1e-12);
  EXPECT_GT(computePosterior({alike}, kSeeing).none, computePosterior({same_score}, kSeeing).none);
}

TEST(Posterior, SettlesMoreWithMoreSurface)
{
  // The same shares of more surface: chance accounts for less of the lead.
  for (const PosteriorModel& config : {kSeeing, kBlind}) {
    double before = 1;
    for (const double times : {0.01, 0.1, 1.0, 10.0}) {
      ScoredPose first = poseOf(0.5, 0, 0.1), second = poseOf(0.4, 0, 0.08);
      for (ScoredPose* pose : {&first, &second})
        for (double* of :
             {&pose->evidence.facing.beyond, &pose->held.second, &pose->held.third, &pose->evidence.clutter})
          *of *= times;
      const Posterior posterior = computePosterior({first, second}, config);
      const double odds = posterior.poses[0] / posterior.poses[1];
      EXPECT_GT(odds, before) << times;
      before = odds;
    }
  }
}

TEST(Posterior, WithoutFreeSpaceARivalTakesMore)
{
  const auto share = [](const PosteriorModel& config) {
    const Posterior posterior = computePosterior({poseOf(0.6), poseOf(0.55)}, config);
    return posterior.best() / (1 - posterior.none);
  };
  EXPECT_LT(share(kBlind), share(kSeeing));
}

TEST(Posterior, ThreeThatComeNearLeaveLessThanTwo)
{
  const ScoredPose best = poseOf(0.6), near = poseOf(0.58);
  EXPECT_LT(computePosterior({best, near, near}, kSeeing).best(), computePosterior({best, near}, kSeeing).best());
  const Posterior two = computePosterior({best, near}, kSeeing), three = computePosterior({best, near, near}, kSeeing);
  EXPECT_NEAR(three.poses[1] / three.poses[0], two.poses[1] / two.poses[0], 1e-12);
}

TEST(SortByProbability, MostProbableFirstAndEqualsInTheirOrder)
{
  testing::Random random(2);
  std::vector<ScoredPose> poses(300);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].evidence.facing.beyond = 5 * random.index(20);
    poses[i].evidence.matched = 1;
    poses[i].evidence.total = 2;
    poses[i].facing_score = static_cast<double>(i); // where it stood
  }
  sortByProbability(poses, kSeeing);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    ASSERT_GE(poses[i - 1].evidence.facing.beyond, poses[i].evidence.facing.beyond);
    if (poses[i - 1].evidence.facing.beyond == poses[i].evidence.facing.beyond) {
      ASSERT_LT(poses[i - 1].facing_score, poses[i].facing_score);
    }
  }
  std::vector<ScoredPose> none;
  sortByScore(none);
  sortByProbability(none, kSeeing);
  EXPECT_TRUE(none.empty());
}

TEST(SortByProbability, FollowsTheProbabilities)
{
  testing::Random random(3);
  int not_by_score = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<ScoredPose> poses = randomPoses(random);
    sortByProbability(poses, kSeeing);
    const Posterior posterior = computePosterior(poses, kSeeing);
    for (std::size_t i = 1; i < poses.size(); ++i) {
      ASSERT_GE(posterior.poses[i - 1], posterior.poses[i]);
      not_by_score += poses[i - 1].score < poses[i].score;
    }
  }
  EXPECT_GT(not_by_score, 0); // the prior counts, too
}

TEST(Posterior, OnlyRatiosOfTheEvidenceCount)
{
  // A hundred times the surface, and all patches of a scan that is as dense: the same odds but for what may be chance.
  const auto odds = [](double surface, double patches) {
    ScoredPose first = poseOf(0.5, 0.02, 0.1), second = poseOf(0.4, 0.01, 0.05);
    for (ScoredPose* pose : {&first, &second}) {
      for (double* of : {&pose->evidence.facing.beyond, &pose->held.second, &pose->held.third, &pose->evidence.clutter})
        *of *= surface;
      pose->evidence.patches.contradicted *= patches;
    }
    return logOdds(first, second, kSeeing);
  };
  EXPECT_NEAR(odds(1e4, 1e4), odds(1e6, 1e6), 0.01);
  EXPECT_NEAR(odds(1, 1), odds(1e4, 1e4), 0.5);
}

TEST(Posterior, WhatStandsWhereItWasSeenCounts)
{
  ScoredPose crown = poseOf(0.2, 0.002), other = crown;
  crown.evidence.clutter *= 2;
  EXPECT_GT(logOdds(crown, other, kSeeing), 1);
  // Contradictions count by how many times as many there are: one car that has moved is no half turn of a car park.
  ScoredPose none = poseOf(0.2), few = poseOf(0.2, 0.04), many = poseOf(0.2, 0.16);
  EXPECT_GT(logOdds(none, few, kSeeing), logOdds(few, many, kSeeing));
  EXPECT_GT(logOdds(few, many, kSeeing), 2);
}

TEST(Posterior, WithoutFreeSpaceNothingContradicts)
{
  // One of two viewpoints is known: some contradictions are counted, and held against no pose.
  ScoredPose contradicted = goodPose();
  contradicted.evidence.facing.contradicted = contradicted.evidence.facing.matched / 5;
  contradicted.evidence.patches.contradicted = contradicted.evidence.patches.matched / 5;
  const auto of = [](const ScoredPose& pose, const PosteriorModel& model) {
    return computePosterior({pose, badPose()}, model).best();
  };
  EXPECT_EQ(of(contradicted, kBlind), of(goodPose(), kBlind));
  EXPECT_GT(1 - of(contradicted, kSeeing), 5 * (1 - of(goodPose(), kSeeing)));
  EXPECT_LT(of(contradicted, kSeeing), Options().min_confidence);
}

TEST(SortByScore, NeitherThePriorNorTheDirectionsCount)
{
  std::vector<ScoredPose> poses = {poseOf(0.5, 0, 0.3), poseOf(0.6, 0, 0), poseOf(0.5, 0, 0.1), poseOf(0.1, 0, 0.1)};
  poses[3].log_prior = 1000;
  sortByScore(poses);
  EXPECT_NEAR(poses[0].score, 0.6, 1e-12);
  EXPECT_GT(poses[1].held.third, poses[2].held.third) << "equal ones in their order";
  EXPECT_EQ(poses[3].log_prior, 1000);
}

} // namespace
} // namespace pcl_ssfr::test_posterior
