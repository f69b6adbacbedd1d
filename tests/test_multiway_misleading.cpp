// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Buildings made to mislead, from their scans to the map: bays, rooms and storeys that are alike.

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <apps/simulation/dataset_simulation.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scan_simulation.h>

#include <link_cache.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace pcl_ssfr::test_multiway_misleading {
namespace {

/// Scans at stations of a building whose parts are alike, each in the frame of its sensor.
class MisleadingBuilding {
public:
  /// \param[in] stations empty: all
  MisleadingBuilding(const std::string& scene,
                     const std::string& sensor,
                     std::size_t points,
                     std::vector<std::size_t> stations = {})
  {
    simulation::DatasetPlan plan;
    plan.scene = scene;
    plan.sensor = sensor;
    plan.points = points;
    plan.at_stations = true;
    const simulation::PreparedPlan prepared = simulation::prepare(plan, 0);
    if (stations.empty()) {
      stations.resize(prepared.T_world_sensor.size());
      std::iota(stations.begin(), stations.end(), std::size_t{0});
    }
    for (const std::size_t i : stations) {
      const Eigen::Isometry3d& T = prepared.T_world_sensor.at(i);
      const simulation::RayCaster caster(simulation::surfacesAt(prepared.scene, plan.movables, plan.seed, i));
      simulation::ScanOptions options;
      options.seed = plan.seed;
      options.scan = i;
      scans_.push_back(simulation::simulateScan(caster, prepared.sensorOf(i), T, options).points);
      truth_.push_back(T);
    }
  }

  /// A pair is linked once for all maps: the test for places alike comes after all links.
  /// \param[in] check look for places alike
  MultiwayMap
  mapOf(bool check)
  {
    MultiwayOptions options;
    options.alias.check = check;
    MultiwayRegistration registration(options);
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      ScanView view;
      view.xyz = scans_[i].front().data();
      view.size = scans_[i].size();
      registration.addScan("s" + std::to_string(i), view);
    }
    links_.serve(registration, options);
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
              const Eigen::Isometry3d error = (truth_[i].inverse() * truth_[j]).inverse() *
                                              (map.scans[i].T_map_scan.inverse() * map.scans[j].T_map_scan);
              return error.translation().norm() < 0.3 && Eigen::AngleAxisd(error.linear()).angle() < 0.035;
            })));
      wrong += members.size() - most;
    }
    return wrong;
  }

private:
  std::vector<std::vector<Eigen::Vector3f>> scans_;
  std::vector<Eigen::Isometry3d> truth_;
  testing::LinkCache links_;
};

TEST(BaysAlike, areNotLaidOntoEachOtherAndWhatIsSureIsPlaced)
{
  MisleadingBuilding hall("plant_hall", "leica_p20", 15000, {0, 2, 3, 4, 5, 9, 10, 11});
  EXPECT_GT(hall.countWrong(hall.mapOf(false)), 0U); // without the test for places alike
  const MultiwayMap map = hall.mapOf(true);
  EXPECT_EQ(hall.countWrong(map), 0U);
  EXPECT_EQ(map.placed, 8U); // by links that contradict nearly nothing
}

TEST(RoomsAlike, areNotLaidOntoEachOther)
{
  MisleadingBuilding rooms("rooms_with_doors", "hokuyo_utm30lx", 40000);
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
}

} // namespace
} // namespace pcl_ssfr::test_multiway_misleading
