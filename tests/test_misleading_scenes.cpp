// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/dataset_simulation.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scene_builder.h>
#include <apps/simulation/scenes.h>
#include <apps/simulation/simulation_error.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

// Buildings whose parts repeat, rooms behind doors, traffic, and scans that are taken at stations.
namespace pcl_ssfr::simulation::test_misleading_scenes {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

using Corner = std::array<float, 3>;
using Triangles = std::multiset<std::array<Corner, 3>>;

/// A part of a scene: an upright box, and the motion that lays it on the first of its kind.
struct Part {
  Eigen::AlignedBox3d box;
  Vector3d foot;
  bool half_turn;
};

/// The triangles that lie in the part, moved to the first one of its kind; exact, as all is on a binary grid.
Triangles
trianglesOf(const SurfaceModel& model, const Part& part)
{
  Triangles all;
  for (const auto& triangle : model.mesh.triangles) {
    std::array<Corner, 3> corners{};
    bool inside = true;
    for (std::size_t k = 0; k < 3 && inside; ++k) {
      const Vector3d v = model.mesh.vertices[triangle[k]].cast<double>();
      inside = part.box.contains(v);
      const Vector3d local = v - part.foot;
      const double sign = part.half_turn ? -1 : 1;
      corners.at(k) = {static_cast<float>(sign * local.x() + 0.0),
                       static_cast<float>(sign * local.y() + 0.0),
                       static_cast<float>(local.z())};
    }
    if (!inside)
      continue;
    std::sort(corners.begin(), corners.end());
    all.insert(corners);
  }
  return all;
}

/// What repeats in a scene, well inside the parts: what lies across their borders belongs to none of them.
std::vector<Part>
partsOf(const std::string& scene)
{
  constexpr double kIn = 0.01;
  std::vector<Part> all;
  const auto add = [&](const Vector3d& foot, const Vector3d& low, const Vector3d& high, bool half_turn = false) {
    const Vector3d a = half_turn ? Vector3d(-high.x(), -high.y(), low.z()) : low;
    const Vector3d b = half_turn ? Vector3d(-low.x(), -low.y(), high.z()) : high;
    all.push_back({{foot + a, foot + b}, foot, half_turn});
  };
  if (scene == "tower")
    for (const double z : {3.5, 7.0}) // those that have a storey below and one above
      add({0, 0, z}, {-1, -1, kIn}, {21, 14, 3.2 - kIn});
  if (scene == "hotel_corridor")
    for (int i = 0; i < 3; ++i) {
      add({3.875 * i, 0.9375, 0}, {0.1, 0.1, kIn}, {3.7, 6.2, 2.7});
      add({3.875 * (i + 1), -0.9375, 0}, {0.1, 0.1, kIn}, {3.7, 6.2, 2.7}, true);
    }
  if (scene == "twin_wings")
    for (const double y : {0.0, 25.0})
      add({0, y, 0}, {0.5, -5.5, kIn}, {16.4, 5.5, 3.0 - kIn});
  if (scene == "plant_hall")
    for (int i = 1; i < 7; ++i)
      add({6.0 * i, 0, 0}, {0.45, -11, kIn}, {5.9, 11, 5.0});
  if (scene == "car_park_levels")
    for (const double z : {0.0, 3.0}) // those with a level above
      add({0, 0, z}, {0.5, 0.5, kIn}, {13.5, 31.5, 2.75});
  return all;
}

/// What does not move, and loose things where they stand; the leaves of doors stand at angles, off the grid.
SurfaceModel
withoutDoors(Scene scene)
{
  scene.doors.clear();
  return surfacesAt(scene, {}, 1, 0);
}

class RepeatingScene : public ::testing::TestWithParam<std::string> {};

TEST_P(RepeatingScene, RepeatsToTheLastBitWhenAsked)
{
  const std::vector<Part> parts = partsOf(GetParam());
  ASSERT_GE(parts.size(), 2U);
  for (const std::uint64_t seed : {1, 2}) {
    SceneOptions options;
    options.alike = true;
    const SurfaceModel alike = withoutDoors(makeScene(GetParam(), seed, options));
    const SurfaceModel usual = withoutDoors(makeScene(GetParam(), seed));
    const Triangles first = trianglesOf(alike, parts.front());
    const Triangles usual_first = trianglesOf(usual, parts.front());
    EXPECT_GT(first.size(), 150U);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", part " + std::to_string(i));
      EXPECT_TRUE(first == trianglesOf(alike, parts[i]));
      // Otherwise walls are the same, and what people brought is not.
      const Triangles other = trianglesOf(usual, parts[i]);
      std::vector<std::array<Corner, 3>> shared;
      std::set_intersection(
          other.begin(), other.end(), usual_first.begin(), usual_first.end(), std::back_inserter(shared));
      EXPECT_GT(shared.size(), 30U);
      EXPECT_FALSE(usual_first == other);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         RepeatingScene,
                         ::testing::Values("tower", "hotel_corridor", "twin_wings", "plant_hall", "car_park_levels"),
                         [](const auto& suite) { return suite.param; });

TEST(SceneOptions, AreRefusedWhereTheyMeanNothing)
{
  const auto error = [](const char* scene, int storeys, bool alike) -> std::string {
    try {
      makeScene(scene, 1, {storeys, alike});
    }
    catch (const SimulationError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(error("hall", 3, false), AllOf(HasSubstr("storeys is 3"), HasSubstr("'hall'"), HasSubstr("tower")));
  EXPECT_THAT(error("campus", 0, true), AllOf(HasSubstr("alike"), HasSubstr("'campus'"), HasSubstr("twin_wings")));
  EXPECT_THAT(error("tower", 1, false), HasSubstr("storeys is 1, needs 2 to"));
  EXPECT_THAT(error("tower", 21, false), HasSubstr("storeys is 21"));
}

TEST(Tower, HasAsManyStoreysAsAsked)
{
  for (const char* name : {"tower", "car_park_levels"}) {
    const double storey = std::string(name) == "tower" ? 3.5 : 3.0;
    for (const int storeys : {2, 5}) {
      const Scene scene = makeScene(name, 1, {storeys, false});
      double top = 0;
      for (const Vector3d& point : scene.path)
        top = std::max(top, point.z());
      EXPECT_NEAR(top, storey * (storeys - 1), 1e-9) << name;
      EXPECT_GT(boundsOf(scene.surfaces).max().z(), storey * (storeys - 1) + 1) << name;
      EXPECT_LT(boundsOf(scene.surfaces).max().z(), storey * storeys + 0.5) << name;
    }
  }
}

const std::vector<std::string> kStationScenes = {
    "tower", "hotel_corridor", "twin_wings", "plant_hall", "rooms_with_doors", "car_park_levels"};

TEST(Stations, AreAlongTheWalkInFreeSpaceAndInView)
{
  for (const std::string& name : kStationScenes)
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      DatasetPlan plan;
      plan.scene = name;
      plan.sensor = "leica_p20";
      plan.at_stations = true;
      plan.beams = 20000;
      plan.seed = seed;
      const PreparedPlan prepared = prepare(plan, 1);
      const Scene& scene = prepared.scene;
      ASSERT_GE(scene.stations.size(), 8U);
      ASSERT_EQ(prepared.T_world_sensor.size(), scene.stations.size());
      EXPECT_TRUE(std::is_sorted(scene.stations.begin(), scene.stations.end()));
      const RayCaster caster(surfacesAt(scene, {}, seed, 0));
      for (std::size_t i = 0; i < prepared.T_world_sensor.size(); ++i) {
        const Vector3d& eye = prepared.T_world_sensor[i].translation();
        const auto below = caster.cast(eye, -Vector3d::UnitZ(), 3);
        ASSERT_TRUE(below) << i;
        EXPECT_NEAR(below->distance, 1.6, 0.25) << i;
        for (int k = 0; k < 64; ++k) {
          const Vector3d direction(std::cos(M_PI * k / 32), std::sin(M_PI * k / 32), 0);
          const auto hit = caster.cast(eye, direction, 1);
          EXPECT_TRUE(!hit || hit->distance > 0.35) << i;
        }
        // Somebody else sees a part of what is seen from here.
        double most = 0;
        for (std::size_t j = 0; j < prepared.T_world_sensor.size(); ++j)
          if (i != j)
            most = std::max(
                most,
                visibleOverlap(
                    caster, prepared.sensors.front(), prepared.T_world_sensor[i], prepared.T_world_sensor[j], 300));
        EXPECT_GT(most, name == "rooms_with_doors" ? 0.03 : 0.1) << i;
      }
    }
}

TEST(Stations, MoreScansStandBetweenThem)
{
  Scene scene;
  scene.name = "line";
  scene.path = {{0, 0, 0}, {12, 0, 0}};
  scene.stations = {0, 8, 12};
  scene.surfaces.addBlock({0, 5, 0}, {1, 1, 1}, 0, scene.surfaces.addMaterial("any", 0.5));
  TrajectoryOptions options;
  options.scans = 9;
  const RayCaster caster(scene.surfaces);
  const auto poses = makeTrajectory(scene, caster, makeSensor("velodyne_vlp16"), options);
  const std::array<double, 9> expected = {0, 8, 12, 4, 10, 2, 9, 6, 11};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(poses[i].translation().x(), expected.at(i), 1e-12) << i;
  options.step = 1; // as asked
  EXPECT_NEAR(makeTrajectory(scene, caster, makeSensor("velodyne_vlp16"), options)[1].translation().x(), 1, 1e-12);
  scene.stations = {5};
  options.step = 0;
  for (const Eigen::Isometry3d& pose : makeTrajectory(scene, caster, makeSensor("velodyne_vlp16"), options))
    EXPECT_NEAR(pose.translation().x(), 5, 1e-12);
}

TEST(Stations, AskingForThemWhereThereAreNoneIsAnError)
{
  DatasetPlan plan;
  plan.scene = "hall";
  plan.at_stations = true;
  try {
    prepare(plan, 1);
    FAIL();
  }
  catch (const SimulationError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("hall"), HasSubstr("stations")));
  }
}

TEST(Doors, ThatAreShutStayShutInEveryScan)
{
  // Behind shut doors neighbours see nothing of each other.
  const Scene scene = makeScene("rooms_with_doors", 2);
  ASSERT_EQ(scene.doors.size(), 7U);
  MovableOptions options;
  const auto sights = [&](std::size_t scan) {
    const RayCaster caster(surfacesAt(scene, options, 5, scan));
    std::vector<bool> seen;
    for (const Door& door : scene.doors) {
      const Vector3d along(std::cos(door.closed_yaw), std::sin(door.closed_yaw), 0);
      const Vector3d across(-along.y(), along.x(), 0);
      const Vector3d middle = door.hinge + 0.5 * door.size.x() * along + Vector3d(0, 0, 1.3);
      seen.push_back(caster.isVisible(middle - 0.6 * across, middle + 0.6 * across));
    }
    return seen;
  };
  EXPECT_EQ(sights(0), std::vector<bool>(7, true));
  options.shut_doors = 1;
  EXPECT_EQ(sights(0), std::vector<bool>(7, false));
  options.shut_doors = 0.5;
  const std::vector<bool> half = sights(0);
  EXPECT_EQ(sights(3), half);
  const auto open = std::count(half.begin(), half.end(), true);
  EXPECT_GT(open, 0);
  EXPECT_LT(open, 7);
  options.shut_doors = 1.5;
  EXPECT_THROW(surfacesAt(scene, options, 5, 0), SimulationError);
}

TEST(Traffic, IsElsewhereInEveryScanAndKeepsToItsLane)
{
  const Scene scene = makeScene("tree_road", 1);
  const auto drives = std::count_if(
      scene.loose_items.begin(), scene.loose_items.end(), [](const LooseItem& item) { return item.drives; });
  EXPECT_GE(drives, 4);
  EXPECT_LT(drives, static_cast<long>(scene.loose_items.size())); // others are parked
  const SurfaceModel first = surfacesAt(scene, {}, 1, 0);
  const SurfaceModel second = surfacesAt(scene, {}, 1, 1);
  ASSERT_EQ(first.mesh.vertices.size(), second.mesh.vertices.size());
  std::size_t moved = 0;
  for (std::size_t i = scene.surfaces.mesh.vertices.size(); i < first.mesh.vertices.size(); ++i)
    moved += first.mesh.vertices[i] != second.mesh.vertices[i] ? 1U : 0U;
  EXPECT_GT(moved, 100U * static_cast<std::size_t>(drives) / 2);
  for (const LooseItem& item : scene.loose_items)
    if (item.drives) {
      EXPECT_LT((item.area.upper - item.area.lower).y(), 3.4);
    }
}

TEST(SeveralSensors, TakeScansInTurn)
{
  DatasetPlan plan;
  plan.scene = "campus";
  plan.sensor = "ouster_os1_128,livox_avia";
  plan.trajectory.scans = 4;
  plan.trajectory.step = 6;
  plan.start = 1;
  plan.beams = 6000;
  const PreparedPlan prepared = prepare(plan, 1);
  ASSERT_EQ(prepared.sensors.size(), 2U);
  EXPECT_EQ(prepared.plan.name, "campus_ouster_os1_128_livox_avia");
  EXPECT_EQ(prepared.sensorOf(0).name, "livox_avia"); // the first scan is left out
  EXPECT_EQ(prepared.sensorOf(1).name, "ouster_os1_128");
  // Each at its own height above the same walk.
  plan.sensor = "livox_avia";
  const PreparedPlan one = prepare(plan, 1);
  EXPECT_EQ(prepared.T_world_sensor[2].matrix(), one.T_world_sensor[2].matrix());
  EXPECT_NEAR(prepared.T_world_sensor[1].translation().z() - one.T_world_sensor[1].translation().z(), 0.1, 1e-9);
}

TEST(OverlapOfUnlikeSensors, IsThatOfTheTargetsOwnView)
{
  // A sensor that looks ahead sees a third of what one all round sees, which sees nearly all of the former.
  const Scene scene = makeScene("plant_hall", 1);
  const RayCaster caster(surfacesAt(scene, {}, 1, 0));
  const SensorModel ahead = makeSensor("aeva_aeries2");
  const SensorModel round = makeSensor("ouster_os1_128");
  Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
  at.translation() = Vector3d(20, 0, 1.8);
  EXPECT_GT(visibleOverlap(caster, ahead, round, at, at), 0.97);
  EXPECT_LT(visibleOverlap(caster, round, ahead, at, at), 0.4);
  EXPECT_GT(visibleOverlap(caster, round, ahead, at, at), 0.1);
  EXPECT_EQ(visibleOverlap(caster, round, round, at, at), visibleOverlap(caster, round, at, at));
}

TEST(AppendScene, MovesDoorsAreasAndThings)
{
  Scene part;
  part.surfaces.addBlock({1, 2, 0}, {0.5, 0.25, 1}, 0, part.surfaces.addMaterial("any", 0.5));
  part.doors.push_back({{1, 0, 0}, 0.2, 1.5, {0.9, 0.04, 2}});
  part.walk_areas.push_back({{0, 1, 0}, {2, 4, 0}});
  LooseItem item;
  item.surfaces.addBlock({0.25, 0, 0}, {0.5, 0.1, 1}, 0, item.surfaces.addMaterial("any", 0.5));
  item.place = Vector3d(1.5, 3, 0);
  item.area = part.walk_areas.front();
  part.loose_items.push_back(item);
  Scene scene;
  appendScene(scene, part, {10, 20, 3}, true);
  EXPECT_TRUE(scene.doors.at(0).hinge.isApprox(Vector3d(9, 20, 3)));
  EXPECT_NEAR(scene.doors.at(0).closed_yaw, 0.2 + M_PI, 1e-12);
  EXPECT_TRUE(scene.walk_areas.at(0).lower.isApprox(Vector3d(8, 16, 3)));
  EXPECT_TRUE(scene.walk_areas.at(0).upper.isApprox(Vector3d(10, 19, 3)));
  EXPECT_TRUE(scene.loose_items.at(0).place.isApprox(Vector3d(8.5, 17, 3)));
  EXPECT_NEAR(boundsOf(scene.loose_items.at(0).surfaces).min().x(), -0.5, 1e-6);
  EXPECT_TRUE(boundsOf(scene.surfaces).center().isApprox(Vector3d(9, 18, 3.5), 1e-6));
}

TEST(Snap, PutsEverythingOnTheGrid)
{
  Scene scene;
  scene.surfaces.addBlock({1.0 / 3, 0.1, 0.7}, {0.3, 0.3, 0.3}, 0.3, scene.surfaces.addMaterial("any", 0.5));
  scene.surfaces.tubes.push_back({{0.1, 0.2, 0.3}, Vector3d::UnitZ(), 1, 0.1, 0});
  const Scene before = scene;
  snap(scene);
  for (std::size_t i = 0; i < scene.surfaces.mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& vertex = scene.surfaces.mesh.vertices[i];
    EXPECT_TRUE((vertex * 8192).array().isApprox((vertex * 8192).array().round()));
    EXPECT_LT((vertex - before.surfaces.mesh.vertices[i]).cwiseAbs().maxCoeff(), 0.6 / 8192);
  }
  EXPECT_NEAR(scene.surfaces.tubes[0].base.x(), 0.1, 0.5 / 8192);
  EXPECT_EQ(onGrid(scene.surfaces.tubes[0].base.x()), scene.surfaces.tubes[0].base.x());
  EXPECT_EQ(onGrid(3.875), 3.875);
}

} // namespace
} // namespace pcl_ssfr::simulation::test_misleading_scenes
