// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// A building made to mislead, from its scans to the map: bays of a hall that are alike but for what stands there.

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <apps/simulation/dataset_simulation.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scan_simulation.h>

#include <gmock/gmock.h>

#include <algorithm>

namespace pcl_ssfr::test_multiway_misleading {
namespace {

/// Eight scans of a hall whose bays are alike, each in the frame of its sensor.
class BaysAlike : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    simulation::DatasetPlan plan;
    plan.scene = "plant_hall";
    plan.sensor = "leica_p20";
    plan.points = 15000;
    plan.at_stations = true;
    const simulation::PreparedPlan prepared = simulation::prepare(plan, 0);
    for (const std::size_t i : {0, 2, 3, 4, 5, 9, 10, 11}) {
      const Eigen::Isometry3d& T = prepared.T_world_sensor.at(i);
      const simulation::RayCaster caster(simulation::surfacesAt(prepared.scene, plan.movables, plan.seed, i));
      simulation::ScanOptions options;
      options.seed = plan.seed;
      options.scan = i;
      scans_.push_back(simulation::simulateScan(caster, prepared.sensorOf(i), T, options).points);
      truth_.push_back(T);
    }
  }
  static void
  TearDownTestSuite()
  {
    scans_.clear();
    truth_.clear();
  }

  static MultiwayMap
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
    return registration.run();
  }

  /// Placed scans that are not within 2 degrees and 0.3 m of where most scans of their component are.
  static std::size_t
  countWrong(const MultiwayMap& map)
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

  static inline std::vector<std::vector<Eigen::Vector3f>> scans_;
  static inline std::vector<Eigen::Isometry3d> truth_;
};

TEST_F(BaysAlike, areNotLaidOntoEachOtherAndWhatIsSureIsPlaced)
{
  const MultiwayMap misled = mapOf(false);
  EXPECT_GT(countWrong(misled), 0U); // without the test for places alike
  const MultiwayMap map = mapOf(true);
  EXPECT_EQ(countWrong(map), 0U);
  EXPECT_EQ(map.placed, 8U); // by links that contradict nearly nothing
}

} // namespace
} // namespace pcl_ssfr::test_multiway_misleading
