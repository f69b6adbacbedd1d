// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baselines/go_icp_branch_and_bound.h"
#include "baselines/go_icp_problem.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/baselines/go_icp_core.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ssfr::baselines::test_go_icp {
namespace {

using ::testing::HasSubstr;
using testing::Random;

constexpr double kDegree = M_PI / 180;

Points3
randomPoints(Eigen::Index count, const Eigen::Vector3d& size, std::uint64_t seed)
{
  Random random(seed);
  Points3 points(3, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      points(axis, i) = size[axis] * random.uniform(-1, 1);
  return points;
}

Eigen::Isometry3d
pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

Points3
moved(const Eigen::Isometry3d& T, const Points3& points)
{
  return (T.linear() * points).colwise() + T.translation();
}

double
rotationError(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

/// The error by its definition.
double
naiveError(const Points3& source, const Points3& target, Eigen::Index kept, const Eigen::Isometry3d& T)
{
  std::vector<double> squares;
  for (Eigen::Index i = 0; i < source.cols(); ++i)
    squares.push_back((target.colwise() - T * source.col(i)).colwise().squaredNorm().minCoeff());
  std::sort(squares.begin(), squares.end());
  double sum = 0;
  for (Eigen::Index i = 0; i < kept; ++i)
    sum += squares[static_cast<std::size_t>(i)];
  return sum;
}

/// The points of a view, as the core borrows them.
struct Cloud {
  explicit Cloud(Eigen::Matrix3Xf given) : points(std::move(given)) {}
  ScanView
  view() const
  {
    ScanView result;
    result.xyz = points.data();
    result.size = static_cast<std::size_t>(points.cols());
    return result;
  }
  Eigen::Matrix3Xf points;
};

/// Two scans of the furnished room, the source rotated by a random rotation.
struct RoomPair {
  explicit RoomPair(std::uint64_t seed, int source_station = 0)
  {
    const testing::Scene scene = testing::makeFurnishedRoom(1);
    const auto station = static_cast<std::size_t>(source_station);
    const Eigen::Isometry3d T_world_target = testing::sensorPose(scene.stations.at(0), 0.1);
    const Eigen::Isometry3d T_world_source =
        testing::sensorPose(scene.stations.at(station) + Eigen::Vector3d(0.1, -0.06, 0.02), 0.14, 0.02);
    Random random(seed);
    const Eigen::Isometry3d turn = testing::randomMotion(random, 10);
    constexpr double kStep = 0.035; // 2 degrees: about 13,000 points
    target.points = testing::castScan(scene, T_world_target, testing::roomScanner(kStep), 11);
    source.points =
        testing::transformed(turn, testing::castScan(scene, T_world_source, testing::roomScanner(kStep), 12));
    truth = testing::relativePose(T_world_target, T_world_source) * turn.inverse();
  }
  Cloud source{Eigen::Matrix3Xf()};
  Cloud target{Eigen::Matrix3Xf()};
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
};

GoIcpOptions
quickOptions()
{
  GoIcpOptions options;
  options.source_points = 200;
  options.transform_size = 100;
  return options;
}

TEST(GoIcpProblem, ErrorIsTheTrimmedSumOfSquares)
{
  const Points3 source = randomPoints(50, Eigen::Vector3d(1, 0.8, 0.5), 1);
  const Points3 target = randomPoints(120, Eigen::Vector3d(0.9, 0.9, 0.4), 2);
  for (const double trim : {0.0, 0.3, 0.99}) {
    const GoIcpProblem problem(source, target, trim, 40, 1);
    EXPECT_EQ(problem.kept(), trim < 0.1 ? 50 : (trim < 0.5 ? 35 : 1));
    Random random(4);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Isometry3d T = testing::randomMotion(random, 2);
      const double expected = naiveError(source, target, problem.kept(), T);
      EXPECT_NEAR(problem.error(T), expected, 1e-9 * (1 + expected));
    }
  }
}

TEST(GoIcpProblem, IcpNeverRaisesTheError)
{
  const Points3 target = randomPoints(200, Eigen::Vector3d(1, 0.8, 0.5), 1);
  const Points3 source = randomPoints(60, Eigen::Vector3d(1, 0.8, 0.5), 2);
  Random random(4);
  for (const double trim : {0.0, 0.4}) {
    const GoIcpProblem problem(source, target, trim, 40, 1);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Isometry3d start = testing::randomMotion(random, 0.5);
      Eigen::Isometry3d T = start;
      const double reached = problem.icp(T, 50, 1e-9);
      EXPECT_LT(reached, problem.error(start));
      EXPECT_NEAR(reached, problem.error(T), 1e-9);
      EXPECT_NEAR((T.linear().transpose() * T.linear() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
      EXPECT_GT(T.linear().determinant(), 0);
    }
  }
}

TEST(GoIcpProblem, IcpFollowsASmallMotionToTheEnd)
{
  const Points3 target = randomPoints(100, Eigen::Vector3d(1, 0.8, 0.5), 1);
  const Eigen::Isometry3d truth = pose(angleAxisRotation(Eigen::Vector3d(0.01, -0.02, 0.015)), {0.01, 0.02, -0.01});
  const GoIcpProblem problem(moved(truth.inverse(), target), target, 0, 40, 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_NEAR(problem.icp(T, 50, 1e-9), 0, 1e-20);
  EXPECT_TRUE(T.isApprox(truth, 1e-9));
}

TEST(GoIcpProblem, BoundsAreBounds)
{
  // 0.1 in the third: a target much smaller than the source, most of which is outside the grid.
  const std::vector<Eigen::Vector3d> target_sizes = {{1, 1, 1}, {1, 0.6, 0}, {0.1, 0.02, 0.1}};
  Random random(17);
  double closest = 1; // lower bound against the error, at best
  for (const Eigen::Vector3d& size : target_sizes) {
    const Points3 source = randomPoints(70, Eigen::Vector3d(1, 0.9, 0.5), 5);
    const Points3 target = randomPoints(90, size, 6);
    for (const double trim : {0.0, 0.35}) {
      const GoIcpProblem problem(source, target, trim, 64, 1);
      GoIcpProblem::Scratch scratch;
      for (int i = 0; i < 150; ++i) {
        SearchCube rotations;
        rotations.half = M_PI * std::pow(0.5, random.index(10));
        SearchCube translations;
        translations.half = std::pow(0.5, random.index(10));
        for (int axis = 0; axis < 3; ++axis) {
          rotations.centre[axis] = random.uniform(-M_PI, M_PI);
          translations.centre[axis] = random.uniform(-1, 1);
        }
        const double infinity = std::numeric_limits<double>::infinity();
        const GoIcpProblem::RotatedSource rotated = problem.rotate(rotations, true);
        const GoIcpProblem::RotatedSource certain = problem.rotate(rotations, false);
        const GoIcpProblem::Bounds found =
            problem.bounds(rotated, translations, GoIcpProblem::Centre::AtMost, infinity, scratch);
        const double lower = found.lower;
        const double of_rotation =
            problem.bounds(certain, translations, GoIcpProblem::Centre::Likely, infinity, scratch).lower;
        const double exact = problem.exactBounds(rotated, translations, infinity, scratch).lower;
        EXPECT_LE(lower, exact + 1e-9); // what the distance transform costs
        EXPECT_LE(lower, of_rotation);
        double least = infinity;
        for (int k = 0; k < 12; ++k) {
          // Corners are the poses farthest from the centre.
          Eigen::Vector3d r = Eigen::Vector3d::Zero();
          Eigen::Vector3d t = Eigen::Vector3d::Zero();
          for (int axis = 0; axis < 3; ++axis) {
            r[axis] = k < 8 ? ((k >> axis & 1) != 0 ? 1 : -1) : random.uniform(-1, 1);
            t[axis] = k < 8 ? (random.index(2) != 0 ? 1 : -1) : random.uniform(-1, 1);
          }
          const Eigen::Vector3d translation = translations.centre + translations.half * t;
          const double error =
              problem.error(pose(angleAxisRotation(rotations.centre + rotations.half * r), translation));
          ASSERT_LE(lower, error) << "cubes of " << rotations.half << " rad, " << translations.half;
          ASSERT_LE(exact, error);
          ASSERT_LE(of_rotation, problem.error(pose(angleAxisRotation(rotations.centre), translation)));
          least = std::min(least, error);
        }
        closest = std::min(closest, (least - lower) / least);
      }
    }
  }
  EXPECT_LT(closest, 0.1); // of fine cubes they are close bounds
}

TEST(GoIcpProblem, StoppingEarlyDoesNotChangeTheDecision)
{
  const GoIcpProblem problem(
      randomPoints(200, Eigen::Vector3d(1, 1, 1), 5), randomPoints(90, Eigen::Vector3d(1, 1, 0), 6), 0, 64, 1);
  GoIcpProblem::Scratch scratch;
  const GoIcpProblem::RotatedSource rotated = problem.rotate({Eigen::Vector3d(0.3, 0.1, 1), 0.01}, true);
  const SearchCube translations{Eigen::Vector3d(0.1, 0, 0), 0.01};
  const double full = problem.bounds(rotated, translations, GoIcpProblem::Centre::AtMost, 1e9, scratch).lower;
  ASSERT_GT(full, 0);
  for (const double share : {0.01, 0.5, 0.999}) {
    const double early =
        problem.bounds(rotated, translations, GoIcpProblem::Centre::AtMost, share * full, scratch).lower;
    EXPECT_GT(early, share * full);
    EXPECT_LE(early, full);
    const double exact = problem.exactBounds(rotated, translations, share * full, scratch).lower;
    EXPECT_GT(exact, share * full);
  }
}

TEST(GoIcpSearchCube, ChildrenTileTheirParent)
{
  const SearchCube parent{Eigen::Vector3d(1, 2, 3), 0.5};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const SearchCube child = childOf(parent, c);
    EXPECT_EQ(child.half, 0.25);
    EXPECT_TRUE((child.centre - parent.centre).cwiseAbs().isApprox(Eigen::Vector3d::Constant(0.25)));
    sum += child.centre;
  }
  EXPECT_TRUE((sum / 8).isApprox(parent.centre));
}

/// The least error that ICP reaches from a grid of starts over the whole domain.
double
exhaustiveSearch(const GoIcpProblem& problem, double range, int rotation_steps, int translation_steps)
{
  double best = std::numeric_limits<double>::infinity();
  const double r = 2 * M_PI / rotation_steps;
  const double t = 2 * range / translation_steps;
  const auto grid = [](int i, double step, double low) { return low + step * (i + 0.5); };
  for (int i = 0; i < rotation_steps * rotation_steps * rotation_steps; ++i) {
    const Eigen::Vector3d v(grid(i % rotation_steps, r, -M_PI),
                            grid(i / rotation_steps % rotation_steps, r, -M_PI),
                            grid(i / rotation_steps / rotation_steps, r, -M_PI));
    if (v.norm() > M_PI + r)
      continue;
    for (int k = 0; k < translation_steps * translation_steps * translation_steps; ++k) {
      Eigen::Isometry3d T = pose(angleAxisRotation(v),
                                 {grid(k % translation_steps, t, -range),
                                  grid(k / translation_steps % translation_steps, t, -range),
                                  grid(k / translation_steps / translation_steps, t, -range)});
      best = std::min(best, problem.icp(T, 30, 1e-6));
    }
  }
  return best;
}

TEST(GoIcp, IsAsGoodAsExhaustiveSearch)
{
  // Clouds that have nothing to do with each other: many local minima, and an optimum far from 0.
  constexpr double kRange = 0.15;
  for (const std::uint64_t seed : {3U, 5U}) {
    const Points3 target = randomPoints(8, Eigen::Vector3d(0.7, 0.6, 0.5), seed);
    const Points3 source = randomPoints(6, Eigen::Vector3d(0.45, 0.45, 0.35), seed + 100);
    const GoIcpProblem problem(source, target, seed == 3 ? 0.2 : 0.0, 200, 1);
    GoIcpLimits limits;
    limits.tolerance = 0.008 * static_cast<double>(problem.kept());
    limits.translation_range = kRange;
    limits.nodes = 20'000'000; // never reached, unless something is wrong
    const double exhaustive = exhaustiveSearch(problem, kRange, 12, 2);
    // Several starts: the same optimum.
    Random random(seed);
    double first = 0;
    for (int start = 0; start < 3; ++start) {
      std::vector<Eigen::Isometry3d> starts;
      if (start > 0)
        starts.push_back(testing::randomMotion(random, kRange));
      const GoIcpOptimum optimum = branchAndBound(problem, starts, limits, 1);
      ASSERT_EQ(optimum.stop, GoIcpOptimum::Stop::Certified);
      EXPECT_LE(optimum.error, exhaustive + limits.tolerance);
      EXPECT_LE(optimum.lower, exhaustive + 1e-9); // the proven bound is true
      EXPECT_LE(optimum.error - optimum.lower, limits.tolerance + 1e-12);
      EXPECT_NEAR(problem.error(optimum.T), optimum.error, 1e-9);
      first = start == 0 ? optimum.error : first;
      EXPECT_NEAR(optimum.error, first, limits.tolerance);
    }
    EXPECT_GT(exhaustive, limits.tolerance); // else the test could not fail
  }
}

TEST(GoIcp, RecoversAnyRotationOfACloud)
{
  Random random(8);
  for (int i = 0; i < 4; ++i) {
    Cloud target(randomPoints(300, Eigen::Vector3d(4, 3, 1), 20 + static_cast<std::uint64_t>(i)).cast<float>());
    const Eigen::Isometry3d truth = testing::randomMotion(random, 30);
    const Cloud source(testing::transformed(truth.inverse(), target.points));
    GoIcpOptions options = quickOptions();
    options.source_points = 300;
    GoIcpReport report;
    const BaselineResult result = registerGoIcp(source.view(), target.view(), options, std::nullopt, &report);
    EXPECT_TRUE(result.converged) << result.message;
    EXPECT_LT(rotationError(result.T_target_source, truth), 1e-4);
    EXPECT_LT((result.T_target_source.translation() - truth.translation()).norm(), 1e-3);
    EXPECT_LT(report.error, 1e-8);
    EXPECT_EQ(result.source_points, 300U);
    EXPECT_EQ(result.leaf, 0);
    EXPECT_DOUBLE_EQ(result.overlap, 1);
  }
}

TEST(GoIcp, SolvesScansOfARoomFromAnyRotation)
{
  for (const std::uint64_t seed : {1U, 2U}) {
    const RoomPair pair(seed);
    GoIcpReport report;
    const GoIcpOptions options = quickOptions();
    const BaselineResult result = registerGoIcp(pair.source.view(), pair.target.view(), options, std::nullopt, &report);
    ASSERT_TRUE(result.converged) << result.message;
    EXPECT_LT(rotationError(result.T_target_source, pair.truth), 1 * kDegree);
    EXPECT_LT((result.T_target_source * pair.truth.inverse() * Eigen::Vector3d::Zero()).norm(), 0.1);
    EXPECT_TRUE(report.certified);
    EXPECT_LE(report.gap, report.tolerance);
    EXPECT_LE(result.source_points, 200U);
    EXPECT_GT(result.source_points, 100U);
    EXPECT_GT(report.nodes, report.rotations);
    EXPECT_GT(report.icp_runs, 0);
    EXPECT_GT(report.seconds, report.transform_seconds);
    EXPECT_THAT(result.message, HasSubstr("global optimum"));
  }
}

TEST(GoIcp, TrimmingTakesAwayWhatHasNoCounterpart)
{
  // A third of the source lies where the target has nothing.
  Points3 target = randomPoints(200, Eigen::Vector3d(1, 0.8, 0.4), 3);
  Points3 source(3, 150);
  source.leftCols(100) = target.leftCols(100);
  source.rightCols(50) = randomPoints(50, Eigen::Vector3d(0.3, 0.3, 0.4), 4).colwise() + Eigen::Vector3d(1.4, 0, 0);
  Random random(5);
  const Eigen::Isometry3d truth = testing::randomMotion(random, 3);
  const Cloud moved_source(moved(truth.inverse(), source).cast<float>());
  const Cloud fixed(target.cast<float>());
  GoIcpOptions options = quickOptions();
  options.source_points = 300;
  options.trim_fraction = 0.34;
  GoIcpReport report;
  const BaselineResult trimmed = registerGoIcp(moved_source.view(), fixed.view(), options, std::nullopt, &report);
  ASSERT_TRUE(trimmed.converged) << trimmed.message;
  EXPECT_EQ(report.kept, 99U);
  EXPECT_LT(rotationError(trimmed.T_target_source, truth), 0.01 * kDegree);
  EXPECT_LT(report.error, 1e-8);
  // Without it, the optimum is another one: the outliers pull.
  const GoIcpProblem all(moved(truth.inverse(), source), target, 0, 64, 1);
  Eigen::Isometry3d T = truth;
  EXPECT_LT(all.icp(T, 50, 1e-9), 0.9 * all.error(truth));
  EXPECT_GT(rotationError(T, truth) + (T.translation() - truth.translation()).norm(), 1e-3);
}

TEST(GoIcp, SameBitsForAnyNumberOfThreads)
{
  const RoomPair pair(3, 1);
  GoIcpOptions options = quickOptions();
  options.mse_threshold = 1e-4;
  options.node_limit = 150'000;
  GoIcpReport one_report;
  const BaselineResult one = registerGoIcp(pair.source.view(), pair.target.view(), options, std::nullopt, &one_report);
  for (const unsigned threads : {2U, 8U}) {
    options.threads = threads;
    GoIcpReport report;
    const BaselineResult result = registerGoIcp(pair.source.view(), pair.target.view(), options, std::nullopt, &report);
    EXPECT_TRUE(result.T_target_source.matrix() == one.T_target_source.matrix());
    EXPECT_EQ(result.message, one.message);
    EXPECT_EQ(report.nodes, one_report.nodes);
    EXPECT_EQ(report.rotations, one_report.rotations);
    EXPECT_EQ(report.gap, one_report.gap);
    EXPECT_EQ(report.error, one_report.error);
  }
}

TEST(GoIcp, AGuessIsOneMoreStart)
{
  const RoomPair pair(4, 1);
  GoIcpOptions options = quickOptions();
  options.node_limit = 1; // nothing but the first ICP runs and one look at the first cubes
  options.trim_fraction = 0.3;
  GoIcpReport with, without;
  const BaselineResult guided = registerGoIcp(pair.source.view(), pair.target.view(), options, pair.truth, &with);
  registerGoIcp(pair.source.view(), pair.target.view(), options, std::nullopt, &without);
  EXPECT_LE(with.error, without.error);
  EXPECT_LT(rotationError(guided.T_target_source, pair.truth), 3 * kDegree);
}

TEST(GoIcp, LimitsAreHonouredAndTold)
{
  // Nothing fits: the certificate takes long.
  const Cloud source(randomPoints(400, Eigen::Vector3d(3, 2, 1), 1).cast<float>());
  const Cloud target(randomPoints(200, Eigen::Vector3d(2, 2, 2), 2).cast<float>());
  GoIcpOptions options = quickOptions();
  options.source_points = 400;
  options.mse_threshold = 1e-5;
  options.time_limit = 0.5;
  const auto start = std::chrono::steady_clock::now();
  GoIcpReport report;
  BaselineResult result = registerGoIcp(source.view(), target.view(), options, std::nullopt, &report);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_FALSE(result.converged);
  EXPECT_FALSE(report.certified);
  EXPECT_LT(seconds, 30); // 0.5 s and a loaded machine
  EXPECT_GE(report.seconds, 0.5);
  EXPECT_THAT(result.message, HasSubstr("cut off by the time limit of 0.5 s"));
  EXPECT_THAT(result.message, HasSubstr("certified gap"));
  EXPECT_GT(report.gap, report.tolerance);
  EXPECT_LE(report.gap, report.error);
  EXPECT_TRUE(result.T_target_source.matrix().allFinite());

  options.time_limit_clock = TimeLimitClock::Processor;
  const std::clock_t before = std::clock();
  result = registerGoIcp(source.view(), target.view(), options, std::nullopt, &report);
  const double processor_seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  EXPECT_FALSE(result.converged);
  EXPECT_THAT(result.message, HasSubstr("cut off by the time limit of 0.5 s of processor time"));
  EXPECT_GE(processor_seconds, 0.5);
  EXPECT_LT(processor_seconds, 2); // however loaded the machine is

  options.time_limit = 0;
  options.node_limit = 20'000;
  result = registerGoIcp(source.view(), target.view(), options, std::nullopt, &report);
  EXPECT_FALSE(result.converged);
  EXPECT_THAT(result.message, HasSubstr("cut off by the limit of 20000 nodes"));
  EXPECT_GE(report.nodes, 20'000U);
  EXPECT_LT(report.nodes, 40'000U);
}

TEST(GoIcp, TheGapShrinksWithTheNodes)
{
  const Cloud source(randomPoints(40, Eigen::Vector3d(3, 2, 1), 1).cast<float>());
  const Cloud target(randomPoints(30, Eigen::Vector3d(2, 2, 2), 2).cast<float>());
  GoIcpOptions options = quickOptions();
  options.mse_threshold = 1e-5;
  double last = std::numeric_limits<double>::infinity();
  for (const std::uint64_t nodes : {1'000U, 30'000U, 1'000'000U}) {
    options.node_limit = nodes;
    GoIcpReport report;
    registerGoIcp(source.view(), target.view(), options, std::nullopt, &report);
    EXPECT_LE(report.gap, last);
    last = report.gap;
  }
}

TEST(GoIcp, NonFinitePointsAreSkipped)
{
  const Cloud clean(randomPoints(100, Eigen::Vector3d(4, 3, 1), 1).cast<float>());
  Eigen::Matrix3Xf dirty(3, 103);
  dirty.leftCols(100) = clean.points;
  dirty.rightCols(3).setZero();
  dirty(0, 100) = std::numeric_limits<float>::quiet_NaN();
  dirty(1, 101) = std::numeric_limits<float>::infinity();
  dirty(2, 102) = -std::numeric_limits<float>::infinity();
  const Cloud cloud(dirty);
  const BaselineResult a = registerGoIcp(clean.view(), clean.view(), quickOptions());
  const BaselineResult b = registerGoIcp(cloud.view(), cloud.view(), quickOptions());
  EXPECT_TRUE(a.converged);
  EXPECT_TRUE(b.converged);
  EXPECT_EQ(b.source_points, 100U);
  EXPECT_TRUE(a.T_target_source.matrix() == b.T_target_source.matrix());
}

TEST(GoIcp, CloudsWithoutAnAnswer)
{
  const Cloud good(randomPoints(50, Eigen::Vector3d(4, 3, 1), 1).cast<float>());
  const Cloud empty(Eigen::Matrix3Xf(3, 0));
  const Cloud two(randomPoints(2, Eigen::Vector3d(4, 3, 1), 1).cast<float>());
  const Cloud nan(Eigen::Matrix3Xf::Constant(3, 20, std::numeric_limits<float>::quiet_NaN()));
  const Cloud same(Eigen::Matrix3Xf::Constant(3, 5000, 1.5F));
  Eigen::Matrix3Xf on_line = Eigen::Matrix3Xf::Zero(3, 30);
  for (int i = 0; i < 30; ++i)
    on_line(0, i) = static_cast<float>(i);
  const Cloud line(on_line);
  for (const Cloud* bad : {&empty, &two, &nan, &same, &line}) {
    const BaselineResult as_source = registerGoIcp(bad->view(), good.view(), quickOptions());
    EXPECT_FALSE(as_source.converged);
    EXPECT_THAT(as_source.message, HasSubstr("source"));
    const BaselineResult as_target = registerGoIcp(good.view(), bad->view(), quickOptions());
    EXPECT_FALSE(as_target.converged);
    EXPECT_THAT(as_target.message, HasSubstr("target"));
  }
  // Three points are enough for an answer.
  const Cloud three(randomPoints(3, Eigen::Vector3d(4, 3, 1), 1).cast<float>());
  EXPECT_TRUE(registerGoIcp(three.view(), three.view(), quickOptions()).converged);
}

TEST(GoIcp, PlacesFarFromTheOrigin)
{
  const Eigen::Vector3f offset(40000, -30000, 500); // floats there resolve 4 mm
  Eigen::Matrix3Xf points = randomPoints(200, Eigen::Vector3d(4, 3, 1), 1).cast<float>();
  const Cloud source(points);
  const Cloud target(points.colwise() + offset);
  const BaselineResult result = registerGoIcp(source.view(), target.view(), quickOptions());
  ASSERT_TRUE(result.converged) << result.message;
  EXPECT_LT((result.T_target_source.translation() - offset.cast<double>()).norm(), 0.01);
}

TEST(GoIcp, BadOptionsAreNamed)
{
  const Cloud cloud(randomPoints(50, Eigen::Vector3d(4, 3, 1), 1).cast<float>());
  const auto complaint = [&](const GoIcpOptions& options) {
    try {
      registerGoIcp(cloud.view(), cloud.view(), options);
    }
    catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GoIcpOptions options;
  options.source_points = 2;
  EXPECT_EQ(complaint(options), "source_points = 2, must be 3 or more");
  options = GoIcpOptions();
  options.trim_fraction = 1;
  EXPECT_THAT(complaint(options), HasSubstr("trim_fraction = 1"));
  options = GoIcpOptions();
  options.mse_threshold = 0;
  EXPECT_THAT(complaint(options), HasSubstr("mse_threshold = 0"));
  options = GoIcpOptions();
  options.translation_range = nan;
  EXPECT_THAT(complaint(options), HasSubstr("translation_range = nan"));
  options = GoIcpOptions();
  options.transform_size = 1000;
  EXPECT_THAT(complaint(options), HasSubstr("transform_size = 1e+03"));
  options = GoIcpOptions();
  options.icp_iterations = -1;
  EXPECT_THAT(complaint(options), HasSubstr("icp_iterations = -1"));
  options = GoIcpOptions();
  options.inlier_distance = -1;
  EXPECT_THAT(complaint(options), HasSubstr("inlier_distance = -1"));
  options = GoIcpOptions();
  options.time_limit = nan;
  EXPECT_THAT(complaint(options), HasSubstr("time_limit = nan"));
  options = GoIcpOptions();
  options.threads = 0;
  EXPECT_THAT(complaint(options), HasSubstr("threads = 0"));
}

} // namespace
} // namespace pcl_ssfr::baselines::test_go_icp
