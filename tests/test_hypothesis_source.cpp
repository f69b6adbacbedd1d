// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pose_matchers.h"
#include "profiles/hypothesis_source.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace pcl_ssfr::test_hypothesis_source {
namespace {

using testing::IsPoseNear;
using testing::viewOfPoints;

/// All batches of a source, until there are none.
std::vector<HypothesisBatch>
allOf(HypothesisSource& source)
{
  constexpr std::size_t kMost = 10; // more than there are
  std::vector<HypothesisBatch> batches;
  while (const std::optional<HypothesisBatch> batch = source.next()) {
    batches.push_back(*batch);
    if (batches.size() == kMost)
      break;
  }
  return batches;
}

void
expectSame(const std::vector<HypothesisBatch>& a, const std::vector<HypothesisBatch>& b)
{
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].has_guess, b[i].has_guess);
    EXPECT_EQ(a[i].distinct, b[i].distinct);
    ASSERT_EQ(a[i].poses.size(), b[i].poses.size());
    for (std::size_t k = 0; k < a[i].poses.size(); ++k)
      EXPECT_EQ(a[i].poses[k].matrix(), b[i].poses[k].matrix()); // bit for bit
  }
}

/// Two scans of a furnished room, prepared once for all tests.
class HypothesesOfARoom : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    const testing::Scene scene = testing::makeFurnishedRoom(1);
    const Eigen::Isometry3d T_world_target = testing::sensorPose(scene.stations.at(0), 0.1);
    const Eigen::Isometry3d T_world_source = testing::sensorPose(scene.stations.at(1), 1.85, 0.2);
    const auto prepared = [&](const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed) {
      const Eigen::Matrix3Xf points = testing::castScan(scene, T_world_sensor, testing::roomScanner(0.0262), seed);
      return preparePatchScan(viewOfPoints(points), Options());
    };
    source_ = new PatchScan(prepared(T_world_source, 12));
    target_ = new PatchScan(prepared(T_world_target, 11));
    truth_ = testing::relativePose(T_world_target, T_world_source);
  }

  static void
  TearDownTestSuite()
  {
    delete source_;
    delete target_;
    source_ = target_ = nullptr;
  }

  PatchPair
  pair(const Eigen::Isometry3d* guess = nullptr) const
  {
    return PatchPair(*source_, *target_, options_, guess, Deadline());
  }

  static inline PatchScan* source_ = nullptr;
  static inline PatchScan* target_ = nullptr;
  static inline Eigen::Isometry3d truth_ = Eigen::Isometry3d::Identity(); ///< between the sensors' frames
  Options options_;
  std::vector<StageReport> reports_;
  StageLog stages_ = StageLog(reports_);
};

TEST_F(HypothesesOfARoom, ThePromisingOnesThenTheRestThenLittleOverlapThenPlansThenNone)
{
  const PatchPair scans = pair();
  const SearchConfig& config = scans.config().search;
  const Eigen::Isometry3d guess = Eigen::Translation3d(1, 2, 3) * Eigen::Isometry3d::Identity();
  SearchTrace trace;
  HypothesisSource source(scans, guess, stages_, &trace);
  EXPECT_TRUE(reports_.empty()); // each batch is made when it is asked for

  const std::optional<HypothesisBatch> promising = source.next();
  ASSERT_TRUE(promising);
  ASSERT_EQ(trace.passes.size(), 1U);
  EXPECT_FALSE(trace.passes[0].little_overlap);
  EXPECT_EQ(promising->distinct, static_cast<std::size_t>(config.much_overlap.distinct));
  // Those that have a share of the votes of the best, and the guess behind them.
  const std::vector<TracedHypothesis> found = trace.passes[0].hypotheses;
  ASSERT_GT(found.size(), static_cast<std::size_t>(config.much_overlap.refined));
  const auto count = static_cast<std::size_t>(std::count_if(found.begin(), found.end(), [&](const TracedHypothesis& h) {
    return h.votes >= config.promising * found.front().votes;
  }));
  ASSERT_LT(count, static_cast<std::size_t>(config.much_overlap.refined)); // there is a rest
  EXPECT_TRUE(promising->has_guess);
  ASSERT_EQ(promising->poses.size(), count + 1);
  EXPECT_EQ(promising->poses.back().matrix(), guess.matrix());
  const auto refined = [&](std::size_t pass) {
    const std::vector<TracedHypothesis>& h = trace.passes[pass].hypotheses;
    return static_cast<std::size_t>(
        std::count_if(h.begin(), h.end(), [](const TracedHypothesis& one) { return one.refined; }));
  };
  EXPECT_EQ(refined(0), count);
  // The truth is among them.
  EXPECT_TRUE(std::any_of(promising->poses.begin(), promising->poses.end() - 1, [&](const Eigen::Isometry3d& T) {
    return translationBetween(T, scans.toInner(truth_), source_->viewpoint) < 0.5 * scans.scale() &&
           rotationBetween(T, scans.toInner(truth_)) < config.direction_error;
  }));

  const std::optional<HypothesisBatch> rest = source.next();
  ASSERT_TRUE(rest);
  EXPECT_FALSE(rest->has_guess);
  EXPECT_EQ(rest->distinct, promising->distinct);
  EXPECT_EQ(trace.passes.size(), 1U); // nothing was searched for it
  ASSERT_EQ(rest->poses.size(), static_cast<std::size_t>(config.much_overlap.refined) - count);
  EXPECT_EQ(refined(0), static_cast<std::size_t>(config.much_overlap.refined));

  const std::optional<HypothesisBatch> little = source.next();
  ASSERT_TRUE(little);
  EXPECT_FALSE(little->has_guess);
  EXPECT_EQ(little->distinct, static_cast<std::size_t>(config.little_overlap.distinct));
  ASSERT_EQ(trace.passes.size(), 2U);
  EXPECT_TRUE(trace.passes[1].little_overlap);
  EXPECT_FALSE(little->poses.empty());
  EXPECT_EQ(little->poses.size(),
            std::min(trace.passes[1].hypotheses.size(), static_cast<std::size_t>(config.little_overlap.refined)));
  EXPECT_EQ(refined(1), little->poses.size());
  // The best ones of the rotations, each searched alone, though what the first ones find bounds what others may lack.
  std::vector<double> alone;
  for (const Eigen::Matrix3d& R : trace.passes[1].rotations)
    for (const PoseHypothesis& h : searchTranslations(source_->patches.samples,
                                                      source_->votes,
                                                      target_->patches.samples,
                                                      source.targetNormals(),
                                                      target_->index,
                                                      target_->freeSpace(),
                                                      R,
                                                      source.searchOptions(config.little_overlap)))
      alone.push_back(h.score);
  std::sort(alone.begin(), alone.end(), std::greater<>());
  ASSERT_GT(alone.size(), 2 * little->poses.size());
  for (std::size_t i = 0; i < little->poses.size(); ++i)
    EXPECT_GE(trace.passes[1].hypotheses[i].votes, 0.95 * alone[i]) << i;

  EXPECT_TRUE(trace.plan_hypotheses.empty());
  const std::optional<HypothesisBatch> plans = source.next();
  ASSERT_TRUE(plans);
  EXPECT_FALSE(plans->has_guess);
  EXPECT_EQ(plans->distinct, static_cast<std::size_t>(config.little_overlap.distinct));
  EXPECT_EQ(trace.passes.size(), 2U);
  ASSERT_FALSE(plans->poses.empty());
  EXPECT_EQ(plans->poses.size(),
            std::min(trace.plan_hypotheses.size(), static_cast<std::size_t>(config.much_overlap.refined)));
  for (std::size_t i = 0; i < trace.plan_hypotheses.size(); ++i) {
    const TracedHypothesis& h = trace.plan_hypotheses[i];
    EXPECT_EQ(h.refined, i < plans->poses.size());
    EXPECT_TRUE(i == 0 || trace.plan_hypotheses[i - 1].votes >= h.votes);
    if (h.refined) {
      EXPECT_THAT(h.T_target_source, IsPoseNear(scans.toOuter(plans->poses[i]), 1e-12, 1e-9));
    }
  }

  EXPECT_FALSE(source.next());
  EXPECT_FALSE(source.next());

  // Each pose was taken once, in the order of the votes, and the trace has them in the scans' own frames.
  std::vector<Eigen::Isometry3d> first_pass(promising->poses.begin(), promising->poses.end() - 1);
  first_pass.insert(first_pass.end(), rest->poses.begin(), rest->poses.end());
  for (const std::size_t pass : {0, 1}) {
    const std::vector<Eigen::Isometry3d>& poses = pass == 0 ? first_pass : little->poses;
    const std::vector<TracedHypothesis>& traced = trace.passes[pass].hypotheses;
    for (std::size_t i = 0; i < traced.size(); ++i) {
      EXPECT_EQ(traced[i].refined, i < poses.size());
      EXPECT_TRUE(i == 0 || traced[i - 1].votes >= traced[i].votes);
      if (i < poses.size()) {
        EXPECT_THAT(traced[i].T_target_source, IsPoseNear(scans.toOuter(poses[i]), 1e-12, 1e-9));
      }
    }
    ASSERT_EQ(trace.passes[pass].rotations.size(), source.rotations().size());
    for (std::size_t i = 0; i < source.rotations().size(); ++i)
      EXPECT_EQ(trace.passes[pass].rotations[i], source.rotations()[i].R_target_source);
  }

  // What was done is reported.
  ASSERT_EQ(reports_.size(), 4U);
  EXPECT_EQ(reports_[3].name, "plan views");
  EXPECT_EQ(reports_[3].count_out, trace.plan_hypotheses.size());
  EXPECT_EQ(reports_[0].name, "rotations");
  EXPECT_GT(reports_[0].count_in, 0U);
  EXPECT_EQ(reports_[0].count_out, source.rotations().size());
  for (const std::size_t pass : {0, 1}) {
    EXPECT_EQ(reports_[1 + pass].name, "translations");
    EXPECT_EQ(reports_[1 + pass].count_in, source.rotations().size());
    EXPECT_EQ(reports_[1 + pass].count_out, trace.passes[pass].hypotheses.size());
  }
}

TEST_F(HypothesesOfARoom, TheSameWithAndWithoutTraceAndForAnyThreadCount)
{
  options_.threads = 1;
  const PatchPair one_thread = pair();
  HypothesisSource untraced(one_thread, std::nullopt, stages_, nullptr);
  const std::vector<HypothesisBatch> expected = allOf(untraced);
  ASSERT_EQ(expected.size(), 4U);
  SearchTrace trace;
  HypothesisSource traced(one_thread, std::nullopt, stages_, &trace);
  expectSame(allOf(traced), expected);
  Options more = options_;
  more.threads = 3;
  const PatchPair threads(*source_, *target_, more, nullptr, Deadline());
  HypothesisSource parallel(threads, std::nullopt, stages_, nullptr);
  expectSame(allOf(parallel), expected);
}

TEST_F(HypothesesOfARoom, AllAtOnceWhereNoneAreMorePromising)
{
  options_.patch_profile.search.promising = 0;
  const PatchPair scans = pair();
  HypothesisSource source(scans, std::nullopt, stages_, nullptr);
  const std::vector<HypothesisBatch> batches = allOf(source);
  ASSERT_EQ(batches.size(), 3U);
  EXPECT_EQ(batches[0].poses.size(), static_cast<std::size_t>(scans.config().search.much_overlap.refined));
  EXPECT_FALSE(batches[0].has_guess);
  EXPECT_EQ(batches[1].distinct, static_cast<std::size_t>(scans.config().search.little_overlap.distinct));
}

TEST_F(HypothesesOfARoom, PassesDifferAsConfigured)
{
  const PatchPair scans = pair();
  const HypothesisSource source(scans, std::nullopt, stages_, nullptr);
  const SearchConfig& config = scans.config().search;
  const PoseSearchOptions much = source.searchOptions(config.much_overlap);
  const PoseSearchOptions little = source.searchOptions(config.little_overlap);
  EXPECT_FALSE(much.pass.little_overlap);
  EXPECT_TRUE(little.pass.little_overlap);
  EXPECT_EQ(much.pass.peaks_first, config.much_overlap.peaks_first);
  EXPECT_EQ(little.pass.peaks_second, config.little_overlap.peaks_second);
  EXPECT_EQ(much.peak_separation, scans.config().refinement.distinct_distance);
  EXPECT_FALSE(much.window);
}

TEST_F(HypothesesOfARoom, AVerticalBoundsTheRotations)
{
  options_.gravity.emplace();
  options_.gravity->up_target = Eigen::Vector3d::UnitZ();
  options_.gravity->up_source = truth_.linear().transpose() * Eigen::Vector3d::UnitZ();
  options_.gravity->tolerance = 0.05;
  const PatchPair scans = pair();
  HypothesisSource source(scans, std::nullopt, stages_, nullptr);
  const std::optional<HypothesisBatch> batch = source.next();
  ASSERT_TRUE(batch);
  ASSERT_FALSE(batch->poses.empty());
  ASSERT_FALSE(source.rotations().empty());
  for (const RotationCandidate& r : source.rotations())
    EXPECT_TRUE(scans.priors().allow(r.R_target_source, Exactness::Proposed));
  for (const Eigen::Isometry3d& T : batch->poses)
    EXPECT_TRUE(scans.priors().allow(Eigen::Matrix3d(T.linear()), Exactness::Proposed));
}

TEST_F(HypothesesOfARoom, PlansAreDrawnWhereTwoMainNormalsAreNotCommon)
{
  const auto batches = [&](const PatchScan& source, const PatchScan& target) {
    const PatchPair scans(source, target, options_, nullptr, Deadline());
    SearchTrace trace;
    HypothesisSource hypotheses(scans, std::nullopt, stages_, &trace);
    const std::size_t number = allOf(hypotheses).size();
    return std::make_pair(number, trace.plan_hypotheses.size());
  };
  options_.patch_profile.search.plans_below = 0.3;
  EXPECT_EQ(batches(*source_, *target_), std::make_pair(std::size_t(3), std::size_t(0)));
  // As on a road: of what main normals stand for, nearly all is the floor.
  const auto road = [](PatchScan scan) {
    const auto floor = std::max_element(
        scan.main_normals.begin(), scan.main_normals.end(), [](auto& a, auto& b) { return a.support < b.support; });
    for (MainNormal& normal : scan.main_normals)
      if (std::abs(normal.direction.dot(floor->direction)) < 0.5)
        normal.support *= 0.05;
    return scan;
  };
  const auto [number, plans] = batches(road(*source_), road(*target_));
  EXPECT_EQ(number, 4U);
  EXPECT_GT(plans, 0U);
}

TEST_F(HypothesesOfARoom, AVerticalIsADirectionWhereNoPlaneFacesIt)
{
  // One wall in each scan: with the vertical that is a pair of directions.
  PatchScan source = *source_, target = *target_;
  source.main_normals = {{Eigen::Vector3d::UnitX(), 1}};
  target.main_normals = {{Eigen::Vector3d::UnitY(), 1}};
  const PatchPair without(source, target, options_, nullptr, Deadline());
  EXPECT_NE(HypothesisSource(without, std::nullopt, stages_, nullptr).fewDirections(), "");
  options_.gravity.emplace();
  options_.gravity->up_source = Eigen::Vector3d(0, 0.6, 0.8);
  const PatchPair scans(source, target, options_, nullptr, Deadline());
  const HypothesisSource with(scans, std::nullopt, stages_, nullptr);
  ASSERT_EQ(with.sourceNormals().size(), 2U);
  ASSERT_EQ(with.targetNormals().size(), 2U);
  EXPECT_EQ(with.sourceNormals()[1].direction, options_.gravity->up_source);
  EXPECT_EQ(with.targetNormals()[1].direction, options_.gravity->up_target);
  EXPECT_EQ(with.fewDirections(), "");
}

TEST_F(HypothesesOfARoom, AGuessOfKnownToleranceBoundsThePosesAndIsARotationItself)
{
  options_.guess_tolerance = GuessTolerance{0.2, 1};
  const Eigen::Isometry3d guess =
      Eigen::Translation3d(0.3, -0.2, 0.1) * truth_ * Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized());
  const PatchPair scans = pair(&guess);
  HypothesisSource source(scans, scans.toInner(guess), stages_, nullptr);
  const std::vector<HypothesisBatch> batches = allOf(source);
  ASSERT_GE(batches.size(), 2U);
  ASSERT_TRUE(batches[0].has_guess);
  ASSERT_GT(batches[0].poses.size(), 1U); // not the guess alone
  EXPECT_EQ(source.rotations().back().R_target_source, scans.toInner(guess).linear());
  const double reach =
      options_.guess_tolerance->translation + scans.config().refinement.distinct_distance; // along each axis
  for (const HypothesisBatch& batch : batches)
    for (const Eigen::Isometry3d& T : batch.poses) {
      EXPECT_TRUE(scans.priors().allow(Eigen::Matrix3d(T.linear()), Exactness::Proposed));
      EXPECT_LT(translationBetween(T, scans.toInner(guess), source_->viewpoint),
                std::sqrt(3) * (reach + scans.config().refinement.coarse_reach / 2));
    }
}

TEST_F(HypothesesOfARoom, NothingToSearchLeavesTheGuess)
{
  const PatchScan empty = preparePatchScan(ScanView(), options_);
  const Eigen::Isometry3d guess = Eigen::Isometry3d::Identity();
  const PatchPair nothing(empty, empty, options_, nullptr, Deadline());
  SearchTrace trace;
  HypothesisSource with_guess(nothing, guess, stages_, &trace);
  const std::vector<HypothesisBatch> batches = allOf(with_guess);
  ASSERT_EQ(batches.size(), 1U);
  EXPECT_TRUE(batches[0].has_guess);
  EXPECT_EQ(batches[0].poses.size(), 1U);
  ASSERT_EQ(trace.passes.size(), 1U);
  EXPECT_TRUE(trace.passes[0].rotations.empty());
  EXPECT_TRUE(trace.passes[0].hypotheses.empty());
  HypothesisSource without(nothing, std::nullopt, stages_, nullptr);
  const std::vector<HypothesisBatch> none = allOf(without);
  ASSERT_EQ(none.size(), 1U);
  EXPECT_FALSE(none[0].has_guess);
  EXPECT_TRUE(none[0].poses.empty());
}

TEST_F(HypothesesOfARoom, NamesTheScanWithPlanesInFewDirections)
{
  const auto few = [&](const PatchScan& source, const PatchScan& target) {
    const PatchPair scans(source, target, options_, nullptr, Deadline());
    return HypothesisSource(scans, std::nullopt, stages_, nullptr).fewDirections();
  };
  PatchScan floor = *source_;
  floor.main_normals = {{Eigen::Vector3d::UnitZ(), 1}};
  EXPECT_EQ(few(*source_, *target_), "");
  EXPECT_EQ(few(floor, *target_), "the source scan has planes in fewer than two directions");
  EXPECT_EQ(few(*target_, floor), "the target scan has planes in fewer than two directions");
}

TEST_F(HypothesesOfARoom, WhereTheTimeHasRunOutOnlyTheGuessIsLeft)
{
  const PatchPair late(*source_, *target_, options_, nullptr, Deadline::after(1e-9));
  HypothesisSource source(late, Eigen::Isometry3d::Identity(), stages_, nullptr);
  const std::vector<HypothesisBatch> batches = allOf(source);
  ASSERT_FALSE(batches.empty());
  EXPECT_EQ(batches[0].poses.size(), 1U);
  for (std::size_t i = 1; i < batches.size(); ++i)
    EXPECT_TRUE(batches[i].poses.empty());
}

} // namespace
} // namespace pcl_ssfr::test_hypothesis_source
