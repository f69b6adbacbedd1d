// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// What links say together: beliefs by loops, parts, bridges; the pose graph and the joint adjustment of made-up jobs.

#include "judgement/scored_pose.h"
#include "multiway/assembly.h"
#include "multiway/joint_adjustment.h"
#include "multiway/parts.h"
#include "multiway/pose_graph.h"
#include "multiway/same_place.h"
#include "refinement/plane_equations.h"

#include <made_up_maps.h>

#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include <cmath>
#include <limits>
#include <set>

namespace pcl_ssfr::test_multiway_choice {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MadeUpJob;

constexpr double kMillimetre = 1e-3;

/// Nothing is seen of it: surfaces say neither yes nor no.
double
nothingSeen(const PlacedPair& /*pair*/)
{
  return 0;
}

MultiwayOptions
oneThread()
{
  MultiwayOptions options;
  options.threads = 1;
  return options;
}

Assembly
assembled(const MadeUpJob& job,
          const Decisions& decisions = {},
          const PairOddsFunction& seen = nothingSeen,
          const JoinTest& join_test = nullptr,
          double most_by_links = std::log(100))
{
  const MultiwayOptions options = oneThread();
  const HypothesisGraph graph = weighHypotheses(job.links, job.places, decisions, options);
  SamePlaceOdds odds(seen, job.places, options);
  const JoinRule rule = {most_by_links, std::log(0.95 / 0.05), true};
  return assemble(job.links, graph, job.places, odds, rule, decisions, job.names, options, join_test);
}

/// Largest error of the scans of the part of scan 0 relative to it [m].
double
largestError(const MadeUpJob& job, const std::vector<Eigen::Isometry3d>& poses, const std::vector<int>& part)
{
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (part[i] == part[0])
      largest =
          std::max(largest,
                   translationBetween(
                       poses[0].inverse() * poses[i], job.relative(static_cast<int>(i), 0), Eigen::Vector3d::Zero()));
  return largest;
}

MadeUpJob
fullJob(int scans)
{
  MadeUpJob job(scans);
  for (int i = 0; i < scans; ++i)
    for (int j = i + 1; j < scans; ++j)
      job.addTrue(i, j);
  return job;
}

TEST(HypothesisGraph, loopsRaiseWhatClosesAndLowerWhatDoesNot)
{
  MadeUpJob job(5);
  for (int i = 0; i < 5; ++i)
    for (int j = i + 1; j < 5; ++j)
      if (i == 0 && j == 4)
        job.addFalse(i, j, {5, 0, 0}, 0.9);
      else
        job.addTrue(i, j, 0.6);
  const HypothesisGraph graph = weighHypotheses(job.links, job.places, {}, oneThread());
  for (const WeighedHypothesis& h : graph.hypotheses) {
    const bool is_false = job.links[h.link].source == 0 && job.links[h.link].target == 4;
    if (is_false)
      EXPECT_LT(h.belief, 0.7 * h.prior);
    else
      EXPECT_GT(h.belief, h.prior) << job.links[h.link].source << " " << job.links[h.link].target;
  }
}

TEST(HypothesisGraph, aLinkIsAsSureAmongManyPairsThatShareNothing)
{
  MadeUpJob job(12);
  for (int i = 0; i < 12; ++i)
    for (int j = i + 1; j < 12; ++j)
      job.addTrue(i, j, i == 0 && j == 1 ? 0.8 : 0.02);
  const HypothesisGraph graph = weighHypotheses(job.links, job.places, {}, oneThread());
  EXPECT_EQ(graph.hypotheses.front().prior, 0.8);
  EXPECT_NEAR(graph.hypotheses.front().belief, 0.8, 0.05);
}

TEST(HypothesisGraph, noLinksAndNoHypothesesAreFine)
{
  EXPECT_TRUE(weighHypotheses({}, {}, {}, oneThread()).hypotheses.empty());
  MadeUpJob job(2);
  job.addTrue(0, 1).hypotheses.clear();
  EXPECT_TRUE(weighHypotheses(job.links, job.places, {}, oneThread()).hypotheses.empty());
}

TEST(HypothesisGraph, sameBitsForAnyNumberOfThreads)
{
  const MadeUpJob job = fullJob(9);
  MultiwayOptions four = oneThread();
  four.threads = 4;
  const HypothesisGraph a = weighHypotheses(job.links, job.places, {}, oneThread());
  const HypothesisGraph b = weighHypotheses(job.links, job.places, {}, four);
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (std::size_t h = 0; h < a.hypotheses.size(); ++h)
    EXPECT_EQ(a.hypotheses[h].belief, b.hypotheses[h].belief);
}

TEST(Decisions, tieScansByAcceptedLinksAndByPoses)
{
  Decisions decisions;
  EXPECT_THAT(tiedScans(decisions, {}, 4), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(tiedScans(decisions, {2}, 4), ElementsAre(0, 1, 2, 3)); // tied to nothing
  decisions.accepted = {{0, 4}, {1, 2}, {2, 4}};
  std::vector<int> tied = tiedScans(decisions, {}, 7);
  EXPECT_EQ(std::set<int>({tied[0], tied[1], tied[2], tied[4]}).size(), 1U);
  EXPECT_EQ(std::set<int>(tied.begin(), tied.end()).size(), 4U); // 3, 5 and 6 by themselves
  tied = tiedScans(decisions, {1, 5, 6}, 7);
  EXPECT_EQ(std::set<int>(tied.begin(), tied.end()).size(), 2U);
  EXPECT_NE(tied[3], tied[0]);
  tied = tiedScans(decisions, {}, 7);
  EXPECT_TRUE(areTiedToOthers({1, 3}, {0, 1, 2, 3, 5}, tied));
  EXPECT_FALSE(areTiedToOthers({1, 2}, {1, 2, 3, 5}, tied)); // to each other, and to scans of other parts
  EXPECT_FALSE(areTiedToOthers({3, 5}, {0, 1, 3, 5}, tied));
}

TEST(Assembly, falseLinksAreLeftOut)
{
  MadeUpJob job = fullJob(7);
  job.links.erase(job.links.begin() + 2); // 0-3
  job.addFalse(0, 3, {4, 0, 0}, 0.99);
  const Assembly assembly = assembled(job);
  EXPECT_THAT(assembly.part, Each(assembly.part[0]));
  EXPECT_LT(largestError(job, assembly.poses, assembly.part), 5 * kMillimetre);
  for (std::size_t k = 0; k < job.links.size(); ++k) {
    const bool is_false = job.links[k].source == 0 && job.links[k].target == 3;
    EXPECT_EQ(assembly.used[k], is_false ? -1 : 0);
  }
}

TEST(Assembly, theSecondPoseOfAPairIsTakenWhereTheLoopsAskForIt)
{
  MadeUpJob job = fullJob(4);
  PairLink& link = job.links.front(); // 0-1
  PairHypothesis wrong = link.hypotheses.front();
  wrong.T_target_source = wrong.T_target_source * Eigen::Translation3d(3, 0, 0);
  wrong.probability = 0.6;
  link.hypotheses.front().probability = 0.35;
  link.hypotheses.insert(link.hypotheses.begin(), wrong);
  const Assembly assembly = assembled(job);
  EXPECT_EQ(assembly.used.front(), 1);
  EXPECT_LT(largestError(job, assembly.poses, assembly.part), 5 * kMillimetre);
}

TEST(Assembly, aSingleDoubtfulLinkJoinsNothing)
{
  // Two rooms of three scans each, and a door.
  MadeUpJob job(6);
  for (const int room : {0, 3})
    for (int i = room; i < room + 3; ++i)
      for (int j = i + 1; j < room + 3; ++j)
        job.addTrue(i, j);
  MadeUpJob sure = job;
  job.addTrue(2, 3, 0.75);
  sure.addTrue(2, 3, 0.999);
  const Assembly apart = assembled(job);
  EXPECT_EQ(apart.part[0], apart.part[2]);
  EXPECT_EQ(apart.part[3], apart.part[5]);
  EXPECT_NE(apart.part[0], apart.part[3]);
  const Assembly together = assembled(sure);
  EXPECT_EQ(together.part[0], together.part[3]);
  const std::vector<char> bridges = findBridges(together, sure.links);
  for (std::size_t k = 0; k < sure.links.size(); ++k)
    EXPECT_EQ(bridges[k] != 0, sure.links[k].source == 2 && sure.links[k].target == 3);
}

TEST(Assembly, whatAThirdScanSeesForbidsAJoin)
{
  const MadeUpJob job = fullJob(4);
  const Assembly assembly =
      assembled(job, {}, [](const PlacedPair& pair) { return pair.source == 1 && pair.target == 3 ? -10.0 : 0.0; });
  EXPECT_EQ(assembly.part[0], assembly.part[1]);
  EXPECT_NE(assembly.part[1], assembly.part[3]);
  const auto refused = std::find_if(job.links.begin(), job.links.end(), [&](const PairLink& link) {
    return assembly.part[static_cast<std::size_t>(link.source)] != assembly.part[static_cast<std::size_t>(link.target)];
  });
  ASSERT_NE(refused, job.links.end());
  EXPECT_THAT(assembly.refusal[static_cast<std::size_t>(refused - job.links.begin())], HasSubstr("not the same"));
}

TEST(Assembly, linksThatAgreeAddUpAsFarAsLinksAreTrusted)
{
  // Two rooms of two scans each. Neither of two links between them is sure enough by itself; together they are.
  MadeUpJob job(4);
  job.addTrue(0, 1, 0.999);
  job.addTrue(2, 3, 0.999);
  job.addTrue(1, 2, 0.9);
  const Assembly one = assembled(job);
  EXPECT_EQ(one.part[2], one.part[3]);
  EXPECT_NE(one.part[0], one.part[2]);
  EXPECT_THAT(one.refusal[1], HasSubstr("not sure enough"));
  job.addTrue(0, 3, 0.9);
  EXPECT_THAT(assembled(job).part, Each(assembled(job).part[0]));
  // Where half of the sure links are false they say nothing; what is seen says it.
  EXPECT_EQ(mostLogOddsByLinks(0.5, ChoiceConfig()), 0);
  EXPECT_EQ(mostLogOddsByLinks(0.9, ChoiceConfig()), 0);
  EXPECT_NEAR(mostLogOddsByLinks(0.1, ChoiceConfig()), std::log(9), 1e-9);
  EXPECT_NEAR(mostLogOddsByLinks(0, ChoiceConfig()), std::log(ChoiceConfig().clear_odds), 1e-9);
  const Assembly apart = assembled(job, {}, nothingSeen, nullptr, 0);
  EXPECT_EQ(std::set<int>(apart.part.begin(), apart.part.end()).size(), 4U);
  const Assembly seen = assembled(
      job, {}, [](const PlacedPair&) { return 4.0; }, nullptr, 0);
  EXPECT_THAT(seen.part, Each(seen.part[0]));
}

TEST(Assembly, aJoinThatTheTestRefusesIsNotMadeByAnyLink)
{
  const MadeUpJob job = fullJob(4);
  const JoinTest not_with_third = [&](const std::vector<PlacedPair>& pairs) {
    const bool is_out = std::any_of(pairs.begin(), pairs.end(), [&](const PlacedPair& p) {
      const Eigen::Vector3d expected = job.relative(p.source, p.target).translation();
      EXPECT_LT((p.T_target_source.translation() - expected).norm(), 0.05);
      return p.source == 3 || p.target == 3;
    });
    return is_out ? "they look alike" : "";
  };
  const Assembly assembly = assembled(job, {}, nothingSeen, not_with_third);
  EXPECT_EQ(assembly.part[0], assembly.part[2]);
  EXPECT_NE(assembly.part[0], assembly.part[3]);
  EXPECT_THAT(assembly.refusal[2], HasSubstr("look alike")); // 0-3
}

TEST(Assembly, aPersonsWordCounts)
{
  MadeUpJob job(4);
  job.addTrue(0, 1);
  job.addTrue(2, 3);
  job.addTrue(1, 2, 0.1);
  Decisions decisions;
  EXPECT_NE(assembled(job, decisions).part[1], assembled(job, decisions).part[2]);
  decisions.accepted.insert({1, 2});
  EXPECT_EQ(assembled(job, decisions).part[1], assembled(job, decisions).part[2]);
  decisions.rejected.insert({2, 3});
  EXPECT_NE(assembled(job, decisions).part[2], assembled(job, decisions).part[3]);
}

TEST(Assembly, acceptedLinksThatDoNotAgreeAreNamed)
{
  MadeUpJob job = fullJob(3);
  job.links.erase(job.links.begin() + 1); // 0-2
  job.addFalse(0, 2, {3, 0, 0});
  Decisions decisions;
  decisions.accepted = {{0, 1}, {1, 2}, {0, 2}};
  try {
    assembled(job, decisions);
    FAIL() << "a loop that does not close was accepted";
  }
  catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("does not close"));
    for (const char* name : {"s0", "s1", "s2"})
      EXPECT_THAT(error.what(), HasSubstr(name));
  }
}

TEST(PoseGraph, linksAreAveragedAndOutliersWeighLittle)
{
  MadeUpJob job(8, 5);
  std::vector<PoseGraphEdge> edges;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j) {
      const PairLink& link = job.addTrue(i, j, 0.9, 0.003);
      edges.push_back({i, j, link.hypotheses[0].T_target_source, 1e5 * Eigen::Matrix<double, 6, 6>::Identity()});
    }
  edges[3].T_target_source = edges[3].T_target_source * Eigen::Translation3d(1, 0, 0);
  std::vector<Eigen::Isometry3d> start = job.truth;
  for (std::size_t i = 1; i < start.size(); ++i)
    start[i] = start[i] * Eigen::Translation3d(0.2, -0.1, 0.1);
  const std::vector<Eigen::Isometry3d> solved = solvePoseGraph(start, edges);
  EXPECT_TRUE(solved[0].isApprox(job.truth[0]));
  EXPECT_LT(largestError(job, solved, std::vector<int>(8, 0)), 0.05);
  EXPECT_GT(largestError(job, start, std::vector<int>(8, 0)), 0.2);
}

/// The same job with the origins of all frames \p away from the sensors.
MadeUpJob
withFramesAway(MadeUpJob job, const Eigen::Vector3d& away)
{
  for (std::size_t i = 0; i < job.truth.size(); ++i) {
    job.truth[i] = job.truth[i] * Eigen::Translation3d(-away);
    job.places[i] = away;
  }
  const PlaneEquations::Matrix6 a = aboutOrigin(away);
  for (PairLink& link : job.links)
    for (PairHypothesis& h : link.hypotheses) {
      h.T_target_source = Eigen::Translation3d(away) * h.T_target_source * Eigen::Translation3d(-away);
      h.information = a * h.information * a.transpose();
    }
  return job;
}

TEST(PoseGraph, doesNotDependOnHowFarTheFramesAreFromTheSensors)
{
  MadeUpJob job(6, 8);
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j)
      job.addTrue(i, j, 0.95, 0.01);
  const auto sensorsOf = [](const MadeUpJob& made_up) {
    Assembly assembly;
    assembly.part.assign(made_up.truth.size(), 0);
    assembly.poses = made_up.truth;
    assembly.used.assign(made_up.links.size(), 0);
    adjustPart(assembly, 0, made_up.links, made_up.places);
    std::vector<Eigen::Vector3d> sensors;
    for (std::size_t i = 0; i < made_up.places.size(); ++i)
      sensors.emplace_back(assembly.poses[i] * made_up.places[i]);
    return sensors;
  };
  const std::vector<Eigen::Vector3d> near = sensorsOf(job);
  const std::vector<Eigen::Vector3d> far = sensorsOf(withFramesAway(job, {700, -500, 100}));
  for (std::size_t i = 0; i < near.size(); ++i)
    EXPECT_LT((near[i] - far[i]).norm(), 0.1 * kMillimetre) << i;
  EXPECT_GT((near[5] - job.truth[5].translation()).norm(), kMillimetre); // links that err move it
}

TEST(PoseGraph, withoutEdgesNothingMoves)
{
  const MadeUpJob job(3);
  const std::vector<Eigen::Isometry3d> solved = solvePoseGraph(job.truth, {});
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_TRUE(solved[i].matrix() == job.truth[i].matrix());
}

/// Pairs whose surfaces say the true pose, each motion with the same weight.
SurfaceEquations
towards(const Eigen::Isometry3d& T_true, const Eigen::Isometry3d& T)
{
  SurfaceEquations e;
  const Eigen::Isometry3d error = T_true * T.inverse();
  const Eigen::AngleAxisd rotation(error.linear());
  SurfaceEquations::Vector6 motion;
  motion << rotation.angle() * rotation.axis(), error.translation();
  e.hessian = e.curvature = e.full_curvature = 1000 * SurfaceEquations::Matrix6::Identity();
  e.gradient = -e.hessian * motion;
  e.weight = 1;
  e.squares = motion.squaredNorm();
  return e;
}

/// Six patches of the source, each of which no other pair sees, with a scatter of 4 in each motion.
PatchGradients
patchesOfTheirOwn(std::size_t /*pair*/, const Eigen::Isometry3d& /*T*/, bool of_source)
{
  PatchGradients patches{PatchGradients::Columns(6, 0), PatchGradients::Columns(6, 0)};
  if (of_source) {
    patches.gradients = 2 * SurfaceEquations::Matrix6::Identity();
    patches.offsets = kMillimetre * SurfaceEquations::Matrix6::Identity();
  }
  return patches;
}

TEST(JointAdjustment, findsThePosesThatAllSurfacesAgreeOn)
{
  const MadeUpJob job(5, 9);
  std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 4}, {0, 2}};
  const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
    return towards(job.relative(pairs[k].first, pairs[k].second), T);
  };
  std::vector<Eigen::Isometry3d> start = job.truth;
  for (std::size_t i = 1; i < start.size(); ++i)
    start[i] = start[i] * Eigen::Translation3d(0.05, -0.02, 0.03) * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX());
  const JointAdjustment one =
      adjustJointly(start, pairs, {0}, job.places, equations, patchesOfTheirOwn, AdjustmentConfig(), 1);
  const JointAdjustment four =
      adjustJointly(start, pairs, {0}, job.places, equations, patchesOfTheirOwn, AdjustmentConfig(), 4);
  EXPECT_LT(largestError(job, one.poses, std::vector<int>(5, 0)), 0.1 * kMillimetre);
  EXPECT_LT(one.rms, 0.01 * rmsOfPairs(start, pairs, job.places, equations, 1));
  EXPECT_TRUE(one.covariances[0].isZero(0));
  const JointAdjustment poses_only = adjustJointly(start, pairs, {0}, job.places, equations, {}, AdjustmentConfig(), 1);
  EXPECT_TRUE(poses_only.covariances.empty());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_TRUE(one.poses[i].matrix() == poses_only.poses[i].matrix());
    EXPECT_TRUE(one.poses[i].matrix() == four.poses[i].matrix());
    EXPECT_TRUE(one.covariances[i] == four.covariances[i]);
  }
}

TEST(JointAdjustment, stepsAreAsLongAsLittleCurvatureAsksFor)
{
  // Where matches at the far end of the robust function leave a fifth of the hessian, steps of the hessian get a fifth
  // of the way each: after 20 rounds a hundredth is left, 0.7 mm.
  const MadeUpJob job(5, 9);
  const std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
  const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
    SurfaceEquations e = towards(job.relative(pairs[k].first, pairs[k].second), T);
    e.full_curvature *= 0.2;
    e.gradient *= 0.2;
    return e;
  };
  std::vector<Eigen::Isometry3d> start = job.truth;
  for (std::size_t i = 1; i < start.size(); ++i)
    start[i] = start[i] * Eigen::Translation3d(0.05, -0.02, 0.03);
  const JointAdjustment adjusted =
      adjustJointly(start, pairs, {0}, job.places, equations, patchesOfTheirOwn, AdjustmentConfig(), 1);
  EXPECT_LT(largestError(job, adjusted.poses, std::vector<int>(5, 0)), 0.1 * kMillimetre);
}

TEST(JointAdjustment, doesNotDependOnHowFarTheFramesAreFromTheSensors)
{
  const MadeUpJob near(5, 9);
  const std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 2}};
  const auto adjusted = [&](const MadeUpJob& job) {
    const Eigen::Vector3d& away = job.places[0];
    const PlaneEquations::Matrix6 a = aboutOrigin(away);
    const auto betweenSensors = [&](const Eigen::Isometry3d& T) {
      return Eigen::Isometry3d(Eigen::Translation3d(-away) * T * Eigen::Translation3d(away));
    };
    const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
      SurfaceEquations e = towards(betweenSensors(job.relative(pairs[k].first, pairs[k].second)), betweenSensors(T));
      e.hessian = e.curvature = e.full_curvature = a * e.hessian * a.transpose();
      e.gradient = a * e.gradient;
      return e;
    };
    const PatchGradientsFunction patches = [&](std::size_t k, const Eigen::Isometry3d& T, bool of_source) {
      PatchGradients found = patchesOfTheirOwn(k, T, of_source);
      found.gradients = a * found.gradients;
      found.offsets = a * found.offsets;
      return found;
    };
    std::vector<Eigen::Isometry3d> start = job.truth;
    for (std::size_t i = 1; i < start.size(); ++i)
      start[i] = start[i] * Eigen::Translation3d(away) * Eigen::Translation3d(0.05, -0.02, 0.03) *
                 Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()) * Eigen::Translation3d(-away);
    return adjustJointly(start, pairs, {0}, job.places, equations, patches, AdjustmentConfig(), 1);
  };
  const MadeUpJob far = withFramesAway(near, {-600, 650, 90});
  const JointAdjustment here = adjusted(near), there = adjusted(far);
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_LT((here.poses[i].translation() - there.poses[i] * far.places[i]).norm(), 1e-6) << i;
    EXPECT_TRUE(here.poses[i].linear().isApprox(there.poses[i].linear(), 1e-7)) << i;
    EXPECT_TRUE(here.covariances[i].isApprox(there.covariances[i], 1e-4)) << i;
  }
}

TEST(JointAdjustment, covarianceGrowsAlongAChain)
{
  // Each pair has the variance scatter / curvature^2, and they add up: 4 / 1000^2 for each of three rotations.
  const MadeUpJob job(4);
  std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}, {2, 3}};
  const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
    return towards(job.relative(pairs[k].first, pairs[k].second), T);
  };
  AdjustmentConfig config;
  config.damping = 1e-9;
  const JointAdjustment adjusted =
      adjustJointly(job.truth, pairs, {0}, job.places, equations, patchesOfTheirOwn, config, 1);
  // Of the rotation, which no lever arm changes.
  for (int i = 1; i < 4; ++i)
    EXPECT_NEAR((adjusted.covariances[static_cast<std::size_t>(i)].topLeftCorner<3, 3>().trace()),
                3 * i * 4.0 / (1000.0 * 1000.0),
                1e-7);
}

TEST(JointAdjustment, covarianceIsNeverThatOfAnExactPoseWhereMatchesHaveNoMinimum)
{
  const MadeUpJob job(3);
  const std::vector<std::pair<int, int>> pairs = {{0, 1}, {1, 2}};
  AdjustmentConfig config;
  config.damping = 1e-9;
  const auto covarianceOfTheLast = [&](double curvature) {
    const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
      SurfaceEquations e = towards(job.relative(pairs[k].first, pairs[k].second), T);
      e.curvature *= k == 1 ? curvature : 1;
      return e;
    };
    return adjustJointly(job.truth, pairs, {0}, job.places, equations, patchesOfTheirOwn, config, 1).covariances[2];
  };
  EXPECT_TRUE(covarianceOfTheLast(-0.1).isApprox(covarianceOfTheLast(1), 1e-6));
  EXPECT_GT(covarianceOfTheLast(0.5).trace(), 1.1 * covarianceOfTheLast(1).trace());
  EXPECT_TRUE(covarianceOfTheLast(std::numeric_limits<double>::quiet_NaN()).allFinite()); // of the steps then
}

TEST(JointAdjustment, aPatchErrsOnceForAllPairsThatItTakesPartIn)
{
  // Twelve scans of the same 120 patches, each of which every scan has at another distance. All pairs overlap, so what
  // pairs say is far from independent: the errors of the poses must be those that the covariance names.
  constexpr int kScans = 12, kPatches = 120, kDraws = 20;
  constexpr double kNoise = 0.01; // [m]
  testing::Random random(4);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < kScans; ++i)
    for (int j = i + 1; j < kScans; ++j)
      pairs.emplace_back(i, j);
  double sum = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::Matrix<double, 6, kPatches> jacobians;
    Eigen::MatrixXd errors(kScans, kPatches);
    for (int p = 0; p < kPatches; ++p) {
      const Eigen::Vector3d n = Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()).normalized();
      const Eigen::Vector3d c(3 * random.gaussian(), 3 * random.gaussian(), random.gaussian());
      jacobians.col(p) << c.cross(n), n;
      for (int i = 0; i < kScans; ++i)
        errors(i, p) = kNoise * random.gaussian();
    }
    const auto residuals = [&](std::size_t k, const Eigen::Isometry3d& T) {
      const Eigen::AngleAxisd rotation(T.linear());
      SurfaceEquations::Vector6 motion;
      motion << rotation.angle() * rotation.axis(), T.translation();
      return Eigen::VectorXd(jacobians.transpose() * motion +
                             (errors.row(pairs[k].first) - errors.row(pairs[k].second)).transpose());
    };
    const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
      SurfaceEquations e;
      e.hessian = e.curvature = e.full_curvature = jacobians * jacobians.transpose();
      e.gradient = jacobians * residuals(k, T);
      e.weight = kPatches;
      return e;
    };
    const PatchGradientsFunction patches = [&](std::size_t k, const Eigen::Isometry3d& T, bool /*of_source*/) {
      return PatchGradients{jacobians * residuals(k, T).asDiagonal(), kMillimetre * jacobians};
    };
    AdjustmentConfig config;
    config.damping = 1e-9;
    const JointAdjustment adjusted =
        adjustJointly(std::vector<Eigen::Isometry3d>(kScans, Eigen::Isometry3d::Identity()),
                      pairs,
                      {0},
                      std::vector<Eigen::Vector3d>(kScans, Eigen::Vector3d::Zero()),
                      equations,
                      patches,
                      config,
                      1);
    for (std::size_t i = 1; i < kScans; ++i) {
      const Eigen::AngleAxisd rotation(adjusted.poses[i].linear());
      SurfaceEquations::Vector6 error;
      error << rotation.angle() * rotation.axis(), adjusted.poses[i].translation();
      sum += error.dot(adjusted.covariances[i].ldlt().solve(error)) / 6;
    }
  }
  // Each match counts with both of its patches, which is a little too much; each pair by itself would give above 2.
  const double mean = sum / (kDraws * (kScans - 1));
  EXPECT_GT(mean, 0.6);
  EXPECT_LT(mean, 1.3);
}

TEST(JointAdjustment, longRowsBendAsTheirLinksSay)
{
  // Each of 300 scans 2 m behind the one before, its heading by a ten-thousandth off: the last one by 0.03 in all. They
  // start in a straight row, as a damping that is too strong leaves them.
  constexpr int kScans = 300;
  constexpr double kBend = 1e-4; // [rad]
  std::vector<Eigen::Isometry3d> row;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < kScans; ++i) {
    row.emplace_back(Eigen::Translation3d(2 * i, 0, 0));
    if (i > 0)
      pairs.emplace_back(i, i - 1);
  }
  const Eigen::Isometry3d wanted = Eigen::Translation3d(2, 0, 0) * Eigen::AngleAxisd(kBend, Eigen::Vector3d::UnitZ());
  const EquationsFunction equations = [&](std::size_t, const Eigen::Isometry3d& T) {
    const Eigen::Isometry3d off = T * wanted.inverse();
    const Eigen::AngleAxisd rotation(off.linear());
    SurfaceEquations e;
    e.hessian.diagonal() << 1e4, 1e4, 1e4, 100, 100, 100; // surfaces 10 m away
    e.curvature = e.full_curvature = e.hessian;
    e.gradient << 1e4 * rotation.angle() * rotation.axis(), 100 * off.translation();
    e.weight = 100;
    return e;
  };
  const PatchGradientsFunction no_patches = [](std::size_t, const Eigen::Isometry3d&, bool) {
    return PatchGradients{PatchGradients::Columns(6, 0), PatchGradients::Columns(6, 0)};
  };
  const auto lastHeading = [&](double damping) {
    AdjustmentConfig config;
    config.damping = damping;
    const std::vector<Eigen::Vector3d> places(kScans, Eigen::Vector3d::Zero());
    const JointAdjustment adjusted = adjustJointly(row, pairs, {0}, places, equations, no_patches, config, 1);
    return std::atan2(adjusted.poses.back().linear()(1, 0), adjusted.poses.back().linear()(0, 0));
  };
  EXPECT_NEAR(lastHeading(dampingOf(AdjustmentConfig(), kScans)), (kScans - 1) * kBend, 0.01 * kScans * kBend);
  EXPECT_LT(lastHeading(AdjustmentConfig().damping), 0.9 * kScans * kBend);

  EXPECT_EQ(dampingOf(AdjustmentConfig(), 10), AdjustmentConfig().damping);
  // 1 plus less than half of epsilon is 1: such damping would be none.
  EXPECT_GT(dampingOf(AdjustmentConfig(), 100000), std::numeric_limits<double>::epsilon());
}

TEST(JointAdjustment, whatNothingDeterminesStays)
{
  const MadeUpJob job(3);
  const EquationsFunction nothing = [](std::size_t, const Eigen::Isometry3d&) { return SurfaceEquations(); };
  const PatchGradientsFunction no_patches = [](std::size_t, const Eigen::Isometry3d&, bool) {
    return PatchGradients{PatchGradients::Columns(6, 0), PatchGradients::Columns(6, 0)};
  };
  const JointAdjustment adjusted =
      adjustJointly(job.truth, {{0, 1}, {1, 2}}, {0}, job.places, nothing, no_patches, AdjustmentConfig(), 1);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_TRUE(adjusted.poses[i].isApprox(job.truth[i], 1e-12));
  EXPECT_EQ(adjusted.rms, 0);
}

} // namespace
} // namespace pcl_ssfr::test_multiway_choice
