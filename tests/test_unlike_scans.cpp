// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The default profile on pairs of simulated scans that differ: sensors of different kinds, different resolutions,
// things that moved in between. Every scan is in a randomly rotated frame. All pairs must be solved and accepted.

#include "hard_cases.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ssfr::test_unlike_scans {
namespace {

using namespace pcl_ssfr::testing;
using simulation::DatasetPlan;

// ---------------------------------------------------------------------------------------------------------------------
// Sensors of different kinds, different resolutions

/// Two sensors in one scene.
struct Mixture {
  const char* scene;
  const char* source_sensor;
  const char* target_sensor;
};

std::ostream&
operator<<(std::ostream& out, const Mixture& mixture)
{
  return out << mixture.source_sensor << " onto " << mixture.target_sensor << ", " << mixture.scene;
}

class SensorsOfDifferentKinds : public ::testing::TestWithParam<Mixture> {};

TEST_P(SensorsOfDifferentKinds, BothWays)
{
  const Mixture mixture = GetParam();
  constexpr std::size_t kLeicaBeams = 100000;
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    // The same walk with both; every sensor has its own height above the floor.
    const std::vector<PosedScan> sources = takeScans(planScans(mixture.scene, mixture.source_sensor, 2, 0, seed));
    const std::vector<PosedScan> targets =
        takeScans(planScans(mixture.scene, mixture.target_sensor, 2, kLeicaBeams, seed));
    for (std::size_t i = 1; i < sources.size(); ++i) {
      tally.add(sources[i], targets[i - 1], "seed " + std::to_string(seed) + ", onto " + std::to_string(i - 1));
      tally.add(targets[i - 1], sources[i], "seed " + std::to_string(seed) + ", back from " + std::to_string(i - 1));
    }
  }
  ASSERT_EQ(tally.pairs, 4u);
  expectAllBelieved(tally);
}

INSTANTIATE_TEST_SUITE_P(Sensors,
                         SensorsOfDifferentKinds,
                         ::testing::Values(Mixture{"apartment", "hokuyo_utm30lx", "leica_p20"},
                                           Mixture{"hall", "velodyne_vlp16", "leica_p20"},
                                           Mixture{"street", "velodyne_vlp16", "leica_p20"},
                                           Mixture{"apartment", "livox_mid360", "leica_p20"}));

class TenTimesCoarser : public ::testing::TestWithParam<Place> {};

TEST_P(TenTimesCoarser, EitherScan)
{
  constexpr Eigen::Index kRatio = 10;
  const Place place = GetParam();
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    const std::vector<PosedScan> scans = takeScans(planScans(place.scene, place.sensor, 2, place.beams, seed));
    for (std::size_t i = 1; i < scans.size(); ++i) {
      tally.add(thinnedScan(scans[i], kRatio), scans[i - 1], "seed " + std::to_string(seed) + ", source thinned");
      tally.add(scans[i], thinnedScan(scans[i - 1], kRatio), "seed " + std::to_string(seed) + ", target thinned");
    }
  }
  ASSERT_EQ(tally.pairs, 4u);
  expectAllBelieved(tally);
}

INSTANTIATE_TEST_SUITE_P(Places,
                         TenTimesCoarser,
                         ::testing::Values(Place{"apartment", "leica_p20", 100000, 0},
                                           Place{"office_floor", "leica_p20", 100000, 0},
                                           Place{"hall", "leica_p20", 200000, 0},
                                           Place{"street", "leica_p20", 200000, 0}),
                         nameOfPlace);

// ---------------------------------------------------------------------------------------------------------------------
// Things that move between the scans

class MovedThings : public ::testing::TestWithParam<Place> {};

TEST_P(MovedThings, AFifthOfTheFurnitureAndPeopleAndDoors)
{
  const Place place = GetParam();
  Tally tally;
  for (const std::uint64_t seed : {1, 2}) {
    DatasetPlan plan = planScans(place.scene, place.sensor, 3, place.beams, seed);
    plan.trajectory.step = place.step;
    plan.movables.moved_furniture = 0.2;
    plan.movables.doors_move = true;
    plan.movables.people = 3;
    addConsecutive(tally, takeScans(plan), seed);
  }
  ASSERT_EQ(tally.pairs, 4u);
  expectAllBelieved(tally);
}

INSTANTIATE_TEST_SUITE_P(Places,
                         MovedThings,
                         ::testing::Values(Place{"apartment", "leica_p20", 60000, 0},
                                           Place{"office_floor", "leica_p20", 60000, 0},
                                           Place{"hall", "leica_p20", 60000, 0},
                                           Place{"street", "velodyne_hdl32e", 0, 0}),
                         nameOfPlace);

} // namespace
} // namespace pcl_ssfr::test_unlike_scans
