// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "pose_matchers.h"
#include "search/pose_search.h"
#include "searched_scans.h"

#include <pcl_ssfr/patch_config.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::test_pose_search {
namespace {

using testing::addPatch;

std::vector<MainNormal>
normals(const std::vector<Eigen::Vector3d>& directions)
{
  std::vector<MainNormal> main_normals;
  main_normals.reserve(directions.size());
  for (const Eigen::Vector3d& d : directions)
    main_normals.push_back({d.normalized(), 1});
  return main_normals;
}

/// The six directions of a room, rotated by \p R.
std::vector<MainNormal>
roomNormals(const Eigen::Matrix3d& R)
{
  std::vector<Eigen::Vector3d> directions;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0})
      directions.emplace_back(side * R.col(axis));
  return normals(directions);
}

testing::SearchedScan
makeScan(const std::vector<testing::Rectangle>& rectangles, const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed)
{
  return testing::makeSearchedScan(
      rectangles, T_world_sensor, roomNormals(T_world_sensor.linear().transpose()), {400, 0.05, 0.01, 0.05}, seed);
}

class PoseSearch : public ::testing::Test {
protected:
  const Eigen::Isometry3d T_world_target_ = testing::sensorPose(Eigen::Vector3d(0.3, 0.4, 0.2), 0.7, 0.1);
  const Eigen::Isometry3d T_world_source_ = testing::sensorPose(Eigen::Vector3d(-0.9, -0.6, 0.1), -1.3, 0.05);
  const testing::SearchedScan target_ = makeScan(testing::roomRectangles(), T_world_target_, 1);
  const testing::SearchedScan source_ = makeScan(testing::roomRectangles(), T_world_source_, 2);
  const Eigen::Isometry3d truth_ = testing::relativePose(T_world_target_, T_world_source_);

  std::vector<PoseHypothesis>
  search(const Eigen::Matrix3d& R, const PoseSearchOptions& options, bool with_image = true) const
  {
    return searchTranslations(source_.patches.samples,
                              source_.votes,
                              target_.patches.samples,
                              target_.main_normals,
                              target_.index,
                              with_image ? &target_.image : nullptr,
                              R,
                              options);
  }

  struct Votes {
    int in_favour = 0, against = 0;
  };

  /// How the places of the source vote on a pose, one by one.
  Votes
  votesOn(const Eigen::Isometry3d& T_target_source, const PoseSearchOptions& options, bool with_image) const
  {
    Votes votes;
    for (Eigen::Index i = 0; i < source_.votes.points.cols(); ++i) {
      const Eigen::Vector3f p = (T_target_source * source_.votes.points.col(i).cast<double>()).cast<float>();
      const Eigen::Vector3f n = T_target_source.linear().cast<float>() * source_.votes.normals.col(i);
      if (target_.index.mask(p) >> directionClass(n) & 1) {
        ++votes.in_favour;
        continue;
      }
      const Eigen::Vector3f ray = p - target_.image.viewpoint();
      const float free = target_.image.freeRange(target_.image.cell(ray));
      votes.against +=
          with_image && free > 0 && ray.norm() < options.visibility.free_ratio * free - options.visibility.free_margin;
    }
    return votes;
  }
};

TEST_F(PoseSearch, FindsTheTranslation)
{
  for (const bool with_image : {false, true}) {
    const auto found = search(truth_.linear(), PoseSearchOptions(), with_image);
    ASSERT_FALSE(found.empty());
    EXPECT_THAT(found[0].T_target_source, testing::IsPoseNear(truth_, 1e-9, 0.2));
    EXPECT_GT(found[0].score, 0.8);
  }
}

TEST_F(PoseSearch, AWrongRotationScoresLess)
{
  const double best = search(truth_.linear(), PoseSearchOptions())[0].score;
  const Eigen::Matrix3d quarter =
      Eigen::AngleAxisd(std::acos(-1.0) / 2, T_world_target_.linear().transpose() * Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  const auto rotated = search(quarter * truth_.linear(), PoseSearchOptions());
  ASSERT_FALSE(rotated.empty());
  EXPECT_LT(rotated[0].score, best - 0.1);
}

TEST_F(PoseSearch, ResultsAreDistinctSortedAndBounded)
{
  PoseSearchOptions options;
  for (const int keep : {1, 5, 24}) {
    options.pass.refined = keep;
    const auto found = search(truth_.linear(), options);
    EXPECT_LE(found.size(), static_cast<std::size_t>(keep));
    EXPECT_FALSE(found.empty());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_TRUE(found[i].T_target_source.linear().isApprox(truth_.linear(), 1e-12));
      EXPECT_TRUE(i == 0 || found[i - 1].score >= found[i].score);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((found[i].T_target_source.translation() - found[j].T_target_source.translation()).norm(),
                  options.peak_separation);
    }
  }
}

TEST_F(PoseSearch, ScoresAreTheShareOfTheVotes)
{
  PoseSearchOptions options;
  options.visibility.free_margin = 0.05f; // the room is small
  const Eigen::Matrix3d half_turn =
      Eigen::AngleAxisd(std::acos(-1.0), T_world_target_.linear().transpose() * Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  for (const bool with_image : {false, true}) {
    int contradicted = 0;
    for (const Eigen::Matrix3d& R : {truth_.linear().eval(), (half_turn * truth_.linear()).eval()})
      for (const PoseHypothesis& pose : search(R, options, with_image)) {
        const Votes votes = votesOn(pose.T_target_source, options, with_image);
        contradicted += votes.against;
        const double expected = (votes.in_favour - options.config.contradiction_weight * votes.against) /
                                static_cast<double>(source_.votes.points.cols());
        EXPECT_NEAR(pose.score, expected, 0.02); // a vote or so on the border of a voxel
      }
    EXPECT_EQ(contradicted > 20, with_image) << contradicted;
  }
}

TEST_F(PoseSearch, LittleOverlapRanksByVotesForEachOneAgainst)
{
  PoseSearchOptions options;
  options.pass.little_overlap = true;
  options.visibility.free_margin = 0.05f;
  options.pass.refined = 1000;
  const auto found = search(truth_.linear(), options);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found[0].T_target_source, testing::IsPoseNear(truth_, 1e-9, 0.2));
  const auto places = static_cast<double>(source_.votes.points.cols());
  int contradicted = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_GT(found[i].votes, 0);
    EXPECT_TRUE(i == 0 || found[i - 1].score >= found[i].score);
    const Votes votes = votesOn(found[i].T_target_source, options, true);
    contradicted += votes.against;
    // A vote or so is on the border of a voxel.
    EXPECT_LE(found[i].score, (votes.in_favour + 2) / (std::max(votes.against, 1) * places));
    EXPECT_GE(found[i].score, (votes.in_favour - 2) / ((votes.against + 2) * places));
  }
  EXPECT_GT(contradicted, 20);
  // Without free space nothing is against a pose.
  for (const PoseHypothesis& pose : search(truth_.linear(), options, false))
    EXPECT_NEAR(pose.score, pose.votes / static_cast<double>(source_.votes.points.cols()), 1e-12);
}

TEST_F(PoseSearch, WhatScoresLessThanTheLeastScoreIsLeftOutAndNothingElse)
{
  PoseSearchOptions options;
  options.pass.little_overlap = true;
  options.visibility.free_margin = 0.05f;
  options.pass.refined = 1000;
  for (const bool with_image : {false, true}) {
    options.config.screening_share = SearchConfig{}.screening_share;
    options.least_score = 0;
    const auto all = search(truth_.linear(), options, with_image);
    ASSERT_GT(all.size(), 60U);
    const auto expectFirst = [&](const std::vector<PoseHypothesis>& found, std::size_t least) {
      ASSERT_GE(found.size(), least);
      EXPECT_GE(found.back().score, options.least_score);
      for (std::size_t i = 0; i < least; ++i) {
        EXPECT_EQ(found[i].score, all[i].score);
        EXPECT_EQ(found[i].votes, all[i].votes);
        EXPECT_TRUE(found[i].T_target_source.matrix() == all[i].T_target_source.matrix());
      }
    };
    for (const std::size_t last : {0, 5, 50}) {
      options.least_score = all[last].score;
      std::size_t count = last;
      while (count < all.size() && all[count].score == all[last].score)
        ++count;
      // Every shift is looked at where those next to it need not promise anything.
      options.config.screening_share = 0;
      const auto exactly = search(truth_.linear(), options, with_image);
      EXPECT_EQ(exactly.size(), count);
      expectFirst(exactly, count);
      options.config.screening_share = SearchConfig{}.screening_share;
      expectFirst(search(truth_.linear(), options, with_image), 1);
    }
  }
}

/// The part of a corridor with bays on one side that is seen from \p x [m]: 6 m each way.
std::vector<testing::Rectangle>
bays(double x)
{
  std::vector<testing::Rectangle> part;
  const double begin = x - 6, end = x + 6;
  part.push_back({{begin, -1.5, -1}, {end - begin, 0, 0}, {0, 3, 0}});
  part.push_back({{begin, -1.5, -1}, {end - begin, 0, 0}, {0, 0, 2.5}});
  // Every bay ends in a pier; they are 3 m apart, but for one wide bay between x = 5 and 10.
  for (const double pier : {-10., -7., -4., -1., 2., 5., 10., 13., 16., 19., 22.})
    if (pier > begin && pier < end)
      part.push_back({{pier, 0.5, -1}, {0, 1, 0}, {0, 0, 2.5}});
  return part;
}

TEST(LittleOverlap, IsFoundThoughFewVoteForIt)
{
  // Two scans of the corridor that share 2 of their 12 m. Laid over one another they meet in floor, wall and some
  // piers.
  const Eigen::Isometry3d T_world_target = testing::sensorPose(Eigen::Vector3d(0, 0, 0.2), 0, 0);
  const Eigen::Isometry3d T_world_source = testing::sensorPose(Eigen::Vector3d(10, 0, 0.2), 0, 0);
  const testing::SearchedScan target = makeScan(bays(0), T_world_target, 1);
  const testing::SearchedScan source = makeScan(bays(10), T_world_source, 2);
  const Eigen::Isometry3d truth = testing::relativePose(T_world_target, T_world_source);
  PoseSearchOptions options;
  options.visibility.free_margin = 0.1f;
  options.pass.refined = 1000;
  const auto nearest = [&] {
    double least = 1e9;
    for (const PoseHypothesis& pose : searchTranslations(source.patches.samples,
                                                         source.votes,
                                                         target.patches.samples,
                                                         target.main_normals,
                                                         target.index,
                                                         &target.image,
                                                         truth.linear(),
                                                         options))
      least = std::min(least, (pose.T_target_source.translation() - truth.translation()).norm());
    return least;
  };
  EXPECT_GT(nearest(), 1);
  options.pass.little_overlap = true;
  EXPECT_LT(nearest(), RefinementConfig().coarse_reach); // from there the refinement finds it
}

TEST_F(PoseSearch, SameForScansMovedFarAway)
{
  const Eigen::Vector3d shift(4096, -2048, 1024); // exact in float
  OrientedSamples moved = target_.patches.samples;
  moved.points.colwise() += shift;
  PlanarPatches patches = target_.patches;
  patches.samples = moved;
  const auto near = search(truth_.linear(), PoseSearchOptions(), false);
  const auto far = searchTranslations(source_.patches.samples,
                                      source_.votes,
                                      moved,
                                      target_.main_normals,
                                      PatchIndex(patches, 0.5),
                                      nullptr,
                                      truth_.linear(),
                                      PoseSearchOptions());
  ASSERT_FALSE(far.empty());
  EXPECT_LT((far[0].T_target_source.translation() - near[0].T_target_source.translation() - shift).norm(), 0.2);
}

TEST_F(PoseSearch, SampleInTheSensorIsNoDirection)
{
  // A vote that falls exactly on the target's viewpoint while the free space is looked at.
  VotingSamples votes = source_.votes;
  votes.points.setZero();
  OrientedSamples wall;
  wall.points = Points3::Zero(3, 1);
  wall.normals = Eigen::Vector3d::UnitX();
  wall.weights = wall.extents = Eigen::VectorXd::Ones(1);
  const auto found = searchTranslations(wall,
                                        votes,
                                        wall,
                                        normals({Eigen::Vector3d::UnitX()}),
                                        target_.index,
                                        &target_.image,
                                        Eigen::Matrix3d::Identity(),
                                        PoseSearchOptions());
  EXPECT_LE(found.size(), 24U);
}

TEST_F(PoseSearch, NothingMoreIsLookedAtWhenTimeHasRunOut)
{
  for (const bool little_overlap : {false, true}) {
    PoseSearchOptions options;
    options.pass.little_overlap = little_overlap;
    EXPECT_FALSE(search(truth_.linear(), options).empty());
    options.deadline = Deadline::after(1e-9);
    EXPECT_TRUE(search(truth_.linear(), options).empty());
  }
}

TEST_F(PoseSearch, EmptyInput)
{
  const OrientedSamples none;
  const PoseSearchOptions options;
  const Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  const OrientedSamples& samples = target_.patches.samples;
  EXPECT_TRUE(searchTranslations(none, VotingSamples(), none, {}, PatchIndex(), nullptr, R, options).empty());
  EXPECT_TRUE(
      searchTranslations(none, VotingSamples(), samples, target_.main_normals, target_.index, nullptr, R, options)
          .empty());
  EXPECT_TRUE(searchTranslations(samples, source_.votes, none, {}, PatchIndex(), nullptr, R, options).empty());
  // No main normals: some axes are tried all the same.
  searchTranslations(samples, target_.votes, samples, {}, target_.index, nullptr, R, options);
  PoseSearchOptions little;
  little.pass.little_overlap = true;
  EXPECT_TRUE(searchTranslations(none, VotingSamples(), none, {}, PatchIndex(), nullptr, R, little).empty());
  EXPECT_TRUE(searchTranslations(samples, VotingSamples(), samples, {}, target_.index, nullptr, R, little).empty());
}

TEST(DrawVotingSamples, EveryDirectionIsHeard)
{
  // 90 equal patches face up, 10 face x, none of the main normals: 1.
  OrientedSamples samples;
  samples.points = Points3::Random(3, 101);
  samples.normals = Eigen::Vector3d::UnitZ().replicate(1, 101);
  for (Eigen::Index i = 40; i < 50; ++i)
    samples.normals.col(i) = Eigen::Vector3d::UnitX();
  samples.normals.col(100) = Eigen::Vector3d(1, 1, 1).normalized();
  samples.weights = samples.extents = Eigen::VectorXd::Ones(101);
  const VotingSamples votes =
      drawVotingSamples(samples, normals({Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()}), 30);
  Eigen::Vector3i voters = Eigen::Vector3i::Zero();
  for (Eigen::Index i = 0; i < votes.points.cols(); ++i) {
    const Eigen::Vector3f n = votes.normals.col(i);
    ++voters[n.z() > 0.9f ? 0 : n.x() > 0.9f ? 1 : 2];
  }
  // Shares of sqrt(90), sqrt(10) and 1 of 30.
  EXPECT_NEAR(voters[0], 21, 1);
  EXPECT_NEAR(voters[1], 7, 1);
  EXPECT_EQ(voters[2], 1); // 2 wanted, there is one
}

TEST(DrawVotingSamples, DrawsMembersOnceAndMoreOftenTheLargeOnes)
{
  const PlanarPatches patches = testing::randomPatches(3000, 5, 1, 3);
  const OrientedSamples& samples = patches.samples;
  const VotingSamples votes = drawVotingSamples(samples, {}, 300);
  EXPECT_NEAR(static_cast<double>(votes.points.cols()), 300, 5);
  double drawn_side = 0;
  Eigen::Index i = 0;
  for (Eigen::Index k = 0; k < votes.points.cols(); ++k, ++i) {
    while (i < samples.size() && samples.points.col(i).cast<float>() != votes.points.col(k))
      ++i;
    ASSERT_LT(i, samples.size()) << "no sample, or out of order, or drawn twice";
    EXPECT_TRUE(samples.normals.col(i).cast<float>() == votes.normals.col(k));
    drawn_side += std::sqrt(samples.weights[i]);
  }
  // With the square root of their area, the side of a square: then the mean side of the drawn is the mean area of all
  // over the mean side of all.
  const double expected = samples.weights.mean() / samples.weights.cwiseSqrt().mean();
  EXPECT_NEAR(drawn_side / static_cast<double>(votes.points.cols()), expected, 0.05 * expected);
}

TEST(DrawRepresentatives, EveryDirectionIsHeard)
{
  // 900 equal patches face up, 100 face east: a quarter of the draws goes to the few, each from its part of the order.
  PlanarPatches patches;
  for (int i = 0; i < 1000; ++i)
    addPatch(patches,
             {{0.1 * i, 0, 0},
              0.5 * (i < 900 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()),
              0.5 * (i < 900 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ())});
  const std::vector<Eigen::Index> drawn =
      drawRepresentatives(patches.samples, normals({Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()}), 100);
  ASSERT_EQ(drawn.size(), 100u);
  for (std::size_t k = 0; k < 75; ++k)
    EXPECT_EQ(drawn[k] / 12, static_cast<Eigen::Index>(k)); // one of every twelve
  for (std::size_t k = 75; k < 100; ++k)
    EXPECT_EQ((drawn[k] - 900) / 4, static_cast<Eigen::Index>(k - 75)); // of every four
}

TEST(DrawRepresentatives, ALargePatchIsDrawnOnce)
{
  PlanarPatches patches;
  addPatch(patches, {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}});
  addPatch(patches, {{20, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}});
  const std::vector<MainNormal> up = normals({Eigen::Vector3d::UnitZ()});
  const std::vector<Eigen::Index> drawn = drawRepresentatives(patches.samples, up, 50);
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 0), 1);
  EXPECT_LE(std::count(drawn.begin(), drawn.end(), 1), 1);
  EXPECT_TRUE(drawRepresentatives(patches.samples, up, 0).empty());
  EXPECT_TRUE(drawRepresentatives(OrientedSamples(), {}, 50).empty());
}

TEST(DrawVotingSamples, Degenerate)
{
  EXPECT_EQ(drawVotingSamples(OrientedSamples(), {}, 100).points.cols(), 0);
  EXPECT_EQ(drawVotingSamples(OrientedSamples(), normals({Eigen::Vector3d::UnitX()}), 100).normals.cols(), 0);
  PlanarPatches one;
  addPatch(one, {Eigen::Vector3d::Constant(1e6), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 1)});
  EXPECT_EQ(drawVotingSamples(one.samples, {}, 100).points.cols(), 1);
  EXPECT_EQ(drawVotingSamples(one.samples, normals({Eigen::Vector3d::UnitX()}), 8).points.cols(), 1);
  PlanarPatches same;
  for (int i = 0; i < 50; ++i)
    addPatch(same, {Eigen::Vector3d::Ones(), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 1)});
  EXPECT_EQ(drawVotingSamples(same.samples, {}, 10).points.cols(), 10);
}

} // namespace
} // namespace pcl_ssfr::test_pose_search
