// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baselines/fast_global_pose.h"
#include "baselines/fpfh_features.h"
#include "pose_matchers.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/baselines/fast_global_registration.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace pcl_ssfr::baselines::test_fast_global_registration {
namespace {

using pcl_ssfr::testing::castScan;
using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeFurnishedRoom;
using pcl_ssfr::testing::makeUnrelatedRooms;
using pcl_ssfr::testing::Random;
using pcl_ssfr::testing::randomMotion;
using pcl_ssfr::testing::relativePose;
using pcl_ssfr::testing::roomScanner;
using pcl_ssfr::testing::Scene;
using pcl_ssfr::testing::sensorPose;
using pcl_ssfr::testing::transformed;
using pcl_ssfr::testing::viewOfPoints;

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kDelta = 0.1; // [m]

Points3
randomPoints(Random& random, Eigen::Index count, double half_size)
{
  Points3 points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      points(k, i) = random.uniform(-half_size, half_size);
  }
  return points;
}

/// Matched point sets of which a share is wrong.
struct MatchedSets {
  Points3 source;
  Points3 target;
  std::vector<PointMatch> matches; ///< the true ones first
  Eigen::Index true_matches = 0;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

MatchedSets
makeMatchedSets(std::uint64_t seed, Eigen::Index count, double outlier_rate, double noise)
{
  Random random(seed);
  MatchedSets sets;
  sets.source = randomPoints(random, count, 5);
  sets.T_target_source = randomMotion(random, 8);
  sets.target = sets.T_target_source * sets.source;
  sets.true_matches = count - static_cast<Eigen::Index>(std::llround(outlier_rate * static_cast<double>(count)));
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i < sets.true_matches)
      sets.target.col(i) += noise * Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
    else
      sets.target.col(i) = sets.T_target_source * randomPoints(random, 1, 5).col(0);
    sets.matches.push_back({i, i});
  }
  return sets;
}

FastGlobalPoseOptions
poseOptions()
{
  FastGlobalPoseOptions options;
  options.distance_threshold = kDelta;
  return options;
}

/// The estimator of equation 3 at mu, written down on its own.
double
gemanMcClure(const MatchedSets& sets, const Eigen::Isometry3d& T, double mu)
{
  double sum = 0;
  for (const PointMatch& match : sets.matches) {
    const double squared = (sets.target.col(match.target) - T * sets.source.col(match.source)).squaredNorm();
    sum += mu * squared / (mu + squared);
  }
  return sum;
}

bool
sameBits(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return a.matrix() == b.matrix();
}

TEST(FastGlobalPose, ExactWithoutNoise)
{
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const MatchedSets sets = makeMatchedSets(seed, 50, 0, 0);
    const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions());
    EXPECT_THAT(pose.T_target_source, IsPoseNear(sets.T_target_source, 1e-7, 1e-7)) << "seed " << seed;
    EXPECT_EQ(pose.inliers, 50U);
    EXPECT_GE(pose.iterations, 4);
  }
}

TEST(FastGlobalPose, AnnealsToDelta)
{
  const MatchedSets sets = makeMatchedSets(1, 200, 0.5, 0.01);
  const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions());
  EXPECT_NEAR(pose.mu, kDelta * kDelta, 1e-9);
  EXPECT_GE(pose.iterations, 64);
  FastGlobalPoseOptions few = poseOptions();
  few.iterations = 8;
  const FastGlobalPose early = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, few);
  EXPECT_EQ(early.iterations, 8);
  EXPECT_GT(early.mu, 100 * pose.mu);
}

// The claim of the paper: most matches may be wrong.
TEST(FastGlobalPose, SurvivesOutliers)
{
  for (const double rate : {0.5, 0.8, 0.9}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const MatchedSets sets = makeMatchedSets(seed, 1000, rate, 0.01);
      const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions());
      EXPECT_THAT(pose.T_target_source, IsPoseNear(sets.T_target_source, 0.1 * kDegree, 0.01))
          << rate << " outliers, seed " << seed;
      EXPECT_GE(pose.inliers, static_cast<std::size_t>(sets.true_matches));
    }
  }
}

// Against the closed form on the true matches, which knows what is to be found out.
TEST(FastGlobalPose, AgreesWithSvdOnInliers)
{
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const MatchedSets sets = makeMatchedSets(seed, 500, 0.7, 0.01);
    const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions());
    const Eigen::Isometry3d closed_form(Eigen::umeyama(
        Points3(sets.source.leftCols(sets.true_matches)), Points3(sets.target.leftCols(sets.true_matches)), false));
    EXPECT_THAT(pose.T_target_source, IsPoseNear(closed_form, 0.02 * kDegree, 0.001)) << "seed " << seed;
    // The robust estimator must not be higher there, nor anywhere around.
    const double mu = kDelta * kDelta;
    const double cost = gemanMcClure(sets, pose.T_target_source, mu);
    EXPECT_NEAR(pose.cost, cost, 1e-9 * cost);
    EXPECT_LE(cost, gemanMcClure(sets, closed_form, mu));
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-1e-4, 1e-4}) {
        Eigen::Isometry3d rotated = pose.T_target_source;
        rotated.prerotate(Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(axis)));
        EXPECT_LT(cost, gemanMcClure(sets, rotated, mu));
        Eigen::Isometry3d shifted = pose.T_target_source;
        shifted.pretranslate(step * Eigen::Vector3d::Unit(axis));
        EXPECT_LT(cost, gemanMcClure(sets, shifted, mu));
      }
    }
  }
}

TEST(FastGlobalPose, FarFromTheOrigin)
{
  MatchedSets sets = makeMatchedSets(3, 200, 0.5, 0);
  const Eigen::Vector3d shift(6e5, 5e6, 100);
  sets.target.colwise() += shift;
  sets.T_target_source.pretranslate(shift);
  const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions());
  EXPECT_THAT(pose.T_target_source, IsPoseNear(sets.T_target_source, 1e-6, 1e-3));
}

TEST(FastGlobalPose, GuessHelpsAndNeverHarms)
{
  // So few are right that the annealing has nothing to hold on to.
  const MatchedSets hopeless = makeMatchedSets(1, 2000, 0.985, 0);
  const FastGlobalPose alone =
      optimizeFastGlobalPose(hopeless.source, hopeless.target, hopeless.matches, poseOptions());
  const Eigen::Isometry3d near_truth = hopeless.T_target_source * Eigen::AngleAxisd(0.005, Eigen::Vector3d::UnitZ());
  const FastGlobalPose guided =
      optimizeFastGlobalPose(hopeless.source, hopeless.target, hopeless.matches, poseOptions(), &near_truth);
  EXPECT_THAT(guided.T_target_source, IsPoseNear(hopeless.T_target_source, 0.1 * kDegree, 0.02));
  EXPECT_LE(guided.cost, alone.cost);

  const MatchedSets easy = makeMatchedSets(2, 500, 0.5, 0.01);
  const Eigen::Isometry3d wrong(Eigen::AngleAxisd(2, Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(
      sameBits(optimizeFastGlobalPose(easy.source, easy.target, easy.matches, poseOptions(), &wrong).T_target_source,
               optimizeFastGlobalPose(easy.source, easy.target, easy.matches, poseOptions()).T_target_source));
}

TEST(FastGlobalPose, DegenerateInput)
{
  const MatchedSets sets = makeMatchedSets(1, 10, 0, 0);
  const FastGlobalPose none = optimizeFastGlobalPose(sets.source, sets.target, {}, poseOptions());
  EXPECT_EQ(none.inliers, 0U);
  EXPECT_TRUE(none.T_target_source.isApprox(Eigen::Isometry3d::Identity()));
  const FastGlobalPose two = optimizeFastGlobalPose(sets.source, sets.target, {{0, 0}, {1, 1}}, poseOptions());
  EXPECT_EQ(two.inliers, 0U);
  EXPECT_EQ(two.matches, 2U);

  // All on one line: a rotation is free, and said to be.
  MatchedSets line = makeMatchedSets(1, 30, 0, 0);
  for (Eigen::Index i = 0; i < 30; ++i)
    line.source.col(i) = Eigen::Vector3d(0.1 * static_cast<double>(i), 0, 0);
  line.target = line.T_target_source * line.source;
  const FastGlobalPose free = optimizeFastGlobalPose(line.source, line.target, line.matches, poseOptions());
  EXPECT_TRUE(pcl_ssfr::testing::isRigid(free.T_target_source));
  EXPECT_EQ(free.inliers, 30U);
  EXPECT_LT(free.inlier_spread, 1e-6);
  EXPECT_GT(optimizeFastGlobalPose(sets.source, sets.target, sets.matches, poseOptions()).inlier_spread, 1);

  // All on one place.
  const Points3 place = Points3::Constant(3, 5, 2.0);
  const FastGlobalPose point = optimizeFastGlobalPose(place, place, {{0, 0}, {1, 1}, {2, 2}, {3, 3}}, poseOptions());
  EXPECT_TRUE(pcl_ssfr::testing::isRigid(point.T_target_source));
}

TEST(FastGlobalPose, DuplicatesCountOnce)
{
  const MatchedSets sets = makeMatchedSets(1, 10, 0, 0);
  std::vector<PointMatch> twice = sets.matches;
  twice.insert(twice.end(), sets.matches.begin(), sets.matches.end());
  const FastGlobalPose pose = optimizeFastGlobalPose(sets.source, sets.target, twice, poseOptions());
  EXPECT_EQ(pose.matches, 10U);
  EXPECT_EQ(pose.inliers, 10U);
}

TEST(FastGlobalPose, RefusesBadArguments)
{
  const MatchedSets sets = makeMatchedSets(1, 10, 0, 0);
  EXPECT_THROW(optimizeFastGlobalPose(sets.source, sets.target, sets.matches, {}), std::invalid_argument);
  EXPECT_THROW(optimizeFastGlobalPose(sets.source, sets.target, {{0, 10}}, poseOptions()), std::invalid_argument);
  EXPECT_THROW(optimizeFastGlobalPose(sets.source, sets.target, {{-1, 0}}, poseOptions()), std::invalid_argument);
}

TEST(TupleTest, KeepsTheOnlyTripleThatAgrees)
{
  // Points on a line at 0, 1, 3, 7, 15; on the other side only the first three keep their distances.
  Points3 source(3, 5);
  source << 0, 1, 3, 7, 15, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0;
  Points3 target = source;
  target(0, 3) = 30;
  target(0, 4) = -100;
  std::vector<PointMatch> matches;
  for (Eigen::Index i = 0; i < 5; ++i)
    matches.push_back({i, i});
  std::vector<PointMatch> kept = tupleTest(source, target, matches, {});
  ASSERT_FALSE(kept.empty());
  EXPECT_EQ(kept.size() % 3, 0U);
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  EXPECT_EQ(kept, (std::vector<PointMatch>{{0, 0}, {1, 1}, {2, 2}}));
}

TEST(TupleTest, EveryTripleAgreesAndOutliersBecomeRarer)
{
  const MatchedSets sets = makeMatchedSets(4, 1000, 0.8, 0.01);
  TupleTestOptions options;
  const std::vector<PointMatch> kept = tupleTest(sets.source, sets.target, sets.matches, options);
  ASSERT_GE(kept.size(), 300U);
  EXPECT_LE(kept.size(), 3 * options.max_tuples);
  std::size_t right = 0;
  for (std::size_t i = 0; i < kept.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const PointMatch& a = kept[i + k];
      const PointMatch& b = kept[i + (k + 1) % 3];
      const double ratio = (sets.source.col(a.source) - sets.source.col(b.source)).norm() /
                           (sets.target.col(a.target) - sets.target.col(b.target)).norm();
      EXPECT_GT(ratio, 0.9);
      EXPECT_LT(ratio, 1 / 0.9);
      right += a.source < sets.true_matches ? 1 : 0;
    }
  }
  EXPECT_GT(static_cast<double>(right) / static_cast<double>(kept.size()), 0.6); // 0.2 before

  EXPECT_EQ(tupleTest(sets.source, sets.target, sets.matches, options), kept);
  options.seed = 2;
  EXPECT_NE(tupleTest(sets.source, sets.target, sets.matches, options), kept);
  options.max_tuples = 7;
  EXPECT_EQ(tupleTest(sets.source, sets.target, sets.matches, options).size(), 21U);
}

TEST(TupleTest, TooFewMatches)
{
  const MatchedSets sets = makeMatchedSets(1, 10, 0, 0);
  EXPECT_TRUE(tupleTest(sets.source, sets.target, {}, {}).empty());
  EXPECT_TRUE(tupleTest(sets.source, sets.target, {{0, 0}, {1, 1}}, {}).empty());
  EXPECT_TRUE(tupleTest(sets.source, sets.target, {{0, 0}, {0, 0}, {0, 0}}, {}).empty());
}

/// Two scans of one apartment, from neighbouring stations, and the pose between them.
struct Scans {
  Eigen::Matrix3Xf source;
  Eigen::Matrix3Xf target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

Scans
makeScans(std::uint64_t seed)
{
  constexpr double kStep = 0.026; // 1.5 degrees
  const Scene scene = makeFurnishedRoom(seed);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(0) + Eigen::Vector3d(0.7, -0.4, 0.1), 1.9, 0.1);
  Scans scans;
  scans.target = castScan(scene, T_world_target, roomScanner(kStep), 11);
  scans.source = castScan(scene, T_world_source, roomScanner(kStep), 12);
  scans.T_target_source = relativePose(T_world_target, T_world_source);
  return scans;
}

FastGlobalOptions
withThreads(unsigned threads)
{
  FastGlobalOptions options;
  options.threads = threads;
  return options;
}

TEST(Fpfh, HistogramsAreComplete)
{
  const Points3 points = makeScans(1).target.leftCols(4000).cast<double>();
  const FpfhFeatures features = computeFpfh(points, Eigen::Vector3d::Zero(), 0.2, 0.5, 1);
  ASSERT_GT(features.columns.size(), 2000U);
  ASSERT_EQ(features.bins.cols(), static_cast<Eigen::Index>(features.columns.size()));
  EXPECT_TRUE(std::is_sorted(features.columns.begin(), features.columns.end()));
  for (Eigen::Index i = 0; i < features.bins.cols(); ++i) {
    for (Eigen::Index part = 0; part < 33; part += 11)
      ASSERT_NEAR(features.bins.col(i).segment(part, 11).sum(), 100, 0.1) << "point " << i;
  }
  const FpfhFeatures again = computeFpfh(points, Eigen::Vector3d::Zero(), 0.2, 0.5, 3);
  EXPECT_EQ(again.columns, features.columns);
  EXPECT_EQ(again.bins, features.bins);
}

TEST(Fpfh, PointsWithoutNeighborsHaveNone)
{
  Points3 points(3, 3);
  points << 0, 100, 200, 0, 0, 0, 0, 0, 0;
  EXPECT_TRUE(computeFpfh(points, Eigen::Vector3d::Zero(), 0.2, 0.5, 1).columns.empty());
  EXPECT_TRUE(computeFpfh(Points3(3, 0), Eigen::Vector3d::Zero(), 0.2, 0.5, 1).columns.empty());
}

TEST(Fpfh, ReciprocalMatchesAgreeWithBruteForce)
{
  Random random(3);
  const auto make = [&](Eigen::Index count) {
    FpfhFeatures features;
    features.bins.resize(33, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      features.columns.push_back(3 * i + 1);
      for (Eigen::Index k = 0; k < 33; ++k)
        features.bins(k, i) = static_cast<float>(random.uniform(0, 30));
    }
    return features;
  };
  const FpfhFeatures source = make(150);
  const FpfhFeatures target = make(120);
  const auto nearest = [](const auto& bin, const FpfhFeatures& features) {
    Eigen::Index best = 0;
    (features.bins.colwise() - bin).colwise().squaredNorm().minCoeff(&best);
    return best;
  };
  std::vector<PointMatch> expected;
  for (Eigen::Index i = 0; i < source.bins.cols(); ++i) {
    const Eigen::Index j = nearest(source.bins.col(i), target);
    if (nearest(target.bins.col(j), source) == i)
      expected.push_back({3 * i + 1, 3 * j + 1});
  }
  ASSERT_GT(expected.size(), 20U);
  EXPECT_EQ(matchReciprocally(source, target, 1), expected);
  EXPECT_EQ(matchReciprocally(source, target, 3), expected);
  EXPECT_TRUE(matchReciprocally(source, make(0), 1).empty());
}

TEST(FastGlobalRegistration, FindsTheMotionOfAMovedCopy)
{
  const Eigen::Matrix3Xf target = makeScans(1).target;
  Random random(5);
  for (int run = 0; run < 2; ++run) {
    const Eigen::Isometry3d T = randomMotion(random, 20);
    Eigen::Matrix3Xf source = transformed(T.inverse(), target);
    ScanView source_view = viewOfPoints(source);
    source_view.viewpoint = T.inverse().translation();
    const BaselineResult result = registerFastGlobal(source_view, viewOfPoints(target), withThreads(1));
    EXPECT_TRUE(result.converged) << result.message;
    // The voxels of the two clouds lie differently in the scene: exact to a part of the leaf.
    EXPECT_THAT(result.T_target_source, IsPoseNear(T, 0.5 * kDegree, 0.3 * result.leaf)) << "run " << run;
    EXPECT_GT(result.overlap, 0.9);
  }
}

TEST(FastGlobalRegistration, AlignsOverlappingScans)
{
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const Scans scans = makeScans(seed);
    const BaselineResult result =
        registerFastGlobal(viewOfPoints(scans.source), viewOfPoints(scans.target), withThreads(1));
    EXPECT_TRUE(result.converged) << result.message;
    EXPECT_THAT(result.T_target_source, IsPoseNear(scans.T_target_source, 2 * kDegree, 0.1)) << "seed " << seed;
    EXPECT_GT(result.inliers, 10U);
    EXPECT_LE(result.inliers, result.correspondences);
    EXPECT_NEAR(result.inlier_distance, 1.5 * result.leaf, 1e-12);
  }
}

TEST(FastGlobalRegistration, SaysWhenScansAreUnrelated)
{
  const auto [first, second] = makeUnrelatedRooms(3);
  const Eigen::Matrix3Xf source = castScan(first, sensorPose(first.stations.at(0), 0.3), roomScanner(0.026), 1);
  const Eigen::Matrix3Xf target = castScan(second, sensorPose(second.stations.at(0), 2), roomScanner(0.026), 2);
  const BaselineResult result = registerFastGlobal(viewOfPoints(source), viewOfPoints(target), withThreads(1));
  EXPECT_FALSE(result.converged) << result.message;
  EXPECT_FALSE(result.message.empty());
}

TEST(FastGlobalRegistration, SameBitsForAnyNumberOfThreads)
{
  const Scans scans = makeScans(1);
  const auto run = [&](unsigned threads) {
    return registerFastGlobal(viewOfPoints(scans.source), viewOfPoints(scans.target), withThreads(threads));
  };
  const BaselineResult one = run(1);
  for (const unsigned threads : {1U, 3U}) {
    const BaselineResult other = run(threads);
    EXPECT_TRUE(sameBits(one.T_target_source, other.T_target_source)) << threads << " threads";
    EXPECT_EQ(one.message, other.message);
  }
}

TEST(FastGlobalRegistration, NothingToWorkWith)
{
  const Eigen::Matrix3Xf scan = makeScans(1).target.leftCols(500);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  Eigen::Matrix3Xf line(3, 200);
  Eigen::Matrix3Xf plane(3, 400);
  for (Eigen::Index i = 0; i < 400; ++i) {
    const Eigen::Index row = i / 20;
    plane.col(i) = Eigen::Vector3f(static_cast<float>(i % 20), static_cast<float>(row), 3);
    if (i < 200)
      line.col(i) = Eigen::Vector3f(static_cast<float>(i), 1, 2);
  }
  const std::vector<std::pair<std::string, Eigen::Matrix3Xf>> clouds = {
      {"empty", Eigen::Matrix3Xf(3, 0)},
      {"one point", Eigen::Matrix3Xf::Constant(3, 1, 1.0F)},
      {"one place", Eigen::Matrix3Xf::Constant(3, 50, 1.0F)},
      {"two points", Eigen::Matrix3Xf(Eigen::Matrix3Xf::Random(3, 2))},
      {"all NaN", Eigen::Matrix3Xf::Constant(3, 50, kNaN)},
      {"line", line},
  };
  for (const auto& [name, cloud] : clouds) {
    for (const bool is_source : {true, false}) {
      const BaselineResult result = registerFastGlobal(
          viewOfPoints(is_source ? cloud : scan), viewOfPoints(is_source ? scan : cloud), withThreads(1));
      EXPECT_FALSE(result.converged) << name << (is_source ? " as source: " : " as target: ") << result.message;
      EXPECT_FALSE(result.message.empty()) << name;
      EXPECT_TRUE(pcl_ssfr::testing::isRigid(result.T_target_source)) << name;
    }
  }
  EXPECT_TRUE(pcl_ssfr::testing::isRigid(
      registerFastGlobal(viewOfPoints(plane), viewOfPoints(plane), withThreads(1)).T_target_source));
}

TEST(FastGlobalRegistration, RefusesOptionsByName)
{
  const Eigen::Matrix3Xf scan = makeScans(1).target.leftCols(500);
  const auto complaint = [&](const FastGlobalOptions& options) -> std::string {
    try {
      registerFastGlobal(viewOfPoints(scan), viewOfPoints(scan), options);
    }
    catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  FastGlobalOptions options;
  options.leaf = -1;
  EXPECT_EQ(complaint(options), "leaf = -1, must be finite and >= 0 [m]");
  options = {};
  options.tuple_similarity = 1.5;
  EXPECT_EQ(complaint(options), "tuple_similarity = 1.5, must be in (0, 1]");
  options = {};
  options.distance_threshold = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint(options), "distance_threshold = nan, must be finite and >= 0 [m]");
}

} // namespace
} // namespace pcl_ssfr::baselines::test_fast_global_registration
