// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The default profile where registration is hard, on simulated scans with exact truth: little overlap, corridors,
// repetition. Every scan is in a randomly rotated frame.
// Each case states how many of its pairs must be solved, and none may be accepted that is wrong, but for level rings.

#include "common/rotation_math.h"
#include "hard_cases.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ssfr::test_hard_cases {
namespace {

using namespace pcl_ssfr::testing;
using simulation::DatasetPlan;

// ---------------------------------------------------------------------------------------------------------------------
// Little overlap

/// Pairs of scans of a plan of which each sees between 25 and 40 % of what the other sees: at most \p most.
std::vector<std::pair<std::size_t, std::size_t>>
pairsThatOverlapByAThird(const DatasetPlan& plan, std::size_t most)
{
  constexpr double kLeast = 0.25;
  constexpr double kMost = 0.4;
  constexpr std::size_t kRays = 500;
  const simulation::PreparedPlan prepared = simulation::prepare(plan, 2);
  const simulation::RayCaster caster(simulation::surfacesAt(prepared.scene, {}, plan.seed, 0));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const std::vector<Eigen::Isometry3d>& poses = prepared.T_world_sensor;
  for (std::size_t i = 1; i < poses.size(); ++i)
    for (std::size_t j = 0; j < i && pairs.size() < most; ++j) {
      const double overlap = std::min(visibleOverlap(caster, prepared.sensorOf(i), poses[i], poses[j], kRays),
                                      visibleOverlap(caster, prepared.sensorOf(j), poses[j], poses[i], kRays));
      if (overlap >= kLeast && overlap <= kMost)
        pairs.emplace_back(i, j);
    }
  return pairs;
}

class ThirtyPercentOverlap : public ::testing::TestWithParam<Place> {};

TEST_P(ThirtyPercentOverlap, IsEnough)
{
  const Place place = GetParam();
  constexpr std::size_t kPairs = 3; // a seed
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    DatasetPlan plan = planScans(place.scene, place.sensor, 9, place.beams, seed);
    plan.trajectory.step = place.step;
    const auto pairs = pairsThatOverlapByAThird(plan, kPairs);
    const std::vector<PosedScan> scans = takeScans(plan);
    for (const auto& [i, j] : pairs)
      addPair(tally, scans, i, j, seed);
  }
  ASSERT_GE(tally.pairs, kPairs);
  expectAllBelieved(tally);
}

INSTANTIATE_TEST_SUITE_P(Places,
                         ThirtyPercentOverlap,
                         ::testing::Values(Place{"apartment", "leica_p20", 60000, 0.8},
                                           Place{"apartment", "hokuyo_utm30lx", 100000, 0.8},
                                           Place{"hall", "leica_p20", 100000, 5}),
                         nameOfPlace);

// ---------------------------------------------------------------------------------------------------------------------
// Corridors

TEST(Corridor, WithRoomsIsRegistered)
{
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    DatasetPlan plan = planScans("office_floor", "leica_p20", 6, 60000, seed);
    plan.trajectory.step = 1.5;
    addConsecutive(tally, takeScans(plan), seed);
  }
  ASSERT_EQ(tally.pairs, 10u);
  expectAllBelieved(tally);
}

/// How far the best pose is off: without the rotation about, and the shift along, its free directions, and that shift.
struct DeterminedError {
  double rotation = 0;    ///< [rad]
  double translation = 0; ///< [m]
  double shift = 0;       ///< along what the result calls undetermined [m]
};

DeterminedError
errorOfWhatIsDetermined(const Result& result, const PosedScan& source, const PosedScan& target)
{
  const Eigen::Isometry3d truth = target.T_world_scan.inverse() * source.T_world_scan;
  const Eigen::AngleAxisd turn(result.T_target_source.linear() * truth.linear().transpose());
  Eigen::Vector3d rotation = turn.angle() * turn.axis();
  Eigen::Vector3d shift = result.T_target_source * result.source_viewpoint - truth * result.source_viewpoint;
  const double off = shift.norm();
  for (const UnobservableDirection& free : result.unobservable) {
    Eigen::Vector3d& error = free.rotation ? rotation : shift;
    error -= free.direction * free.direction.dot(error);
  }
  return {rotation.norm(), shift.norm(), std::sqrt(std::max(0.0, off * off - shift.squaredNorm()))};
}

class EndlessCorridor : public ::testing::TestWithParam<const char*> {};

TEST_P(EndlessCorridor, IsUnobservableAlongItAndKnownOtherwise)
{
  const double least =
      GetParam() == std::string("velodyne_vlp16") ? 0.999 : 0.9999; // sixteen rings tell it to 2 degrees
  for (const std::uint64_t seed : {1, 2, 5}) {
    const std::vector<PosedScan> scans = takeScans(planScans("endless_corridor", GetParam(), 3, 40000, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      const Result result = registerPosedScans(scans[i], scans[i - 1]).result;
      EXPECT_EQ(result.status, Status::Unobservable) << describe(result);
      ASSERT_EQ(result.unobservable.size(), 1U) << describe(result);
      const Eigen::Vector3d along = scans[i - 1].T_world_scan.linear().row(0);
      EXPECT_GT(std::abs(result.unobservable[0].direction.dot(along)), least) << describe(result);
      const DeterminedError error = errorOfWhatIsDetermined(result, scans[i], scans[i - 1]);
      EXPECT_LT(error.rotation, 0.2 * kDegree) << describe(result);
      EXPECT_LT(error.translation, 0.02) << describe(result);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors,
                         EndlessCorridor,
                         ::testing::Values("sick_lms200",
                                           "hokuyo_utm30lx",
                                           "leica_p20",
                                           "velodyne_vlp16",
                                           "velodyne_hdl32e",
                                           "livox_mid360",
                                           "ouster_os1_128"));

TEST(Corridor, WithoutAnEndAllButTheShiftIsKnown)
{
  // Sixteen rings tell the direction along it to 2 degrees (above): so far a shift along it leads away.
  const double sine = 0.045;
  int known = 0;
  for (const std::uint64_t seed : {2, 4, 6}) {
    const std::vector<PosedScan> scans = takeScans(planScans("endless_corridor", "velodyne_vlp16", 3, 40000, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      const Result result = registerPosedScans(scans[i], scans[i - 1]).result;
      if (result.unobservable.empty())
        continue;
      ++known;
      const DeterminedError error = errorOfWhatIsDetermined(result, scans[i], scans[i - 1]);
      EXPECT_LT(error.rotation, 0.2 * kDegree) << describe(result);
      EXPECT_LT(error.translation, 0.02 + sine * error.shift) << describe(result);
    }
  }
  EXPECT_EQ(known, 6);
}

TEST(Corridor, WithoutAnEndIsNoMatchOfRings)
{
  // Sparse rings, laid one on the other with their gaps, match better than any other shift along the corridor. Any seed
  // may be the odd one, so several are asked.
  for (const char* sensor : {"velodyne_vlp16", "velodyne_hdl32e"}) {
    int accepted = 0;
    std::string which;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const std::vector<PosedScan> scans = takeScans(planScans("endless_corridor", sensor, 4, 40000, seed));
      for (std::size_t i = 1; i < scans.size(); ++i) {
        const Result result = registerPosedScans(scans[i], scans[i - 1]).result;
        accepted += result.accepted();
        if (result.accepted())
          which += "seed " + std::to_string(seed) + ": " + describe(result) + '\n';
      }
    }
    std::printf("%s: %d of 36 accepted\n", sensor, accepted);
    EXPECT_EQ(accepted, 0) << which;
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Level rings

TEST(LevelRings, WhatIsClaimedOfTheTiltIsTrue)
{
  // Sixteen rings in small rooms see the walls at one height and neither floor nor ceiling. Of how many pairs what is
  // claimed holds: any of them may be the odd one.
  constexpr int kPairs = 32;
  int true_free = 0, true_rough = 0, known_right = 0, same = 0, same_deviation = 0;
  std::string failures;
  for (std::uint64_t seed = 1; seed <= kPairs; ++seed) {
    simulation::DatasetPlan plan = planScans("apartment", "velodyne_vlp16", 2, 0, seed);
    plan.trajectory.step = 3;
    const std::vector<PosedScan> scans = takeScans(plan);
    const Eigen::Vector3d up_source = scans[1].T_world_scan.linear().row(2);
    const Eigen::Vector3d up_target = scans[0].T_world_scan.linear().row(2);
    const Eigen::Isometry3d truth = scans[0].T_world_scan.inverse() * scans[1].T_world_scan;
    const auto deviation = [](const Result& result) {
      const Eigen::Matrix3d covariance = result.information.inverse().topLeftCorner<3, 3>();
      return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2]);
    };
    // A pose that is refused may be half a turn about the vertical off: its tilt is what is claimed.
    const auto is_true = [&](const Result& result) {
      const double tilt = angleBetweenDirections(result.T_target_source.linear() * up_source, up_target);
      const double rotation = angleBetween(result.T_target_source.linear(), truth.linear());
      return (result.accepted() ? rotation : tilt) < 3 * deviation(result);
    };

    const PairOutcome free = registerPosedScans(scans[1], scans[0]);
    EXPECT_TRUE(free.honest() || is_true(free.result)) << "seed " << seed << ": " << describe(free.result);
    EXPECT_GT(deviation(free.result), 0.003) << seed; // dense scanners in rooms claim a tenth of that
    true_free += is_true(free.result);
    if (!is_true(free.result))
      failures += "seed " + std::to_string(seed) + ": " + describe(free.result) + '\n';

    // Who knows the vertical knows the tilt.
    Options options = defaultOptions();
    options.gravity = GravityPrior{up_source, up_target};
    const PairOutcome known = registerPosedScans(scans[1], scans[0], options);
    EXPECT_TRUE(known.honest()) << "seed " << seed << ": " << describe(known.result);
    if (known.result.accepted() && known.right) {
      ++known_right;
      EXPECT_TRUE(known.result.unobservable.empty()) << seed;
    }

    // Not who knows it to 35 degrees only.
    options.gravity->tolerance = 0.6;
    const Result roughly = registerPosedScans(scans[1], scans[0], options).result;
    true_rough += is_true(roughly);
    // Of several optima it may leave another one.
    const double apart = (free.result.T_target_source.translation() - roughly.T_target_source.translation()).norm();
    const double between = angleBetween(free.result.T_target_source.linear(), roughly.T_target_source.linear());
    if (between < deviation(free.result) && apart < 0.1) {
      ++same;
      same_deviation += deviation(roughly) > 0.9 * deviation(free.result);
    }
  }
  std::printf("of %d pairs claims of the tilt true of %d and, roughly known, %d, known: %d right; as uncertain as "
              "before: %d of "
              "%d\n",
              kPairs,
              true_free,
              true_rough,
              known_right,
              same_deviation,
              same);
  EXPECT_GE(true_free, 30) << failures;
  EXPECT_GE(true_rough, 29);
  EXPECT_GE(known_right, 27);
  EXPECT_GE(same, 16);
  EXPECT_GE(same_deviation, same - 2);
}

TEST(LevelRingsOfAWalk, WithAVerticalThatIsADegreeWrong)
{
  // What the rings show of the tilt is a few degrees wrong at times; given the vertical, few answers are.
  std::size_t pairs = 0, solved_free = 0, solved = 0, wrong = 0;
  std::string failures;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    simulation::DatasetPlan plan = planScans("apartment", "velodyne_vlp16", 5, 0, seed);
    plan.trajectory.step = 1.5;
    const std::vector<PosedScan> scans = takeScans(plan);
    Random random(seed);
    for (std::size_t i = 1; i < scans.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Options options = defaultOptions();
        GravityPrior gravity;
        gravity.up_target = scans[j].T_world_scan.linear().row(2);
        gravity.up_source = Eigen::AngleAxisd(0.0175, randomRotation(random).col(0)) *
                            scans[i].T_world_scan.linear().row(2).transpose();
        options.gravity = gravity;
        const PairOutcome with_vertical = registerPosedScans(scans[i], scans[j], options);
        ++pairs;
        solved_free += registerPosedScans(scans[i], scans[j]).right;
        solved += with_vertical.right;
        wrong += !with_vertical.honest();
        if (!with_vertical.honest())
          failures += "seed " + std::to_string(seed) + ", " + std::to_string(i) + " onto " + std::to_string(j) + ": " +
                      describe(with_vertical.result) + '\n';
      }
  }
  std::printf(
      "pairs %zu; right %zu, with the vertical %zu, wrong and accepted %zu\n", pairs, solved_free, solved, wrong);
  EXPECT_GE(solved, solved_free);
  EXPECT_LE(wrong, pairs / 20) << failures;
}

// ---------------------------------------------------------------------------------------------------------------------
// Repetition

TEST(Repetition, StoreysAreToldApart)
{
  // The walk goes through both storeys, which are alike: scans of the second are tempted by the first.
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    const std::vector<PosedScan> scans = takeScans(planScans("two_floors_alike", "leica_p20", 10, 40000, seed));
    for (std::size_t i = 3; i < scans.size(); i += 2)
      addPair(tally, scans, i, 0, seed);
  }
  ASSERT_EQ(tally.pairs, 8u);
  expectAllBelieved(tally);
}

TEST(Repetition, ColumnsAreToldApart)
{
  Tally tally;
  for (const std::uint64_t seed : {1, 2})
    addAllPairs(tally, takeScans(planScans("hall", "leica_p20", 4, 60000, seed)), seed);
  ASSERT_EQ(tally.pairs, 12u);
  EXPECT_GE(tally.solved, 11u) << tally.failures;
  EXPECT_EQ(tally.wrong, 0u) << tally.failures;
}

TEST(Repetition, CandidatesAreDistinctAndBestFirst)
{
  // Polished, rivals changed their order here, which the list did not follow.
  struct Row {
    const char* scene;
    std::uint64_t seed;
    std::size_t source;
  };
  for (const Row& row : {Row{"endless_corridor", 4, 1}, Row{"cylinder_hall", 3, 2}}) {
    const std::vector<PosedScan> scans = takeScans(planScans(row.scene, "leica_p20", 4, 40000, row.seed));
    const Result result = registerPosedScans(scans[row.source], scans[row.source - 1], defaultOptions()).result;
    ASSERT_GE(result.candidates.size(), 3U) << row.scene;
    expectDistinctCandidates(result, row.scene);
    for (std::size_t i = 1; i < result.candidates.size(); ++i)
      EXPECT_LE(result.candidates[i].probability, result.candidates[i - 1].probability) << row.scene << ' ' << i;
  }
}

TEST(Repetition, RoundHallIsNeverBelievedAtTheWrongTurn)
{
  // Columns in a ring: a tenth of a turn away the hall looks nearly the same, and its wall shows no rotation.
  Tally tally;
  for (const std::uint64_t seed : {1, 2, 3})
    addAllPairs(tally, takeScans(planScans("cylinder_hall", "leica_p20", 4, 40000, seed)), seed);
  ASSERT_EQ(tally.pairs, 18u);
  EXPECT_EQ(tally.wrong, 0u) << tally.failures;
  EXPECT_GE(tally.solved, 9u) << tally.failures;
}

} // namespace
} // namespace pcl_ssfr::test_hard_cases
