// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// What the caller knows helps: the vertical, or about where the source is. And what happens where the scene alone does
// not show enough planes.

#include "simulated_scans.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ssfr::test_priors {
namespace {

using namespace pcl_ssfr::testing;
using simulation::DatasetPlan;

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Poses and rotations that a registration looked at.
struct Work {
  std::size_t rotations = 0; ///< searched for translations
  std::size_t poses = 0;     ///< refined
  double seconds = 0;        ///< of the search and the coarse refinement

  void
  add(const Result& result)
  {
    for (const StageReport& stage : result.stages) {
      if (stage.name == "translations")
        rotations += stage.count_in;
      else if (stage.name == "coarse refinement")
        poses += stage.count_in;
      else if (stage.name != "rotations")
        continue;
      seconds += stage.seconds;
    }
  }
};

/// What became of pairs, without and with a prior.
struct Comparison {
  std::size_t pairs = 0;
  Work free_work, work;                          ///< without, and with the prior
  std::size_t free_accepted = 0, accepted = 0;   ///< right and accepted
  std::size_t free_dishonest = 0, dishonest = 0; ///< accepted and not right
  std::string failures;                          ///< a line for each pair that is not right with the prior

  void
  add(const PosedScan& source,
      const PosedScan& target,
      const Options& prior,
      const Eigen::Isometry3d* guess,
      const std::string& name)
  {
    const PairOutcome free = registerPosedScans(source, target);
    const PairOutcome known = registerPosedScans(source, target, prior, guess);
    ++pairs;
    free_work.add(free.result);
    work.add(known.result);
    free_accepted += free.right && free.result.accepted();
    accepted += known.right && known.result.accepted();
    free_dishonest += !free.honest();
    dishonest += !known.honest();
    if (!known.right)
      failures += name + ": " + describe(known.result) + '\n';
  }

  void
  print(const std::string& name) const
  {
    std::printf(
        "%s: %zu pairs; accepted and right %zu, with the prior %zu; rotations %.2f, poses %.2f, seconds %.2f of "
        "those without\n",
        name.c_str(),
        pairs,
        free_accepted,
        accepted,
        static_cast<double>(work.rotations) / static_cast<double>(free_work.rotations),
        static_cast<double>(work.poses) / static_cast<double>(free_work.poses),
        work.seconds / free_work.seconds);
  }
};

std::string
nameOf(std::uint64_t seed, std::size_t scan)
{
  return "seed " + std::to_string(seed) + ", scan " + std::to_string(scan);
}

/// The vertical of both scans, as an inertial sensor would tell it.
GravityPrior
verticalOf(const PosedScan& source, const PosedScan& target)
{
  GravityPrior gravity;
  gravity.up_source = source.T_world_scan.linear().transpose() * Eigen::Vector3d::UnitZ();
  gravity.up_target = target.T_world_scan.linear().transpose() * Eigen::Vector3d::UnitZ();
  return gravity;
}

/// A pose so far from another: rotated about a random axis, moved in a random direction.
Eigen::Isometry3d
besides(const Eigen::Isometry3d& T, double angle, double distance, std::uint64_t seed)
{
  Random random(seed);
  const Eigen::Vector3d axis = randomRotation(random).col(0);
  const Eigen::Vector3d direction = randomRotation(random).col(0);
  Eigen::Isometry3d nearby = T * Eigen::AngleAxisd(angle, axis);
  nearby.translation() += distance * direction;
  return nearby;
}

// ---------------------------------------------------------------------------------------------------------------------
// The vertical is known

struct Place {
  const char* scene;
  const char* sensor;
  std::size_t beams;
};

std::ostream&
operator<<(std::ostream& out, const Place& place)
{
  return out << place.scene << "_" << place.sensor;
}

class Gravity : public ::testing::TestWithParam<Place> {};

TEST_P(Gravity, TakesLessWorkAndSolvesNoFewer)
{
  const Place place = GetParam();
  Comparison all;
  for (const std::uint64_t seed : {1, 2}) {
    const std::vector<PosedScan> scans = takeScans(planScans(place.scene, place.sensor, 3, place.beams, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      Options options = defaultOptions();
      options.gravity = verticalOf(scans[i], scans[i - 1]);
      all.add(scans[i], scans[i - 1], options, nullptr, nameOf(seed, i));
    }
  }
  all.print(place.scene);
  EXPECT_GE(all.accepted, all.free_accepted) << all.failures;
  EXPECT_LT(all.work.rotations, all.free_work.rotations);
  // Level rings of few points in rooms leave the tilt to a few degrees (README, Limits).
  EXPECT_LE(all.dishonest, all.free_dishonest) << all.failures;
  EXPECT_LE(all.dishonest, std::string(place.sensor) == "velodyne_vlp16" ? 1U : 0U) << all.failures;
}

INSTANTIATE_TEST_SUITE_P(Places,
                         Gravity,
                         ::testing::Values(Place{"office_floor", "velodyne_vlp16", 30000},
                                           Place{"hall", "velodyne_vlp16", 30000},
                                           Place{"apartment", "leica_p20", 40000},
                                           Place{"symmetric_room", "leica_p20", 40000}));

// ---------------------------------------------------------------------------------------------------------------------
// About where the source is, is known

TEST(Guess, TellsTwinsApart)
{
  // Twelve poses of the round hall look alike; a guess nearer to one of them than to the next decides.
  std::size_t pairs = 0, right = 0;
  std::string failures;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<PosedScan> scans = takeScans(planScans("cylinder_hall", "leica_p20", 3, 40000, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      const Eigen::Isometry3d guess = besides(truePose(scans[i], scans[i - 1]), 4 * kDegree, 0.3, 10 * seed + i);
      const PairOutcome outcome = registerPosedScans(scans[i], scans[i - 1], defaultOptions(), &guess);
      ++pairs;
      right += outcome.right;
      if (!outcome.right)
        failures += nameOf(seed, i) + ": " + describe(outcome.result) + '\n';
    }
  }
  EXPECT_EQ(right, pairs) << failures;
}

TEST(Guess, ThatIsWrongDoesNoHarm)
{
  for (const std::uint64_t seed : {1, 2}) {
    const std::vector<PosedScan> scans = takeScans(planScans("apartment", "leica_p20", 3, 40000, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      const Eigen::Isometry3d guess = besides(truePose(scans[i], scans[i - 1]), 170 * kDegree, 5, 10 * seed + i);
      const PairOutcome outcome = registerPosedScans(scans[i], scans[i - 1], defaultOptions(), &guess);
      EXPECT_TRUE(outcome.right && outcome.result.accepted()) << describe(outcome.result);
    }
  }
}

TEST(Guess, WithAToleranceIsSurerAndTakesLessWork)
{
  // Offices alike on both sides of a corridor: what lies half a turn away is out of the question.
  Comparison all;
  for (const std::uint64_t seed : {1, 2}) {
    DatasetPlan plan = planScans("office_floor", "sick_lms200", 6, 0, seed);
    plan.trajectory.step = 2.5;
    const std::vector<PosedScan> scans = takeScans(plan);
    for (std::size_t i = 1; i < scans.size(); ++i) {
      Options options = defaultOptions();
      options.guess_tolerance = GuessTolerance{10 * kDegree, 1.0};
      const Eigen::Isometry3d guess = besides(truePose(scans[i], scans[i - 1]), 5 * kDegree, 0.5, 10 * seed + i);
      all.add(scans[i], scans[i - 1], options, &guess, nameOf(seed, i));
    }
  }
  all.print("office_floor, with a guess");
  EXPECT_EQ(all.dishonest, 0U) << all.failures;
  EXPECT_GE(all.accepted, all.free_accepted) << all.failures;
  EXPECT_LT(2 * all.work.rotations, all.free_work.rotations);
  EXPECT_LT(all.work.poses, all.free_work.poses);
}

TEST(Guess, WithAToleranceBoundsTheAnswer)
{
  // The guess excludes the truth: nothing outside of the tolerance may come out, accepted or not.
  const std::vector<PosedScan> scans = takeScans(planScans("apartment", "leica_p20", 2, 40000, 1));
  const Eigen::Isometry3d guess = besides(truePose(scans[1], scans[0]), 90 * kDegree, 2, 3);
  Options options = defaultOptions();
  options.guess_tolerance = GuessTolerance{20 * kDegree, 0.5};
  const PairOutcome outcome = registerPosedScans(scans[1], scans[0], options, &guess);
  EXPECT_FALSE(outcome.result.accepted()) << describe(outcome.result);
  for (const Candidate& candidate : outcome.result.candidates) {
    const Eigen::Isometry3d error = guess.inverse() * candidate.T_target_source;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 21 * kDegree);
    EXPECT_LT((candidate.T_target_source.translation() - guess.translation()).norm(), 0.6);
  }
}

TEST(Guess, NoPolishPassesItsTolerance)
{
  // The truth lies some millimetres to either side of the tolerance, so that the polish may want to pass it.
  const std::vector<PosedScan> scans = takeScans(planScans("hall", "velodyne_vlp16", 3, 30000, 2));
  const PosedScan& source = scans[2];
  const PosedScan& target = scans[1];
  Options options = defaultOptions();
  const auto [s, t] = prepareScans(viewOfPoints(source.points), viewOfPoints(target.points), options);
  int accepted = 0;
  for (std::uint64_t k = 0; k < 24; ++k) {
    const Eigen::Isometry3d guess = besides(truePose(source, target), 0, 0.05, k);
    options.guess_tolerance = GuessTolerance{0.1, 0.042 + 0.001 * static_cast<double>(k % 12)};
    const Result result = registerScans(s, t, options, &guess);
    accepted += result.accepted();
    for (const Candidate& candidate : result.candidates) {
      const Eigen::Vector3d sensor = result.source_viewpoint;
      EXPECT_LE((candidate.T_target_source * sensor - guess * sensor).norm(),
                options.guess_tolerance->translation + 1e-9)
          << k;
    }
  }
  EXPECT_GT(accepted, 0);
}

// ---------------------------------------------------------------------------------------------------------------------
// Few planes

/// A scan from a place, given in a randomly rotated frame.
PosedScan
scanFrom(const Scene& scene, const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed)
{
  Random random(seed);
  Eigen::Isometry3d T_scan_sensor = Eigen::Isometry3d::Identity();
  T_scan_sensor.linear() = randomRotation(random);
  PosedScan scan;
  scan.points = transformed(T_scan_sensor, castScan(scene, T_world_sensor, terrestrialScanner(0.0175), seed));
  scan.T_world_scan = T_world_sensor * T_scan_sensor.inverse();
  return scan;
}

/// Two scans of a scene in front of the y axis, 1.8 m and 40 degrees apart.
std::pair<PosedScan, PosedScan>
twoScans(const Scene& scene, std::uint64_t seed)
{
  return {scanFrom(scene, sensorPose({1.5, -1, 1.5}, 0.7, 0.05), 2 * seed),
          scanFrom(scene, sensorPose({0, 0, 1.2}, 0, 0), 2 * seed + 1)};
}

/// One wall, and boxes at all angles before it.
Scene
wallWithClutter(std::uint64_t seed)
{
  Scene scene;
  Random random(seed);
  scene.addBlock({0, 10, 0}, {60, 0.3, 8});
  for (int i = 0; i < 40; ++i) {
    Box box;
    box.centre = {random.uniform(-12, 12), random.uniform(2, 9.5), random.uniform(0.2, 5)};
    box.half_size = {random.uniform(0.1, 0.5), random.uniform(0.1, 0.5), random.uniform(0.1, 0.5)};
    box.axes = randomRotation(random);
    scene.boxes.push_back(box);
  }
  return scene;
}

/// Level ground with trees: trunks, and leaves as small balls.
Scene
wood(std::uint64_t seed)
{
  constexpr int kTrees = 60;
  constexpr int kLeaves = 8; // a tree
  Scene scene;
  Random random(seed);
  scene.addBlock({0, 0, -0.2}, {200, 200, 0.2});
  for (int i = 0; i < kTrees; ++i) {
    const double x = random.uniform(-15, 15), y = random.uniform(-15, 15);
    if (std::hypot(x, y) < 2 || std::hypot(x - 1.5, y + 1) < 1)
      continue;
    scene.addColumn({x, y, 0}, random.uniform(0.1, 0.3), random.uniform(4, 8));
    for (int k = 0; k < kLeaves; ++k)
      scene.spheres.push_back(
          {{x + random.uniform(-1, 1), y + random.uniform(-1, 1), random.uniform(2.5, 6)}, random.uniform(0.05, 0.3)});
  }
  return scene;
}

/// Registered, or the reason given; never a wrong pose with confidence.
void
expectHonest(const PosedScan& source, const PosedScan& target, const Options& options)
{
  const PairOutcome outcome = registerPosedScans(source, target, options);
  EXPECT_TRUE(outcome.honest()) << describe(outcome.result);
  EXPECT_FALSE(outcome.result.message.empty());
  if (!outcome.result.accepted()) {
    EXPECT_THAT(outcome.result.status,
                ::testing::AnyOf(Status::TooFewDirections,
                                 Status::Unobservable,
                                 Status::Ambiguous,
                                 Status::LowOverlap,
                                 Status::Contradicted,
                                 Status::NoCandidate))
        << describe(outcome.result);
  }
}

TEST(WeakStructure, OneWallWithClutterIsRegistered)
{
  // The planes tell one direction; the things before the wall tell the rest.
  std::size_t accepted = 0;
  std::string failures;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto [source, target] = twoScans(wallWithClutter(seed), seed);
    expectHonest(source, target, defaultOptions());
    const PairOutcome outcome = registerPosedScans(source, target);
    accepted += outcome.right && outcome.result.accepted();
    failures += describe(outcome.result) + '\n';
    Options upright = defaultOptions();
    upright.gravity = verticalOf(source, target);
    expectHonest(source, target, upright);
  }
  EXPECT_GE(accepted, 2U) << failures;
}

TEST(WeakStructure, Wood)
{
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto [source, target] = twoScans(wood(seed), seed);
    expectHonest(source, target, defaultOptions());
    Options upright = defaultOptions();
    upright.gravity = verticalOf(source, target);
    expectHonest(source, target, upright);
  }
}

TEST(WeakStructure, CaveIsRegistered)
{
  std::size_t pairs = 0, accepted = 0;
  std::string failures;
  for (const char* sensor : {"leica_p20", "velodyne_vlp16"})
    for (const std::uint64_t seed : {1, 2}) {
      const std::vector<PosedScan> scans = takeScans(planScans("cave", sensor, 2, 40000, seed));
      for (std::size_t i = 1; i < scans.size(); ++i) {
        const PairOutcome outcome = registerPosedScans(scans[i], scans[i - 1]);
        ++pairs;
        accepted += outcome.right && outcome.result.accepted();
        EXPECT_TRUE(outcome.honest()) << describe(outcome.result);
        if (!outcome.right)
          failures += describe(outcome.result) + '\n';
      }
    }
  ASSERT_EQ(pairs, 4u);
  EXPECT_EQ(accepted, pairs) << failures;
}

} // namespace
} // namespace pcl_ssfr::test_priors
