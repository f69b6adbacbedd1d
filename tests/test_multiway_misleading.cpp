// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Buildings made to mislead, from their scans to the map: bays, rooms and storeys that are alike.

#include "multiway/furniture.h"
#include "multiway/scan_pair.h"

#include <pcl_ssfr/multiway/multiway_registration.h>
#include <pcl_ssfr/pipeline.h>

#include <link_cache.h>
#include <simulated_scans.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_multiway_misleading {
namespace {

/// Scans at stations of a building whose parts are alike.
class MisleadingBuilding {
public:
  /// \param[in] stations empty: all
  MisleadingBuilding(const std::string& scene,
                     const std::string& sensor,
                     std::size_t points,
                     const std::vector<std::size_t>& stations = {})
  {
    simulation::DatasetPlan plan;
    plan.scene = scene;
    plan.sensor = sensor;
    plan.points = points;
    plan.at_stations = true;
    scans_ = testing::takeScans(plan, testing::Frames::Sensors, stations);
  }

  /// A pair is linked once for all maps: the test for places alike comes after all links.
  /// \param[in] check look for places alike
  /// \param[in] accepted pairs of scans
  /// \param[in] known scans whose poses are known approximately
  MultiwayMap
  mapOf(bool check, const std::vector<std::pair<int, int>>& accepted = {}, const std::vector<int>& known = {})
  {
    MultiwayOptions options;
    options.alias.check = check;
    MultiwayRegistration registration(options);
    for (std::size_t i = 0; i < scans_.size(); ++i)
      registration.addScan("s" + std::to_string(i), testing::viewOfPoints(scans_[i].points));
    links_.serve(registration, options);
    for (const auto& [a, b] : accepted)
      registration.accept(a, b);
    for (const int i : known) {
      PosePrior prior;
      prior.T_map_scan = scans_[static_cast<std::size_t>(i)].T_world_scan;
      prior.rotation = 0.05;
      registration.setPosePrior(i, prior);
    }
    return registration.run();
  }

  /// Placed scans that are not within 2 degrees and 0.3 m of where most scans of their component are.
  std::size_t
  countWrong(const MultiwayMap& map) const
  {
    std::size_t wrong = 0;
    for (int component = 0; component < map.components; ++component) {
      std::vector<std::size_t> members;
      for (std::size_t i = 0; i < map.scans.size(); ++i)
        if (map.scans[i].component == component)
          members.push_back(i);
      std::size_t most = 0;
      for (const std::size_t i : members)
        most = std::max<std::size_t>(
            most, static_cast<std::size_t>(std::count_if(members.begin(), members.end(), [&](std::size_t j) {
              const Eigen::Isometry3d error = testing::truePose(scans_[j], scans_[i]).inverse() *
                                              (map.scans[i].T_map_scan.inverse() * map.scans[j].T_map_scan);
              return error.translation().norm() < 0.3 && Eigen::AngleAxisd(error.linear()).angle() < 0.035;
            })));
      wrong += members.size() - most;
    }
    return wrong;
  }

private:
  std::vector<testing::PosedScan> scans_;
  testing::LinkCache links_;
};

TEST(BaysAlike, areNotLaidOntoEachOtherAndWhatIsSureIsPlaced)
{
  MisleadingBuilding hall("plant_hall", "leica_p20", 30000, {0, 2, 3, 4, 5, 9, 10, 11});
  EXPECT_GT(hall.countWrong(hall.mapOf(false)), 0U); // without the test for places alike
  const MultiwayMap map = hall.mapOf(true);
  EXPECT_EQ(hall.countWrong(map), 0U);
  EXPECT_EQ(map.placed, 8U); // by what stands in the bays
}

TEST(RoomsAlike, areNotLaidOntoEachOther)
{
  MisleadingBuilding rooms("rooms_with_doors", "livox_mid360", 40000);
  EXPECT_GT(rooms.countWrong(rooms.mapOf(false)), 0U);
  const MultiwayMap map = rooms.mapOf(true);
  EXPECT_EQ(rooms.countWrong(map), 0U); // scans would stand at one place and contradict each other
}

TEST(HotelRooms, areNotLaidOntoEachOtherThoughNothingContradicts)
{
  MisleadingBuilding hotel("hotel_corridor", "ouster_os1_128", 40000, {1, 3, 4, 5, 7, 8, 9, 11, 12, 13, 15, 16});
  EXPECT_GT(hotel.countWrong(hotel.mapOf(false)), 0U);
  const MultiwayMap map = hotel.mapOf(true);
  EXPECT_EQ(hotel.countWrong(map), 0U); // scans of the corridor say another place for each
  EXPECT_EQ(map.placed, 8U);            // and are placed
  // What a person knows of one scan says nothing of the others, of two nothing but how they stand to each other.
  EXPECT_EQ(hotel.countWrong(hotel.mapOf(true, {}, {0})), 0U);
  for (const auto& [i, j] : {std::pair<std::size_t, std::size_t>(0, 1), {4, 5}, {10, 11}}) {
    const MultiwayMap mended = hotel.mapOf(true, {{static_cast<int>(i), static_cast<int>(j)}});
    EXPECT_EQ(hotel.countWrong(mended), 0U) << i << " " << j;
    EXPECT_EQ(mended.scans[i].component, mended.scans[j].component);
  }
}

TEST(StoreysAlike, standWhereApproximatePosesSay)
{
  // Two storeys of three stations; links are looked for without poses here, and most lay the one onto the other.
  MisleadingBuilding tower("tower", "leica_p20", 15000, {0, 1, 2, 6, 7, 8});
  EXPECT_GT(tower.countWrong(tower.mapOf(false)), 0U);
  const MultiwayMap map = tower.mapOf(true, {}, {0, 1, 2, 3, 4, 5});
  EXPECT_EQ(tower.countWrong(map), 0U);
  EXPECT_EQ(map.placed, 4U); // by links that are right
  EXPECT_NE(map.scans[0].component, map.scans[3].component);
}

/// Of pairs that see furniture of each other where the scans are put by \p poses.
double
shareAlike(const std::vector<PreparedScan>& scans, const std::vector<Eigen::Isometry3d>& poses)
{
  const MultiwayOptions options;
  std::vector<Furniture> furniture;
  for (const PreparedScan& scan : scans)
    furniture.push_back(furnitureOf(scan, options));
  std::vector<FurnitureEvidence> evidence;
  for (std::size_t s = 0; s < scans.size(); ++s)
    for (std::size_t t = s + 1; t < scans.size(); ++t)
      evidence.push_back(
          furnitureAt(scans[s], furniture[s], scans[t], furniture[t], poses[t].inverse() * poses[s], options));
  return shareOfPlacesAlike(evidence, options.furniture);
}

TEST(OnePlace, isNotTakenForPlacesAlikeThoughSixteenRingsSeeLittleOfWhatOthersSee)
{
  const std::vector<std::pair<std::string, std::uint64_t>> places = {{"hall", 41}, {"hall", 42}, {"apartment", 42}};
  for (const char* sensor : {"velodyne_vlp16", "velodyne_hdl32e"})
    for (const auto& [scene, seed] : places) {
      SCOPED_TRACE(scene + ", " + sensor + ", seed " + std::to_string(seed));
      simulation::DatasetPlan plan = testing::planScans(scene, sensor, 10, 0, seed);
      plan.points = 40000;
      plan.movables.people = 1;
      plan.trajectory.overlap = 0.4;
      std::vector<PreparedScan> scans;
      std::vector<Eigen::Isometry3d> poses;
      for (const testing::PosedScan& scan : testing::takeScans(plan)) {
        scans.push_back(prepareScan(testing::viewOfPoints(scan.points), pairOptions(MultiwayOptions())));
        poses.push_back(scan.T_world_scan);
      }
      const FurnitureConfig config;
      EXPECT_LT(shareAlike(scans, poses), config.least_false);
      // Every second scan laid 0.8 m off is found.
      for (std::size_t i = 0; i < poses.size(); i += 2)
        poses[i] = Eigen::Translation3d(0.8, 0, 0) * poses[i];
      EXPECT_GT(shareAlike(scans, poses), config.least_false);
    }
}

} // namespace
} // namespace pcl_ssfr::test_multiway_misleading
