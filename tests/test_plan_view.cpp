// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/angles.h"
#include "patch_scenes.h"
#include "pose_matchers.h"
#include "search/plan_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_plan_view {
namespace {

using testing::addPatch;
using testing::Random;

constexpr int kAll = std::numeric_limits<int>::max();

/// Of patches alone.
PlanView
planViewOf(const OrientedSamples& samples, const Eigen::Vector3d& axis, int most)
{
  return drawPlanView({samples, Eigen::Matrix3Xf()}, axis, most);
}

Eigen::Matrix3Xf
randomPoints(Eigen::Index count, double size, std::uint64_t seed)
{
  Random random(seed);
  Eigen::Matrix3Xf points(3, count);
  for (float& value : points.reshaped())
    value = static_cast<float>(random.uniform(-size, size));
  return points;
}

/// Ground with an upright board at (x, y) that faces \p heading [rad], for each of some numbers (x, y, heading).
PlanarPatches
boardsOnGround(const std::vector<Eigen::Vector3d>& boards)
{
  PlanarPatches patches;
  addPatch(patches, {{0, 0, 0}, {20, 0, 0}, {0, 20, 0}});
  for (const Eigen::Vector3d& b : boards) {
    const Eigen::Vector3d side(-std::sin(b.z()), std::cos(b.z()), 0);
    addPatch(patches, {{b.x(), b.y(), 1}, side, {0, 0, 0.5}});
  }
  return patches;
}

std::vector<Eigen::Vector3d>
randomBoards(int count, double size, std::uint64_t seed)
{
  Random random(seed);
  std::vector<Eigen::Vector3d> boards;
  for (int i = 0; i < count; ++i)
    boards.emplace_back(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-kPi, kPi));
  return boards;
}

OrientedSamples
moved(OrientedSamples samples, const Eigen::Isometry3d& T)
{
  samples.points = T * samples.points;
  samples.normals = T.linear() * samples.normals;
  return samples;
}

TEST(PlanView, HoldsWhatFacesAcrossTheAxis)
{
  const PlanarPatches patches = boardsOnGround({{3, 4, 0.5}});
  const PlanView view = planViewOf(patches.samples, Eigen::Vector3d::UnitZ(), 10);
  ASSERT_EQ(view.elements.size(), 1U); // the ground is left out
  const PlanElement& e = view.elements[0];
  EXPECT_TRUE(view.frame.isUnitary(1e-12));
  EXPECT_NEAR(view.frame.determinant(), 1, 1e-12);
  EXPECT_TRUE((view.frame * Eigen::Vector3d(e.x, e.y, e.height)).isApprox(Eigen::Vector3d(3, 4, 1), 1e-6));
  const Eigen::Vector3d n = view.frame * Eigen::Vector3d(std::cos(e.heading), std::sin(e.heading), 0);
  EXPECT_TRUE(n.isApprox(patches.samples.normals.col(1), 1e-6));
  EXPECT_NEAR(std::pow(e.weight, 4), patches.samples.weights[1], 1e-5);
  // A wall for an axis: the ground faces across it.
  EXPECT_EQ(planViewOf(patches.samples, patches.samples.normals.col(1), 10).elements.size(), 1U);
}

TEST(PlanView, IsDrawnEvenly)
{
  const PlanarPatches patches = boardsOnGround(randomBoards(90, 10, 1));
  const PlanView all = planViewOf(patches.samples, Eigen::Vector3d::UnitZ(), kAll);
  ASSERT_EQ(all.elements.size(), 90U);
  const PlanView some = planViewOf(patches.samples, Eigen::Vector3d::UnitZ(), 30);
  ASSERT_EQ(some.elements.size(), 30U);
  for (std::size_t k = 0; k < 30; ++k)
    EXPECT_EQ(some.elements[k].x, all.elements[3 * k + 1].x); // the middle one of three
}

TEST(PlanView, HoldsPointsThatFitNoPlane)
{
  const OrientedSamples none;
  const Eigen::Matrix3Xf points = randomPoints(90, 10, 2);
  const PlanView all = drawPlanView({none, points}, Eigen::Vector3d(0, 0.6, 0.8), kAll);
  EXPECT_TRUE(all.elements.empty());
  ASSERT_EQ(all.clutter.size(), 90U);
  for (std::size_t i = 0; i < 90; ++i) {
    const Eigen::Vector3d p(all.clutter[i].x, all.clutter[i].y, all.clutter[i].height);
    EXPECT_TRUE((all.frame * p).isApprox(points.col(static_cast<Eigen::Index>(i)).cast<double>(), 1e-5));
  }
  // Half as many as elements, evenly drawn.
  const PlanView some = drawPlanView({none, points}, Eigen::Vector3d(0, 0.6, 0.8), 60);
  ASSERT_EQ(some.clutter.size(), 30U);
  for (std::size_t k = 0; k < 30; ++k)
    EXPECT_EQ(some.clutter[k].x, all.clutter[3 * k + 1].x);
}

/// The score of a square of shifts of two cells, by the definition.
double
scoreByDefinition(const PlanView& source,
                  const PlanView& target,
                  double angle,
                  double offset,
                  const Eigen::Vector2d& shift,
                  const PlanCorrelationOptions& options,
                  bool oriented)
{
  double score = 0;
  const Eigen::Rotation2Dd R(angle);
  const auto sector = [](double heading) {
    return static_cast<int>(std::floor((std::remainder(heading, 2 * kPi) + 4 * kPi) / (kPi / 12)));
  };
  for (const PlanElement& s : source.elements)
    for (const PlanElement& t : target.elements) {
      const Eigen::Vector2d d = Eigen::Vector2d(t.x, t.y) - R * Eigen::Vector2d(s.x, s.y) - shift;
      int sectors = std::abs(sector(s.heading + angle) - sector(t.heading)) % (oriented ? 24 : 12);
      sectors = std::min(sectors, (oriented ? 24 : 12) - sectors);
      if (d.cwiseAbs().maxCoeff() < options.cell && std::abs(t.height - s.height - offset) <= options.height &&
          sectors <= 1)
        score += static_cast<double>(s.weight) * static_cast<double>(t.weight);
    }
  double points = 0;
  for (const PlanPoint& s : source.clutter)
    for (const PlanPoint& t : target.clutter) {
      const Eigen::Vector2d d = Eigen::Vector2d(t.x, t.y) - R * Eigen::Vector2d(s.x, s.y) - shift;
      points += d.cwiseAbs().maxCoeff() < options.cell && std::abs(t.height - s.height - offset) <= options.height;
    }
  return score * (1 + points);
}

TEST(CorrelatedPlanViews, AgreeWithTheDefinition)
{
  Random random(3);
  const PlanarPatches a = testing::randomPatches(150, 9, 1, 5);
  const PlanarPatches b = testing::randomPatches(170, 9, 1, 6);
  const Eigen::Matrix3Xf source_points = randomPoints(60, 9, 7), target_points = randomPoints(70, 9, 8), none;
  for (const auto& [oriented, has_points] : {std::pair(true, false), {false, false}, {true, true}}) {
    PlanView source = drawPlanView({a.samples, has_points ? source_points : none}, Eigen::Vector3d::UnitX(), kAll);
    const PlanView target =
        drawPlanView({b.samples, has_points ? target_points : none}, Eigen::Vector3d(0.6, 0, 0.8), kAll);
    source.oriented = oriented;
    PlanCorrelationOptions options;
    options.cell = 1.3;
    options.height = 1.5;
    options.reach = 6.5;
    const double angle = random.uniform(0, 6), offset = 0.7;
    const std::vector<PlanMatch> matches = correlatePlanViews(source, target, angle, offset, options, kAll);
    ASSERT_GT(matches.size(), 3U);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      EXPECT_NEAR(matches[i].score,
                  scoreByDefinition(source, target, angle, offset, matches[i].shift, options, oriented),
                  1e-3 * matches[i].score);
      EXPECT_TRUE(i == 0 || matches[i - 1].score >= matches[i].score);
    }
    // No other shift has a higher score than the first of them.
    for (int y = -5; y < 5; ++y)
      for (int x = -5; x < 5; ++x)
        EXPECT_LE(
            scoreByDefinition(
                source, target, angle, offset, Eigen::Vector2d(x + 0.5, y + 0.5) * options.cell, options, oriented),
            matches[0].score * (1 + 1e-3));
    const std::vector<PlanMatch> two = correlatePlanViews(source, target, angle, offset, options, 2);
    ASSERT_EQ(two.size(), 2U);
    EXPECT_EQ(two[1].shift, matches[1].shift);
  }
}

TEST(CorrelatedPlanViews, FindAMovedScan)
{
  const OrientedSamples target = boardsOnGround(randomBoards(60, 20, 7)).samples;
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  for (const double angle : {0.0, 1.0, 3.0, 5.5}) {
    // Moved along the ground, and then into a frame of its own.
    Eigen::Isometry3d truth = Eigen::Translation3d(7.3, -4.1, 0) * Eigen::AngleAxisd(angle, axis) *
                              Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
    const OrientedSamples source = moved(target, truth.inverse());
    const Eigen::Vector3d source_axis = truth.linear().transpose() * axis;
    const PlanView from = planViewOf(source, source_axis, kAll);
    const PlanView to = planViewOf(target, axis, kAll);
    PlanMatch best;
    for (int k = 0; k < 90; ++k)
      for (const PlanMatch& match : correlatePlanViews(from, to, k * kPi / 45, 0, PlanCorrelationOptions(), 1))
        if (match.score > best.score)
          best = match;
    EXPECT_THAT(poseOf(from, to, best, 0), testing::IsPoseNear(truth, 0.07, 1.5));
  }
}

TEST(CorrelatedPlanViews, PointsSayWhichOfTwoPlacesAlike)
{
  // Two boards alike, a bush at the second; the source shows one board, and the bush.
  const OrientedSamples target = boardsOnGround({{-5, 0, 0.1}, {5, 0, 0.1}}).samples;
  const OrientedSamples source = boardsOnGround({{0, 0, 0.1}}).samples;
  Eigen::Matrix3Xf bush(3, 2), moved_bush(3, 2);
  bush << 5.5F, 6.2F, 2, 2.3F, 1, 1.5F;
  moved_bush << 0.5F, 1.2F, 2, 2.3F, 1, 1.5F;
  const auto matches = [&](const Eigen::Matrix3Xf& of_target) {
    return correlatePlanViews(drawPlanView({source, moved_bush}, Eigen::Vector3d::UnitZ(), kAll),
                              drawPlanView({target, of_target}, Eigen::Vector3d::UnitZ(), kAll),
                              0,
                              0,
                              PlanCorrelationOptions(),
                              kAll);
  };
  const std::vector<PlanMatch> without = matches(Eigen::Matrix3Xf());
  ASSERT_EQ(without.size(), 2U);
  EXPECT_EQ(without[0].score, without[1].score);
  const std::vector<PlanMatch> with = matches(bush);
  ASSERT_EQ(with.size(), 2U); // points make no match where no element meets
  const Eigen::Vector3d shift = poseOf(drawPlanView({source, moved_bush}, Eigen::Vector3d::UnitZ(), kAll),
                                       drawPlanView({target, bush}, Eigen::Vector3d::UnitZ(), kAll),
                                       with[0],
                                       0)
                                    .translation();
  EXPECT_NEAR(shift.x(), 5, 1);
  EXPECT_GE(with[0].score, 3 * with[1].score * (1 - 1e-5)); // each point with its own at least
}

TEST(CorrelatedPlanViews, SidesCountWhereTheyAreKnown)
{
  const OrientedSamples target = boardsOnGround({{5, 0, 0.1}, {0, 6, 1.4}}).samples;
  OrientedSamples source = target;
  source.normals *= -1;
  const auto best = [&] {
    const auto matches = correlatePlanViews(planViewOf(source, Eigen::Vector3d::UnitZ(), kAll),
                                            planViewOf(target, Eigen::Vector3d::UnitZ(), kAll),
                                            0,
                                            0,
                                            PlanCorrelationOptions(),
                                            1);
    return matches.empty() ? 0 : matches[0].score;
  };
  EXPECT_EQ(best(), 0);
  source.oriented = false;
  EXPECT_NEAR(best(), 2 * std::sqrt(2), 1e-5); // two boards of 2 m^2
}

TEST(CorrelatedPlanViews, PoseMapsWhatMeets)
{
  const PlanView source = planViewOf(OrientedSamples(), Eigen::Vector3d(0, 0.6, 0.8), 1);
  const PlanView target = planViewOf(OrientedSamples(), Eigen::Vector3d::UnitX(), 1);
  PlanMatch match;
  match.angle = 0.4;
  match.shift = {2, -3};
  const Eigen::Isometry3d T = poseOf(source, target, match, 1.5);
  EXPECT_TRUE(testing::isRigid(T, 1e-12));
  EXPECT_TRUE((T.linear() * source.frame.col(2)).isApprox(target.frame.col(2), 1e-12));
  const Eigen::Vector3d seen(5, 6, 7); // from the source, in its plan view
  const Eigen::Vector2d across = Eigen::Rotation2Dd(0.4) * seen.head<2>() + match.shift;
  EXPECT_TRUE((T * (source.frame * seen)).isApprox(target.frame * Eigen::Vector3d(across.x(), across.y(), 8.5), 1e-12));
}

TEST(CorrelatedPlanViews, OfNothingAreNothing)
{
  const PlanView empty = planViewOf(OrientedSamples(), Eigen::Vector3d::UnitZ(), 5);
  EXPECT_TRUE(empty.elements.empty());
  const PlanView one = planViewOf(boardsOnGround({{1, 1, 0}}).samples, Eigen::Vector3d::UnitZ(), 5);
  PlanCorrelationOptions options;
  EXPECT_TRUE(correlatePlanViews(empty, one, 0, 0, options, 5).empty());
  EXPECT_TRUE(correlatePlanViews(one, empty, 0, 0, options, 5).empty());
  EXPECT_TRUE(correlatePlanViews(one, one, 0, 10, options, 5).empty()); // a storey apart
  EXPECT_EQ(correlatePlanViews(one, one, 0, 0, options, 5).size(), 1U);
  options.reach = 1e9; // bounded
  EXPECT_EQ(correlatePlanViews(one, one, 0, 0, options, 5).size(), 1U);
  options.reach = 0;
  EXPECT_TRUE(correlatePlanViews(one, one, 0, 0, options, 5).empty()); // no room for two cells
}

} // namespace
} // namespace pcl_ssfr::test_plan_view
