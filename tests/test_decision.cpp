// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/decision.h"
#include "made_up_matches.h"
#include "patch_scenes.h"

#include <pcl_ssfr/options.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_decision {
namespace {

using ::testing::HasSubstr;
using testing::matchesOn;
using ::testing::MatchesRegex;
using ::testing::Not;
using testing::refinementOf;
using ::testing::StartsWith;

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(), kZ = Eigen::Vector3d::UnitZ();
constexpr double kNoiseFloor = 0.001; // [m]

/// A pose that puts the source's sensor at \p place; shares of the surface that meets its counterpart and that
/// contradicts.
ScoredPose
poseAt(const Eigen::Vector3d& place, double matched, double contradicted = 0)
{
  constexpr double kSurface = 200, kPatches = 500, kClutter = 400, kContradictionWeight = 14;
  SurfaceEvidence e;
  e.total = kSurface;
  e.matched = kSurface * matched;
  e.contradicted = kSurface * contradicted;
  e.unmatched = kSurface * 0.1;
  e.patches = e.facing = {kPatches, kPatches * matched, kPatches * contradicted};
  e.facing.beyond = e.facing.matched / 2;
  e.matched_normals = e.matched * Eigen::Matrix3d::Identity() / 3;
  e.clutter = kClutter * matched;
  ScoredPose pose;
  pose.T_target_source = Eigen::Translation3d(place);
  rate(pose, e, kContradictionWeight);
  return pose;
}

/// As polished in a room, with matches that err by \p deviation [m]: every motion is determined.
Refinement
polishInARoom(double deviation = 0.01)
{
  return refinementOf(matchesOn({kX, kY, kZ}, 200, kX, 1), deviation);
}

/// As polished in a corridor along x without an end.
Refinement
polishInACorridor()
{
  return refinementOf(matchesOn({kY, kZ}, 200, kX, 2));
}

/// As polished in a round tower with a floor: nothing determines the rotation about its axis z.
Refinement
polishInATower()
{
  testing::Matches m = matchesOn({kX, kZ}, 200, Eigen::Vector3d::Zero(), 3);
  testing::Random random(4);
  for (Eigen::Index i = 0; i < 200; ++i) {
    const double angle = random.uniform(-3.2, 3.2);
    m.normals.col(i) = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    m.points.col(i) = 4 * m.normals.col(i) + m.points(2, i) * kZ;
  }
  return refinementOf(m, Eigen::Vector3d::Zero());
}

/// A context with given probabilities of the poses; what is left is that of none of them.
DecisionContext
contextOf(const std::vector<double>& probabilities, const Refinement& polish = polishInARoom())
{
  DecisionContext context;
  context.posterior.poses = probabilities;
  context.posterior.none = 1 - std::accumulate(probabilities.begin(), probabilities.end(), 0.0);
  context.uncertainty = poseUncertainty(polish, kNoiseFloor);
  return context;
}

/// The same with the probabilities that follow from the poses.
DecisionContext
judged(const std::vector<ScoredPose>& poses, const Refinement& polish = polishInARoom())
{
  return contextOf(computePosterior(poses, makePosteriorModel(JudgementConfig(), true)).poses, polish);
}

TEST(Decision, AcceptsAClearPose)
{
  const Decision d = decide({poseAt(kX, 0.6), poseAt(9 * kX, 0.2)}, contextOf({0.95, 0.03}));
  EXPECT_EQ(d.status, Status::Converged);
  EXPECT_EQ(d.confidence, 0.95);
  EXPECT_TRUE(d.unobservable.empty());
  EXPECT_EQ(d.message, "60 % of the surface meets its counterpart, 0.0 % contradicts the pose");
}

TEST(Decision, AcceptsFromTheConfidenceThatIsAskedFor)
{
  const std::vector<ScoredPose> poses = {poseAt(kX, 0.6), poseAt(9 * kX, 0.55)};
  DecisionContext context = contextOf({0.75, 0.125});
  for (const auto& [asked, status] : {std::make_pair(0.5, Status::Converged),
                                      std::make_pair(0.75, Status::Converged),
                                      std::make_pair(0.76, Status::Ambiguous),
                                      std::make_pair(0.875, Status::Ambiguous),
                                      std::make_pair(0.88, Status::LowOverlap)}) {
    context.min_confidence = asked;
    const Decision d = decide(poses, context);
    EXPECT_EQ(d.status, status) << asked;
    EXPECT_EQ(d.confidence, 0.75);
  }
}

TEST(Decision, LittleSurfaceInCommon)
{
  const Decision d = decide({poseAt(kX, 0.01), poseAt(9 * kX, 0.005)}, contextOf({0.05, 0.02}));
  EXPECT_EQ(d.status, Status::LowOverlap);
  EXPECT_EQ(d.confidence, 0.05);
  EXPECT_EQ(d.message,
            "under the best pose only 1 % of the surface meets its counterpart: the scans may not show the same place");
  // From a fair overlap on nobody doubts that.
  EXPECT_THAT(decide({poseAt(kX, 0.09)}, contextOf({0.3})).message, HasSubstr("same place"));
  EXPECT_THAT(decide({poseAt(kX, 0.11)}, contextOf({0.3})).message, Not(HasSubstr("same place")));
  // What the model makes of such poses.
  const std::vector<ScoredPose> poses = {poseAt(kX, 0.01), poseAt(9 * kX, 0.005)};
  EXPECT_EQ(decide(poses, judged(poses)).status, Status::LowOverlap);
}

TEST(Decision, NamesTheDirectionThatIsNotDetermined)
{
  const Decision d = decide({poseAt(kX, 0.6)}, contextOf({0.95}, polishInACorridor()));
  EXPECT_EQ(d.status, Status::Unobservable);
  EXPECT_EQ(d.confidence, JudgementConfig().unsettled);
  ASSERT_EQ(d.unobservable.size(), 1U);
  EXPECT_NEAR(std::abs(d.unobservable[0].direction.x()), 1, 1e-9);
  EXPECT_FALSE(d.unobservable[0].rotation);
  EXPECT_THAT(d.message, MatchesRegex("the scene does not determine the translation along \\(-?1\\.00, .*"));
  // Not even when hardly any confidence is asked for.
  DecisionContext context = contextOf({0.95}, polishInACorridor());
  context.min_confidence = 0;
  EXPECT_EQ(decide({poseAt(kX, 0.6)}, context).status, Status::Unobservable);
  // That the truth probably is elsewhere comes first; the direction is reported all the same.
  const Decision little = decide({poseAt(kX, 0.01)}, contextOf({0.2}, polishInACorridor()));
  EXPECT_EQ(little.status, Status::LowOverlap);
  EXPECT_EQ(little.confidence, 0.2); // no more than it was
  EXPECT_EQ(little.unobservable.size(), 1U);
  // And it comes before rivals.
  const Decision rivalled =
      decide({poseAt(kX, 0.6), poseAt(9 * kX, 0.6)}, contextOf({0.48, 0.47}, polishInACorridor()));
  EXPECT_EQ(rivalled.status, Status::Unobservable);
}

TEST(Decision, NamesTheRotationThatIsPoorlyConstrained)
{
  const Refinement polish = polishInARoom(5); // [m]: two degrees or so
  DecisionContext context = contextOf({0.95}, polish);
  const Decision d = decide({poseAt(kX, 0.6)}, context);
  EXPECT_EQ(d.status, Status::Unobservable);
  EXPECT_LE(d.confidence, JudgementConfig().unsettled);
  ASSERT_FALSE(d.unobservable.empty());
  EXPECT_TRUE(d.unobservable[0].rotation);
  EXPECT_THAT(d.message,
              MatchesRegex("the rotation about .* of the target frame is poorly constrained "
                           "\\(sigma = [1-9][0-9]*\\.[0-9][0-9] deg\\)"));
  // A prior determines it when it is exact enough, and of the axes that it binds.
  const auto with = [&](const Eigen::Matrix3d& prior) {
    context.uncertainty = poseUncertainty(polish, kNoiseFloor, prior);
    return decide({poseAt(kX, 0.6)}, context).status;
  };
  const double exact = 1 / (0.003 * 0.003), rough = 1 / (0.1 * 0.1); // [1/rad^2]
  EXPECT_EQ(with(exact * Eigen::Matrix3d::Identity()), Status::Converged);
  EXPECT_EQ(with(rough * Eigen::Matrix3d::Identity()), Status::Unobservable);
  EXPECT_EQ(with(exact * (Eigen::Matrix3d::Identity() - kZ * kZ.transpose())), Status::Unobservable); // not the heading
}

TEST(Decision, ARotationThatNothingDeterminesHasNoSigma)
{
  const Decision d = decide({poseAt(kX, 0.6)}, contextOf({0.95}, polishInATower()));
  EXPECT_EQ(d.status, Status::Unobservable);
  ASSERT_EQ(d.unobservable.size(), 1U);
  EXPECT_TRUE(d.unobservable[0].rotation);
  EXPECT_NEAR(std::abs(d.unobservable[0].direction.z()), 1, 1e-6);
  EXPECT_THAT(d.message, StartsWith("the scene does not determine the rotation about ("));
  EXPECT_THAT(d.message, Not(HasSubstr("sigma")));
}

TEST(Decision, NothingIsSaidOfDirectionsBeforeThePolish)
{
  const Decision d = decide({poseAt(kX, 0.6)}, contextOf({0.95}, Refinement()));
  EXPECT_EQ(d.status, Status::Converged);
  EXPECT_TRUE(d.unobservable.empty());
}

TEST(Decision, TwoThatExplainTheScansAlike)
{
  ScoredPose rival = poseAt(kX + 6.5 * kY, 0.599);
  rival.T_target_source.linear() = Eigen::AngleAxisd(0.5 * 3.14159265358979, kZ).toRotationMatrix();
  std::vector<ScoredPose> poses = {poseAt(kX, 0.6), rival};
  const Decision d = decide(poses, judged(poses));
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_GT(d.confidence, 0.35);
  EXPECT_LT(d.confidence, 0.5);
  EXPECT_EQ(d.message,
            "2 distinct poses explain the scans about equally well (symmetry or repetition): the strongest rival lies "
            "6.50 m and 90.0 degrees away");
  // They are compared where the source's sensor is.
  DecisionContext elsewhere = judged(poses);
  elsewhere.source_viewpoint = 2 * kX;
  EXPECT_THAT(decide(poses, elsewhere).message, HasSubstr("8.73 m and 90.0 degrees")); // (-2, 8.5)
  // What is known beforehand, as from a guess, may decide between them.
  poses[0].log_prior = std::log(30);
  EXPECT_EQ(decide(poses, judged(poses)).status, Status::Converged);
}

TEST(Decision, CountsThePosesThatAreAboutEqual)
{
  const std::vector<ScoredPose> poses(4, poseAt(kX, 0.6));
  EXPECT_THAT(decide(poses, contextOf({0.3, 0.29, 0.28, 0.05})).message, StartsWith("3 distinct poses"));
  EXPECT_THAT(decide(poses, contextOf({0.25, 0.25, 0.25, 0.24})).message, StartsWith("4 distinct poses"));
  EXPECT_EQ(decide(poses, contextOf({0.3, 0.29, 0.28, 0.05})).status, Status::Ambiguous);
}

TEST(Decision, ARivalThatTakesAwayTheConfidence)
{
  const Decision d = decide({poseAt(kX, 0.2), poseAt(9 * kX, 0.18)}, contextOf({0.65, 0.3}));
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_EQ(d.confidence, 0.65);
  EXPECT_EQ(d.message,
            "other poses explain the scans nearly as well: the strongest rival lies 8.00 m and 0.0 degrees away; with "
            "probability 0.95 all is known but the translation along (1.00, 0.00, 0.00) of the target frame");
  EXPECT_EQ(decide({poseAt(kX, 0.2)}, contextOf({0.95})).status, Status::Converged);
}

TEST(Decision, AShiftThatAllProbablePosesDifferBy)
{
  // Along y lies what is probable, but for noise; the rest is elsewhere, and rotated.
  std::vector<ScoredPose> poses = {poseAt(kX, 0.3),
                                   poseAt(kX + 2 * kY, 0.3),
                                   poseAt(kX - 5 * kY + 0.1 * kZ, 0.3),
                                   poseAt(30 * kX, 0.3),
                                   poseAt(kX + 4 * kY, 0.3)};
  poses.back().T_target_source.linear() = Eigen::AngleAxisd(3.14, kZ).toRotationMatrix();
  const Decision d = decide(poses, contextOf({0.4, 0.3, 0.12, 0.06, 0.06}));
  EXPECT_EQ(d.status, Status::Ambiguous);
  EXPECT_EQ(d.confidence, 0.4);
  ASSERT_EQ(d.unobservable.size(), 1U);
  EXPECT_FALSE(d.unobservable[0].rotation);
  EXPECT_GT(std::abs(d.unobservable[0].direction.y()), 0.99);
  EXPECT_EQ(d.unobservable[0].strength, 0);
  EXPECT_THAT(d.message, HasSubstr("; with probability 0.82 all is known but the translation along ("));

  // Not where too much of it is off the line, or rotated.
  for (const std::vector<double>& p : {std::vector<double>{0.3, 0.2, 0.1, 0.35, 0.0}, {0.3, 0.2, 0.1, 0.0, 0.35}}) {
    const Decision open = decide(poses, contextOf(p));
    EXPECT_EQ(open.status, Status::Ambiguous);
    EXPECT_TRUE(open.unobservable.empty());
    EXPECT_THAT(open.message, Not(HasSubstr("all is known")));
  }
  // Two places are a line too.
  EXPECT_EQ(decide({poseAt(kX, 0.3), poseAt(9 * kX, 0.3)}, contextOf({0.5, 0.45})).unobservable.size(), 1U);
}

TEST(Decision, OneThatMatchesMoreButIsContradictedALittle)
{
  const auto status = [](const std::vector<ScoredPose>& poses) { return decide(poses, judged(poses)).status; };
  EXPECT_EQ(status({poseAt(kX, 0.6), poseAt(9 * kX, 0.66, 0.0005)}), Status::Ambiguous);
  EXPECT_EQ(status({poseAt(kX, 0.6), poseAt(9 * kX, 0.66, 0.02)}), Status::Converged);
}

TEST(Decision, LessConfidenceThanIsAskedFor)
{
  DecisionContext context = contextOf({0.9996});
  context.min_confidence = 1;
  const Decision sure = decide({poseAt(kX, 0.6)}, context);
  EXPECT_EQ(sure.status, Status::LowOverlap);
  EXPECT_EQ(sure.confidence, 0.9996);
  EXPECT_EQ(sure.message,
            "confidence 0.9996 is less than the 1 that is asked for: 60 % of the surface meets its counterpart, 0.0 % "
            "contradicts the pose"); // not 1.00
  context = contextOf({0.655});
  context.min_confidence = 0.7;
  EXPECT_THAT(decide({poseAt(kX, 0.3)}, context).message,
              MatchesRegex("confidence 0\\.6[56] is less than the 0\\.7 that is asked for: 30 % .*"));
  context.min_confidence = 0.6551;
  EXPECT_THAT(decide({poseAt(kX, 0.3)}, context).message, StartsWith("confidence 0.655 is less than the 0.6551 "));
  // Certainty is enough.
  context = contextOf({1.0});
  context.min_confidence = 1;
  EXPECT_EQ(decide({poseAt(kX, 0.6)}, context).status, Status::Converged);
}

TEST(Decision, NoConfidenceAskedForAcceptsAnyPoseWithEvidence)
{
  DecisionContext context = contextOf({0.01});
  context.min_confidence = 0;
  const Decision d = decide({poseAt(kX, 0.04)}, context);
  EXPECT_EQ(d.status, Status::Converged);
  EXPECT_EQ(d.confidence, 0.01);
  // Without any probability nothing is accepted.
  context = contextOf({0.0});
  context.min_confidence = 0;
  EXPECT_EQ(decide({poseAt(kX, 0)}, context).status, Status::LowOverlap);
  EXPECT_EQ(decide({poseAt(kX, 0.5, 0.1)}, context).status, Status::Contradicted);
}

TEST(Decision, SurfaceInFreeSpace)
{
  const std::vector<ScoredPose> poses = {poseAt(kX, 0.5, 0.1)};
  const Decision d = decide(poses, judged(poses));
  EXPECT_EQ(d.status, Status::Contradicted);
  EXPECT_LT(d.confidence, Options().min_confidence);
  EXPECT_EQ(
      d.message,
      "the best pose puts 10.0 % of the surface into space that the other sensor saw to be free, while 50 % meets "
      "its counterpart");
  // It is the reason from a tenth of the visible surface on, and only where the pose is refused.
  EXPECT_EQ(decide({poseAt(kX, 0.5, 0.067)}, contextOf({0.1})).status, Status::Contradicted);
  EXPECT_EQ(decide({poseAt(kX, 0.5, 0.066)}, contextOf({0.1})).status, Status::LowOverlap);
  DecisionContext picky = contextOf({0.1});
  picky.config.named_share = 0.05;
  EXPECT_EQ(decide({poseAt(kX, 0.5, 0.066)}, picky).status, Status::Contradicted);
  ScoredPose large_patch = poseAt(kX, 0.5, 0.1); // that contradicts, one of many
  large_patch.score = 0.5;
  EXPECT_EQ(decide({large_patch}, contextOf({0.95})).status, Status::Converged);
  EXPECT_EQ(decide({large_patch}, contextOf({0.6})).status, Status::Contradicted);
}

TEST(Decision, PlanesInTooFewDirections)
{
  DecisionContext context = contextOf({0.1});
  context.few_directions = "the source scan has planes in fewer than two directions";
  const Decision d = decide({poseAt(kX, 0.01)}, context);
  EXPECT_EQ(d.status, Status::TooFewDirections);
  EXPECT_EQ(d.confidence, 0.1);
  EXPECT_THAT(d.message, StartsWith(context.few_directions + ", and what is no plane does not determine its rotation"));
  EXPECT_THAT(d.message, HasSubstr("only 1 %"));
  // It is the reason whatever else would be.
  const auto status = [&](const std::vector<double>& probabilities, const Refinement& polish) {
    DecisionContext other = contextOf(probabilities, polish);
    other.few_directions = context.few_directions;
    return decide({poseAt(kX, 0.6), poseAt(kY, 0.6)}, other).status;
  };
  EXPECT_EQ(status({0.48, 0.48}, polishInARoom()), Status::TooFewDirections);
  EXPECT_EQ(status({0.95, 0.01}, polishInACorridor()), Status::TooFewDirections);
  // What stands on the plane may determine it all the same.
  EXPECT_EQ(status({0.95, 0.01}, polishInARoom()), Status::Converged);
}

TEST(Decision, TheTimeRanOut)
{
  DecisionContext context = contextOf({0.95});
  context.is_cut_short = true;
  const Decision d = decide({poseAt(kX, 0.6)}, context);
  EXPECT_EQ(d.status, Status::TimeLimit);
  EXPECT_EQ(d.confidence, JudgementConfig().unsettled);
  EXPECT_THAT(d.message, StartsWith("the time limit cut the search short; so far: 60 % of the surface"));
  // It makes nothing surer than it was, and hides nothing of what was found.
  context = contextOf({0.2}, polishInACorridor());
  context.is_cut_short = true;
  context.few_directions = "the target scan has planes in fewer than two directions";
  const Decision little = decide({poseAt(kX, 0.01)}, context);
  EXPECT_EQ(little.status, Status::TimeLimit);
  EXPECT_EQ(little.confidence, 0.2);
  EXPECT_EQ(little.unobservable.size(), 1U);
  EXPECT_THAT(little.message, HasSubstr("so far: the target scan has planes in fewer"));
  // However little is asked for.
  context = contextOf({0.95});
  context.is_cut_short = true;
  context.min_confidence = 0;
  EXPECT_EQ(decide({poseAt(kX, 0.6)}, context).status, Status::TimeLimit);
}

TEST(Decision, NoEvidenceAtAll)
{
  const std::vector<ScoredPose> poses = {ScoredPose()};
  const Decision d = decide(poses, judged(poses, Refinement()));
  EXPECT_EQ(d.status, Status::LowOverlap);
  EXPECT_EQ(d.confidence, 0);
}

/// The status by the rules of the method, one after the other.
Status
statusByTheRules(const std::vector<ScoredPose>& poses, const DecisionContext& context, bool is_determined)
{
  if (context.is_cut_short)
    return Status::TimeLimit;
  const SurfaceEvidence& e = poses.front().evidence;
  const double sum = std::accumulate(context.posterior.poses.begin(), context.posterior.poses.end(), 0.0);
  Status status = Status::Converged;
  const bool is_probably_none = sum < context.min_confidence || sum <= 0;
  const bool meets = e.matched >= 0.1 * e.total;
  if (!is_determined && (meets || !is_probably_none))
    status = Status::Unobservable;
  else if (is_probably_none)
    status =
        e.contradicted > 0.1 * (e.matched + e.contradicted + e.unmatched) ? Status::Contradicted : Status::LowOverlap;
  else if (context.posterior.poses.front() < context.min_confidence)
    status = Status::Ambiguous;
  return status != Status::Converged && !context.few_directions.empty() ? Status::TooFewDirections : status;
}

TEST(Decision, AcceptsOnlyWhatItIsSureOfAndForAnyUnitOfLength)
{
  testing::Random random(4);
  int accepted = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<ScoredPose> poses;
    for (int k = random.index(6); k >= 0; --k)
      poses.push_back(poseAt(Eigen::Vector3d(random.uniform(-9, 9), 0, random.uniform(-9, 9)),
                             random.uniform(0, 0.8),
                             random.index(8) ? random.uniform(0, 0.01) : random.uniform(0, 0.1)));
    const PosteriorModel model = makePosteriorModel(JudgementConfig(), random.index(4) > 0);
    sortByProbability(poses, model);
    const bool is_determined = random.index(6) > 0;
    const Refinement polish = is_determined ? polishInARoom() : polishInACorridor();
    DecisionContext context;
    context.posterior = computePosterior(poses, model);
    context.uncertainty = poseUncertainty(polish, kNoiseFloor);
    context.min_confidence = random.index(2) ? 0.7 : random.uniform(0, 1);
    context.is_cut_short = random.index(8) == 0;
    if (random.index(8) == 0)
      context.few_directions = "the source scan has planes in fewer than two directions";
    const Decision d = decide(poses, context);
    ASSERT_EQ(d.status, statusByTheRules(poses, context, is_determined)) << trial;
    ASSERT_TRUE(d.confidence >= 0 && d.confidence <= context.posterior.best());
    ASSERT_FALSE(d.message.empty());
    const bool is_shared_line = d.message.find("all is known but") != std::string::npos;
    ASSERT_EQ(d.unobservable.empty(), is_determined && !is_shared_line) << d.message;
    if (d.status == Status::Converged) {
      ++accepted;
      ASSERT_GE(d.confidence, context.min_confidence);
      ASSERT_EQ(d.confidence, context.posterior.best());
    }
    // The same scene, ten times as large.
    std::vector<ScoredPose> larger = poses;
    for (ScoredPose& pose : larger)
      pose.T_target_source.translation() *= 10;
    Refinement wide = polish;
    wide.rms *= 10;
    wide.centre *= 10;
    for (testing::Matrix6* m :
         {&wide.hessian, &wide.statistics.curvature, &wide.statistics.scatter, &wide.statistics.unit_scatter}) {
      m->topLeftCorner<3, 3>() *= 100;
      m->topRightCorner<3, 3>() *= 10;
      m->bottomLeftCorner<3, 3>() *= 10;
    }
    wide.statistics.scatter *= 100;
    context.uncertainty = poseUncertainty(wide, 10 * kNoiseFloor);
    const Decision again = decide(larger, context);
    ASSERT_EQ(again.status, d.status);
    ASSERT_EQ(again.confidence, d.confidence);
  }
  EXPECT_GT(accepted, kTrials / 10);
  EXPECT_LT(accepted, kTrials * 9 / 10);
}

} // namespace
} // namespace pcl_ssfr::test_decision
