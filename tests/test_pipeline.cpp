// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The default profile from end to end, on simulated scenes with exact ground truth.

#include "common/rotation_math.h"
#include "pose_matchers.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/pipeline.h>

#include <Eigen/Eigenvalues>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace pcl_ssfr::test_pipeline {
namespace {

using namespace pcl_ssfr::testing;

constexpr double kDegree = 0.017453292519943295;

/// Two scans of a scene and the truth between them.
struct Pair {
  Eigen::Matrix3Xf source, target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

Pair
scanPair(const Scene& scene, std::size_t a, std::size_t b, const SensorPattern& pattern, std::uint64_t seed)
{
  Random random(seed);
  Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(a), 0);
  T_world_source.linear() = randomRotation(random);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(b), random.uniform(0, 6.28), 0.1);
  return {castScan(scene, T_world_source, pattern, 2 * seed),
          castScan(scene, T_world_target, pattern, 2 * seed + 1),
          relativePose(T_world_target, T_world_source)};
}

Result
registerPair(const Pair& pair,
             Options options = makeOptions(Profile::Default),
             const Eigen::Isometry3d* guess = nullptr)
{
  if (options.threads == 1)
    options.threads = 2;
  return registerScans(
      prepareScan(viewOfPoints(pair.source), options), prepareScan(viewOfPoints(pair.target), options), options, guess);
}

// ---- recovery

class Recovers : public ::testing::TestWithParam<int> {};

TEST_P(Recovers, roomsFromAnyOrientation)
{
  const Pair pair = scanPair(makeFurnishedRoom(static_cast<std::uint64_t>(GetParam())), 0, 1, roomScanner(), 11);
  const Result result = registerPair(pair);
  EXPECT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005));
  EXPECT_GT(result.confidence, 0.9);
  EXPECT_GT(result.overlap, 0.6);
  EXPECT_LT(result.contradiction, 0.02);
  EXPECT_TRUE(result.source_viewpoint_used && result.target_viewpoint_used);
}

TEST_P(Recovers, hallsAndStreets)
{
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Pair hall = scanPair(makeHall(seed), 0, 1, terrestrialScanner(0.0175), 21);
  EXPECT_THAT(registerPair(hall).T_target_source, IsPoseNear(hall.T_target_source, 0.1 * kDegree, 0.01));
  const Pair street = scanPair(makeStreet(seed), 1, 2, vehicleScanner(), 22);
  EXPECT_THAT(registerPair(street).T_target_source, IsPoseNear(street.T_target_source, 0.2 * kDegree, 0.03));
}

TEST_P(Recovers, aScanTakenAgainFromTheSamePlace)
{
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const Scene scene = makeFurnishedRoom(seed);
  for (const SensorPattern& pattern : {roomScanner(), vehicleScanner()}) {
    const Pair pair = scanPair(scene, 0, 0, pattern, 23 + seed);
    ASSERT_LT(pair.T_target_source.translation().norm(), 0.05);
    const Result result = registerPair(pair);
    EXPECT_EQ(result.status, Status::Converged) << result.message;
    EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.2 * kDegree, 0.02));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Recovers, ::testing::Values(1, 2, 3));

// ---- laws

TEST(Pipeline, isEquivariant)
{
  // Moving both clouds, and where the sensor is, moves the answer along: f(A s, B t) = B f(s, t) A^-1.
  const Pair pair = scanPair(makeFurnishedRoom(4), 0, 1, roomScanner(), 31);
  Random random(5);
  const Eigen::Isometry3d A = randomMotion(random, 100), B = randomMotion(random, 100);
  const Eigen::Matrix3Xf source = transformed(A, pair.source), target = transformed(B, pair.target);
  ScanView s = viewOfPoints(source), t = viewOfPoints(target);
  s.viewpoint = A.translation();
  t.viewpoint = B.translation();
  s.viewpoint_is_known = t.viewpoint_is_known = true;
  const Options options = makeOptions(Profile::Default);
  const Result result = registerScans(prepareScan(s, options), prepareScan(t, options), options);
  EXPECT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(B.inverse() * result.T_target_source * A, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005));
}

TEST(Pipeline, swappingTheScansInvertsTheAnswer)
{
  const Pair pair = scanPair(makeFurnishedRoom(5), 0, 1, roomScanner(), 41);
  const Result there = registerPair(pair);
  const Result back = registerPair({pair.target, pair.source, pair.T_target_source.inverse()});
  EXPECT_THAT(back.T_target_source.inverse(), IsPoseNear(there.T_target_source, 0.05 * kDegree, 0.003));
}

TEST(Pipeline, sameBitsForAnyNumberOfThreadsAndAnyOrderOfRuns)
{
  const Pair pair = scanPair(makeHall(3), 1, 2, terrestrialScanner(0.0175), 51);
  Options options = makeOptions(Profile::Default);
  std::vector<double> first;
  for (const unsigned threads : {1u, 2u, 8u, 1u}) {
    options.threads = threads;
    const Result r = registerScans(
        prepareScan(viewOfPoints(pair.source), options), prepareScan(viewOfPoints(pair.target), options), options);
    std::vector<double> numbers(r.T_target_source.data(), r.T_target_source.data() + 16);
    numbers.insert(numbers.end(), r.information.data(), r.information.data() + 36);
    numbers.insert(numbers.end(), {r.confidence, r.overlap, r.contradiction, r.rmse});
    for (const Candidate& c : r.candidates)
      numbers.insert(numbers.end(), c.T_target_source.data(), c.T_target_source.data() + 16);
    if (first.empty())
      first = numbers;
    ASSERT_EQ(numbers.size(), first.size());
    EXPECT_EQ(std::memcmp(numbers.data(), first.data(), first.size() * sizeof(double)), 0) << threads << " threads";
  }
}

TEST(Pipeline, aPreparedScanServesManyPartners)
{
  const Scene scene = makeFurnishedRoom(6);
  const Pair a = scanPair(scene, 0, 1, roomScanner(), 61);
  const Options options = makeOptions(Profile::Default);
  const PreparedScan target = prepareScan(viewOfPoints(a.target), options);
  const PreparedScan source = prepareScan(viewOfPoints(a.source), options);
  const Result once = registerScans(source, target, options);
  const Result itself = registerScans(target, target, options);
  const Result again = registerScans(source, target, options);
  EXPECT_EQ(once.T_target_source.matrix(), again.T_target_source.matrix());
  EXPECT_THAT(itself.T_target_source, IsPoseNear(Eigen::Isometry3d::Identity(), 1e-3, 1e-3));
}

TEST(Pipeline, scansPreparedTogetherAreThoseOfPrepareScan)
{
  const Pair pair = scanPair(makeFurnishedRoom(7), 0, 1, roomScanner(), 62);
  for (const Profile profile : {Profile::Default, Profile::Paper2017}) {
    Options options = makeOptions(profile);
    const Result alone = registerScans(
        prepareScan(viewOfPoints(pair.source), options), prepareScan(viewOfPoints(pair.target), options), options);
    for (const unsigned threads : {1u, 2u, 7u}) {
      options.threads = threads;
      const auto [source, target] = prepareScans(viewOfPoints(pair.source), viewOfPoints(pair.target), options);
      const Result together = registerScans(source, target, options);
      EXPECT_EQ(together.T_target_source.matrix(), alone.T_target_source.matrix()) << threads << " threads";
      EXPECT_EQ(together.confidence, alone.confidence);
    }
  }
  Options wrong = makeOptions(Profile::Default);
  wrong.leaf = -1;
  EXPECT_THROW(prepareScans(viewOfPoints(pair.source), viewOfPoints(pair.target), wrong), std::invalid_argument);
}

// ---- honesty

TEST(Honest, aSymmetricRoomIsAmbiguousAndBothAnswersAreListed)
{
  const Pair pair = scanPair(makeSymmetricRoom(), 0, 1, roomScanner(), 71);
  const Result result = registerPair(pair);
  EXPECT_EQ(result.status, Status::Ambiguous) << result.message;
  // The truth is one of the two, and which of them stays open.
  ASSERT_GE(result.candidates.size(), 2u);
  EXPECT_EQ(result.confidence, result.candidates[0].probability);
  EXPECT_LT(result.candidates[0].probability, 2 * result.candidates[1].probability);
  EXPECT_GT(result.candidates[0].probability + result.candidates[1].probability, 0.9);
  // Rotated by half a turn about the room's middle, the sensor comes to lie elsewhere.
  EXPECT_THAT(result.message, ::testing::HasSubstr("the strongest rival lies "));
  EXPECT_THAT(result.message, ::testing::HasSubstr(" m and 180.0 degrees away"));
  ASSERT_GE(result.candidates.size(), 2u);
  bool listed = false;
  for (std::size_t i = 0; i < 2; ++i)
    listed = listed || poseError(result.candidates[i].T_target_source, pair.T_target_source).rotation < kDegree;
  EXPECT_TRUE(listed) << "the truth is not among the two best";
}

TEST(Honest, aGuessBreaksTheTieOfASymmetricRoom)
{
  const Pair pair = scanPair(makeSymmetricRoom(), 0, 1, roomScanner(), 72);
  Random random(9);
  const Eigen::Isometry3d guess =
      pair.T_target_source * Eigen::Translation3d(0.2, -0.1, 0.1) * Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ());
  const Result result = registerPair(pair, makeOptions(Profile::Default), &guess);
  EXPECT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.2 * kDegree, 0.01));
}

TEST(Honest, aWrongGuessDoesNotDegradeTheAnswer)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 73);
  Random random(10);
  const Eigen::Isometry3d guess = randomMotion(random, 5);
  const Result result = registerPair(pair, makeOptions(Profile::Default), &guess);
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005));
}

Pair
corridorPair()
{
  const Scene corridor = makeEndlessCorridor();
  const Eigen::Isometry3d T_world_target = sensorPose(corridor.stations.at(1), 0.3, 0);
  const Eigen::Isometry3d T_world_source = sensorPose(corridor.stations.at(0), 1.3, 0);
  return {castScan(corridor, T_world_source, roomScanner(), 1),
          castScan(corridor, T_world_target, roomScanner(), 2),
          relativePose(T_world_target, T_world_source)};
}

TEST(Honest, aCorridorWithoutAnEndNamesItsDirection)
{
  const Scene corridor = makeEndlessCorridor();
  const Eigen::Isometry3d T_world_target = sensorPose(corridor.stations.at(1), 0.3, 0);
  const Result result = registerPair(corridorPair());
  EXPECT_EQ(result.status, Status::Unobservable) << result.message;
  EXPECT_LT(result.confidence, 0.5);
  ASSERT_FALSE(result.unobservable.empty());
  EXPECT_FALSE(result.unobservable.front().rotation);
  // The corridor runs along the direction in which its stations differ.
  const Eigen::Vector3d along =
      T_world_target.linear().transpose() * (corridor.stations.at(1) - corridor.stations.at(0)).normalized();
  EXPECT_GT(std::abs(result.unobservable.front().direction.dot(along)), 0.98);
}

TEST(Honest, onePlaneHasTooFewDirections)
{
  const Result result = registerPair(scanPair(makeSinglePlane(), 0, 1, roomScanner(), 74));
  EXPECT_EQ(result.status, Status::TooFewDirections) << result.message;
  EXPECT_FALSE(result.accepted());
}

TEST(Honest, aSphereIsNotAccepted)
{
  EXPECT_FALSE(registerPair(scanPair(makeSphereInside(), 0, 1, roomScanner(), 75)).accepted());
}

TEST(Honest, unrelatedRoomsAreNotAccepted)
{
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto [a, b] = makeUnrelatedRooms(seed);
    const Pair pair{castScan(a, sensorPose(a.stations[0], 1, 0.1), roomScanner(), 1),
                    castScan(b, sensorPose(b.stations[0], 2, 0.1), roomScanner(), 2),
                    Eigen::Isometry3d::Identity()};
    const Result result = registerPair(pair);
    EXPECT_FALSE(result.accepted()) << "seed " << seed << ", confidence " << result.confidence;
    EXPECT_FALSE(result.message.empty());
  }
}

TEST(Honest, theInformationMatrixIsSymmetricAndPositive)
{
  const Result result = registerPair(scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 76));
  EXPECT_EQ(result.information, result.information.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(result.information);
  EXPECT_GT(solver.eigenvalues()[0], 0);
  EXPECT_TRUE(result.unobservable.empty());
  EXPECT_GT(result.rmse, 0);
  EXPECT_LT(result.rmse, 0.03);
}

// ---- viewpoint, offsets, priors, limits

TEST(PipelineViewpoint, mergedScansHaveNoSensorAtTheOriginAndAreSolved)
{
  const Scene scene = makeFurnishedRoom(3);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations[0], 0.5, 0);
  std::vector<Eigen::Matrix3Xf> scans;
  Eigen::Index total = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Isometry3d T_world_sensor = i == 0 ? T_world_target : sensorPose(scene.stations.at(i), 2, 0.1);
    scans.push_back(
        transformed(T_world_target.inverse() * T_world_sensor, castScan(scene, T_world_sensor, roomScanner(0.025), i)));
    total += scans.back().cols();
  }
  Eigen::Matrix3Xf merged(3, total);
  merged << scans[0], scans[1], scans[2];
  Random random(3);
  const Eigen::Isometry3d motion = randomMotion(random, 60); // the source: the same merged cloud, in a frame far off
  const Pair pair{transformed(motion, merged), merged, motion.inverse()};
  const Result result = registerPair(pair);
  EXPECT_EQ(result.source_viewpoint_used, result.source_viewpoint_found) << "the origin is no sensor of all three";
  // The target's origin is where one of its three scans was taken from: whether that will do is for the points to say.
  EXPECT_TRUE(result.accepted()) << result.message;
  // Where the clouds are: at the origin, 60 m from them, a hundredth of a degree is a centimetre.
  const Eigen::Isometry3d from_place(Eigen::Translation3d(motion.translation()));
  EXPECT_THAT(result.T_target_source * from_place, IsPoseNear(pair.T_target_source * from_place, 0.1 * kDegree, 0.01))
      << result.message;
}

TEST(PipelineViewpoint, isFoundInThePointsWhereTheFrameIsNotTheSensors)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 83);
  Random random(4);
  const Eigen::Isometry3d S = randomMotion(random, 30);
  const Eigen::Isometry3d D = randomMotion(random, 30);
  const Pair moved{transformed(S, pair.source), transformed(D, pair.target), D * pair.T_target_source * S.inverse()};
  for (const ViewpointMode mode : {ViewpointMode::Auto, ViewpointMode::Unknown}) {
    Options options = makeOptions(Profile::Default);
    options.viewpoint_mode = mode;
    const Result result = registerPair(moved, options);
    EXPECT_TRUE(result.source_viewpoint_used && result.target_viewpoint_used);
    EXPECT_TRUE(result.source_viewpoint_found && result.target_viewpoint_found);
    EXPECT_LT((result.source_viewpoint - S.translation()).norm(), 1);
    EXPECT_LT((result.target_viewpoint - D.translation()).norm(), 1);
    EXPECT_TRUE(result.accepted()) << result.message;
    // Compared where the sensor is: 30 m away from it the angle would rule.
    EXPECT_THAT(result.T_target_source * S, IsPoseNear(moved.T_target_source * S, 0.1 * kDegree, 0.005));
  }
}

TEST(PipelineViewpoint, theOneGivenIsReported)
{
  const Result result = registerPair(scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 84));
  EXPECT_TRUE(result.source_viewpoint_used && result.target_viewpoint_used);
  EXPECT_FALSE(result.source_viewpoint_found || result.target_viewpoint_found);
  EXPECT_LT(result.source_viewpoint.norm(), 1e-9);
  EXPECT_LT(result.target_viewpoint.norm(), 1e-9);
}

TEST(PipelineViewpoint, unusedMeansNeitherSignNorFreeSpace)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 81);
  Options options = makeOptions(Profile::Default);
  options.viewpoint_mode = ViewpointMode::Unused;
  const Result result = registerPair(pair, options);
  EXPECT_FALSE(result.source_viewpoint_used || result.target_viewpoint_used);
  EXPECT_EQ(result.contradiction, 0);
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005));
}

TEST(Offsets, mapCoordinatesAMillionMetresAway)
{
  // Float coordinates at 1e6 m are quantised to 6 cm: the answer can be no better than that allows.
  const Pair near = scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 91);
  const Eigen::Isometry3d A(Eigen::Translation3d(1e6, -5e5, 300)), B(Eigen::Translation3d(1e6, -5e5, 310));
  const Pair far{transformed(A, near.source), transformed(B, near.target), B * near.T_target_source * A.inverse()};
  const Result result = registerPair(far);
  const Eigen::Isometry3d back = B.inverse() * result.T_target_source * A;
  EXPECT_THAT(back, IsPoseNear(near.T_target_source, 0.5 * kDegree, 0.05)) << result.message;
}

TEST(Offsets, floatsThatHaveLostTheShapeAreRefused)
{
  const Pair near = scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 91);
  const Eigen::Isometry3d A(Eigen::Translation3d(5e5, 5.5e6, 200)); // a national grid, in steps of half a metre
  const Result result = registerPair({transformed(A, near.source), near.target, near.T_target_source * A.inverse()});
  EXPECT_EQ(result.status, Status::InvalidInput);
  EXPECT_THAT(result.message, ::testing::HasSubstr("the source scan lies 5500"));
  EXPECT_THAT(result.message, ::testing::HasSubstr("steps of 0.5 m"));
}

TEST(Scales, aSmallModelAndAHugeSceneNeedNoParameter)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 92);
  for (const double scale : {0.05, 40.0}) {
    const auto f = static_cast<float>(scale);
    Pair scaled{pair.source * f, pair.target * f, pair.T_target_source};
    scaled.T_target_source.translation() *= scale;
    const Result result = registerPair(scaled);
    EXPECT_EQ(result.status, Status::Converged) << "scale " << scale << ": " << result.message;
    EXPECT_THAT(result.T_target_source, IsPoseNear(scaled.T_target_source, 0.2 * kDegree, 0.02 * scale));
  }
}

TEST(Scales, coordinatesThatAreHardlyMetresAreAskedAbout)
{
  const Pair metres = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 92);
  const Pair millimetres{metres.source * 1000.F, metres.target * 1000.F, metres.T_target_source};
  EXPECT_THAT(registerPair(millimetres).message, ::testing::HasSubstr("m: are its coordinates in metres?"));
  EXPECT_THAT(registerPair({millimetres.source, metres.target, metres.T_target_source}).message,
              ::testing::ContainsRegex("the source scan reaches .* are its coordinates in metres"));
  const Pair centimetres{metres.source, metres.target * 100.F, metres.T_target_source};
  const Result unlike = registerPair(centimetres);
  EXPECT_NE(unlike.status, Status::Converged);
  EXPECT_THAT(
      unlike.message,
      ::testing::ContainsRegex("the target scan reaches (9|10|11). times as far as the other one: are both in"));
  EXPECT_THAT(registerPair(metres).message, ::testing::Not(::testing::HasSubstr("reaches")));
}

TEST(Gravity, aWrongPriorIsObeyedAndARightOneHelps)
{
  const Pair pair = scanPair(makeFurnishedRoom(3), 0, 1, roomScanner(), 93);
  Options options = makeOptions(Profile::Default);
  GravityPrior prior;
  prior.up_target = Eigen::Vector3d::UnitZ();
  prior.up_source = pair.T_target_source.linear().transpose() * prior.up_target;
  prior.tolerance = 5 * kDegree;
  options.gravity = prior;
  EXPECT_THAT(registerPair(pair, options).T_target_source, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005));
  options.gravity->up_source = -prior.up_source;
  const Result upside_down = registerPair(pair, options);
  for (const Candidate& c : upside_down.candidates)
    EXPECT_LT((c.T_target_source.linear() * options.gravity->up_source - prior.up_target).norm(), 0.3);
}

/// Angle by which a pose maps the vertical away from where the prior gives it.
double
tilt(const Eigen::Isometry3d& T_target_source, const GravityPrior& gravity)
{
  return angleBetweenDirections(T_target_source.linear() * gravity.up_source, gravity.up_target);
}

TEST(Gravity, noPoseThatViolatesItIsListedWhateverTheRefinementFinds)
{
  // The truth is just outside of the tolerance, and inside of that of the rotation candidates.
  const Pair pair = scanPair(makeFurnishedRoom(3), 0, 1, roomScanner(), 93);
  Options options = makeOptions(Profile::Default);
  GravityPrior prior;
  prior.tolerance = 2 * kDegree;
  for (const double angle : {1.0, 5.0, 30.0}) {
    const Eigen::AngleAxisd wrong(angle * kDegree, Eigen::Vector3d::UnitX());
    prior.up_source = pair.T_target_source.linear().transpose() * (wrong * prior.up_target);
    options.gravity = prior;
    for (const Eigen::Isometry3d* guess : {static_cast<const Eigen::Isometry3d*>(nullptr), &pair.T_target_source}) {
      const Result result = registerPair(pair, options, guess);
      EXPECT_EQ(result.accepted(), angle < 2) << angle << " degrees: " << result.message;
      EXPECT_FALSE(result.message.empty());
      for (const Candidate& candidate : result.candidates)
        EXPECT_LT(tilt(candidate.T_target_source, prior), prior.tolerance + 0.6 * kDegree) << angle << " degrees";
    }
  }
}

TEST(Gravity, aVerticalThatIsFiveDegreesWrongIsRefusedMoreOftenThanNot)
{
  // A pose within its tolerance of 2 degrees is 3 degrees off and nearly right in all else: it may seem to be right.
  Options options = makeOptions(Profile::Default);
  GravityPrior prior;
  prior.tolerance = 2 * kDegree;
  constexpr int kPairs = 24;
  int accepted = 0;
  for (std::uint64_t seed = 90; seed < 90 + kPairs; ++seed) {
    const Pair pair = scanPair(makeFurnishedRoom(3), 0, 1, roomScanner(), seed);
    const Eigen::AngleAxisd wrong(5 * kDegree, Eigen::Vector3d::UnitX());
    prior.up_source = pair.T_target_source.linear().transpose() * (wrong * prior.up_target);
    options.gravity = prior;
    const Result result = registerPair(pair, options);
    accepted += result.accepted();
    for (const Candidate& candidate : result.candidates)
      EXPECT_LT(tilt(candidate.T_target_source, prior), prior.tolerance + 0.6 * kDegree) << seed;
  }
  std::printf("%d of %d accepted\n", accepted, kPairs);
  EXPECT_LT(accepted, kPairs / 2);
}

TEST(Scales, binsOfAnyWidthAreBounded)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 92);
  Options options = makeOptions(Profile::Default);
  options.bin_width = 1e-9; // 10^10 bins an axis; the search must not throw inside of its threads
  EXPECT_TRUE(registerPair(pair, options).T_target_source.matrix().allFinite());
}

TEST(Refinement, withoutItTheAnswerIsNearAndJudgedTheSame)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(), 92);
  Options options = makeOptions(Profile::Default);
  options.refine = false;
  const Result result = registerPair(pair, options);
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, kDegree, 0.05)) << result.message;
  EXPECT_GT(result.information.trace(), 0);
  const Pair corridor = corridorPair();
  EXPECT_EQ(registerPair(corridor, options).status, Status::Unobservable);
}

TEST(OverlapRadius, isBoundedSoThatTheEvidenceStillTells)
{
  // Users of ICP set metres. Beyond twice the usual tolerance everything would meet something.
  const Pair pair = scanPair(makeFurnishedRoom(3), 0, 1, roomScanner(), 97);
  const auto with = [&pair](double radius) {
    Options options = makeOptions(Profile::Default);
    options.overlap_radius = radius;
    return registerPair(pair, options);
  };
  const Result usual = with(0);
  const Result narrow = with(0.02);
  const Result far = with(0.3);
  const Result farther = with(500);
  ASSERT_TRUE(usual.accepted());
  EXPECT_LT(narrow.overlap, usual.overlap);
  EXPECT_GT(far.overlap, usual.overlap);
  EXPECT_LT(far.overlap, 1);
  EXPECT_TRUE(far.accepted()) << far.message;
  EXPECT_THAT(far.T_target_source, IsPoseNear(pair.T_target_source, kDegree, 0.05));
  EXPECT_EQ(farther.overlap, far.overlap);
  EXPECT_EQ(farther.confidence, far.confidence);
  EXPECT_EQ(farther.T_target_source.matrix(), far.T_target_source.matrix());
}

TEST(Limits, timeRunsOutCleanly)
{
  const Pair pair = scanPair(makeHall(1), 0, 1, terrestrialScanner(0.0175), 94);
  Options options = makeOptions(Profile::Default);
  options.time_limit = 1e-6;
  EXPECT_EQ(registerPair(pair, options).status, Status::TimeLimit); // while the scans are prepared

  options.time_limit = 0;
  const auto [source, target] = prepareScans(viewOfPoints(pair.source), viewOfPoints(pair.target), options);
  options.time_limit = 1e-9;
  const Result result = registerScans(source, target, options);
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_THAT(result.message, ::testing::HasSubstr("before a pose could be judged"));
  EXPECT_TRUE(result.candidates.empty());
}

TEST(Limits, stagesAreReportedWithCountsAndSeconds)
{
  const Result result = registerPair(scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 95));
  ASSERT_GE(result.stages.size(), 5u);
  for (const char* name : {"source thinning", "target patches", "rotations", "polish"})
    EXPECT_TRUE(std::any_of(result.stages.begin(), result.stages.end(), [name](const StageReport& stage) {
      return stage.name == name && stage.count_in > 0 && stage.count_out > 0;
    })) << name;
  for (const StageReport& stage : result.stages) {
    EXPECT_FALSE(stage.name.empty());
    EXPECT_GE(stage.seconds, 0);
  }
}

// ---- degenerate input

TEST(Degenerate, everyKindOfEmptyOrBrokenCloudEndsWithAStatus)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const Pair pair = scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(0.035), 96);
  std::vector<Eigen::Matrix3Xf> clouds;
  clouds.emplace_back(3, 0);
  clouds.emplace_back(Eigen::Matrix3Xf::Constant(3, 1, 1.f));
  clouds.emplace_back(Eigen::Matrix3Xf::Constant(3, 1000, nan));
  clouds.emplace_back(Eigen::Matrix3Xf::Constant(3, 1000, inf));
  clouds.emplace_back(Eigen::Matrix3Xf::Constant(3, 100000, 2.f)); // duplicates
  clouds.emplace_back(Eigen::Matrix3Xf::Random(3, 5000));          // clutter
  clouds.emplace_back(Eigen::Matrix3Xf::Random(3, 5000) * 1e30f);
  Eigen::Matrix3Xf line = Eigen::Matrix3Xf::Zero(3, 5000);
  line.row(0).setLinSpaced(0, 10);
  clouds.push_back(line);
  for (std::size_t i = 0; i < clouds.size(); ++i)
    for (const bool swapped : {false, true}) {
      const Result result =
          swapped ? registerPair({pair.source, clouds[i], {}}) : registerPair({clouds[i], pair.target, {}});
      EXPECT_FALSE(result.accepted()) << "cloud " << i << ", " << toString(result.status);
      EXPECT_NE(result.status, Status::NotRun);
      EXPECT_FALSE(result.message.empty()) << "cloud " << i;
      EXPECT_TRUE(result.T_target_source.matrix().allFinite()) << "cloud " << i;
    }
}

TEST(Degenerate, nanPointsAmongGoodOnesAreSkipped)
{
  Pair pair = scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 97);
  const Result clean = registerPair(pair);
  Eigen::Matrix3Xf dirty(3, pair.source.cols() + 2);
  dirty << Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()), pair.source,
      Eigen::Vector3f(1, std::numeric_limits<float>::infinity(), 2);
  const Result result = registerPair({dirty, pair.target, pair.T_target_source});
  EXPECT_EQ(result.T_target_source.matrix(), clean.T_target_source.matrix());
}

TEST(Degenerate, whatDidNotReturnIsNotThere)
{
  // As drivers write it: in the frame of the sensor, most of the points of a scan at (0, 0, 0).
  const Pair pair = scanPair(makeFurnishedRoom(7), 0, 1, roomScanner(), 92);
  Pair with = pair;
  for (Eigen::Matrix3Xf* points : {&with.source, &with.target}) {
    const Eigen::Matrix3Xf returns = *points;
    points->setZero(3, 5 * returns.cols());
    for (Eigen::Index i = 0; i < returns.cols(); ++i)
      points->col(5 * i + i % 5) = returns.col(i);
  }
  const Result expected = registerPair(pair), result = registerPair(with);
  EXPECT_EQ(expected.status, Status::Converged) << expected.message;
  EXPECT_EQ(result.T_target_source.matrix(), expected.T_target_source.matrix());
  EXPECT_EQ(result.confidence, expected.confidence);
  EXPECT_TRUE(result.source_viewpoint_used && result.target_viewpoint_used);
}

TEST(Degenerate, aFewReturnsAtTheEndOfTheWorldDoNoHarm)
{
  const Pair pair = scanPair(makeFurnishedRoom(1), 0, 1, roomScanner(), 98);
  for (const float far : {1e4f, 1e6f, 1e9f, 1e30f, std::numeric_limits<float>::max()}) {
    Eigen::Matrix3Xf dirty(3, pair.source.cols() + 3);
    dirty << pair.source, Eigen::Vector3f::Constant(far), Eigen::Vector3f(far, 0, 0), Eigen::Vector3f(0, -far, 1);
    const Result result = registerPair({dirty, pair.target, pair.T_target_source});
    EXPECT_EQ(result.status, Status::Converged) << far << ": " << result.message;
    EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 0.1 * kDegree, 0.005)) << far;
  }
}

TEST(Degenerate, scansThatWereNotPreparedAreInvalidInput)
{
  const Options options = makeOptions(Profile::Default);
  EXPECT_EQ(registerScans({}, {}, options).status, Status::InvalidInput);
  Options bad = options;
  bad.leaf = -1;
  EXPECT_THROW(registerScans({}, {}, bad), std::invalid_argument);
}

TEST(Degenerate, optionsAndGuessesThatAreNoneAreRefusedBeforeAnyWork)
{
  const Pair pair = scanPair(makeFurnishedRoom(2), 0, 1, roomScanner(0.05), 73);
  Options options = makeOptions(Profile::Default);
  options.threads = 100000;
  EXPECT_THROW(prepareScans(viewOfPoints(pair.source), viewOfPoints(pair.target), options), std::invalid_argument);
  Eigen::Isometry3d guess = pair.T_target_source;
  guess.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(registerPair(pair, makeOptions(Profile::Default), &guess), std::invalid_argument);
  guess = pair.T_target_source;
  guess.linear() *= 2;
  EXPECT_THROW(registerPair(pair, makeOptions(Profile::Default), &guess), std::invalid_argument);
}

TEST(Degenerate, aToleranceThatEndsWhereNoSurfaceFaces)
{
  // Of a floor nothing faces the other axes: along them there is no correlation, and the window's edge is at zero.
  Eigen::Matrix3Xf floor(3, 81 * 81);
  for (Eigen::Index i = 0; i < floor.cols(); ++i)
    floor.col(i) << 0.1f * static_cast<float>(i % 81 - 40), 0.1f * static_cast<float>(i / 81 - 40), 0;
  Options options = makeOptions(Profile::Default);
  options.guess_tolerance = GuessTolerance{0.1, 1.0};
  for (const double shift : {1.3, -1.3}) {
    const Eigen::Isometry3d guess(Eigen::Translation3d(0, shift, 0));
    EXPECT_FALSE(registerPair({floor, floor}, options, &guess).accepted());
  }
}

TEST(Degenerate, aScanOfVeryFewPointsIsPrepared)
{
  Options options = makeOptions(Profile::Default);
  options.patch_profile.preparation.min_points = 1;
  Random random(3);
  Eigen::Matrix3Xf few(3, 10);
  for (Eigen::Index i = 0; i < few.cols(); ++i)
    few.col(i) = randomRotation(random).col(0).cast<float>();
  EXPECT_FALSE(registerPair({few, few}, options).accepted());
  EXPECT_FALSE(registerPair({few.leftCols(1), few.leftCols(1)}, options).accepted());
}

TEST(Degenerate, aSearchThatIsDecidedByAnythingNeedsAPose)
{
  Options options = makeOptions(Profile::Default);
  options.patch_profile.judgement.decided = 0;
  const Eigen::Matrix3Xf nothing(3, 0);
  EXPECT_FALSE(registerPair({nothing, nothing}, options).accepted());
  const Pair far = scanPair(makeSinglePlane(), 0, 1, roomScanner(), 74);
  EXPECT_FALSE(registerPair(far, options).accepted());
}

} // namespace
} // namespace pcl_ssfr::test_pipeline
