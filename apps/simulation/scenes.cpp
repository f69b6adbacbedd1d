// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scenes.h>

#include "common/angles.h"

#include <apps/common/random_stream.h>
#include <apps/simulation/footprint.h>
#include <apps/simulation/mesh_file.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_parts.h>
#include <apps/simulation/simulation_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>

namespace pcl_ssfr::simulation {

namespace {

using Maker = Scene (*)(std::uint64_t seed, const SceneOptions& options);

struct SceneEntry {
  const char* name;
  Maker make;
  bool has_storeys; ///< SceneOptions::storeys means something
  bool repeats;     ///< so does SceneOptions::alike
};

/// A scene without options.
template <Scene (*Make)(std::uint64_t)>
Scene
plain(std::uint64_t seed, const SceneOptions& /*options*/)
{
  return Make(seed);
}

constexpr std::array<SceneEntry, 21> kScenes = {{
    {"basic_model", plain<makeBasicModel>, false, false},
    {"apartment", plain<makeApartment>, false, false},
    {"office_floor", plain<makeOfficeFloor>, false, false},
    {"hall", plain<makeHall>, false, false},
    {"street", plain<makeStreet>, false, false},
    {"endless_corridor", plain<makeEndlessCorridor>, false, false},
    {"symmetric_room", plain<makeSymmetricRoom>, false, false},
    {"cylinder_hall", plain<makeCylinderHall>, false, false},
    {"slanted", plain<makeSlanted>, false, false},
    {"cave", plain<makeCave>, false, false},
    {"two_floors_alike", plain<makeTwoFloorsAlike>, false, false},
    {"tower", makeTower, true, true},
    {"hotel_corridor", makeHotelCorridor, false, true},
    {"twin_wings", makeTwinWings, false, true},
    {"plant_hall", makePlantHall, false, true},
    {"rooms_with_doors", plain<makeRoomsWithDoors>, false, false},
    {"campus", plain<makeCampus>, false, false},
    {"tree_road", plain<makeTreeRoad>, false, false},
    {"industrial_site", plain<makeIndustrialSite>, false, false},
    {"car_park_levels", makeCarParkLevels, true, true},
    {"forest_edge", plain<makeForestEdge>, false, false},
}};

// What moves.
constexpr double kSensorGap = 0.5;    // nothing that moves comes nearer to a sensor [m]
constexpr double kPersonRadius = 0.3; // makePerson() keeps within it [m]
constexpr double kPersonHeight = 2;   // [m]
constexpr double kHandle = 0.05;      // a door's handles stand out so far [m]
constexpr int kTries = 100;
// Streams of random numbers of one scan.
constexpr std::uint64_t kOrderStream = 0;
constexpr std::uint64_t kDoorStream = 1;
constexpr std::uint64_t kShutStream = 0x73687574ULL; // of the doors, whatever the scan
constexpr std::uint64_t kItemStream = 1ULL << 32U;
constexpr std::uint64_t kPersonStream = 2ULL << 32U;

/// Whether a thing meets none of the others and keeps its distance from the sensors.
bool
isClear(const Footprint& thing, const std::vector<Footprint>& taken, const std::vector<Eigen::Vector3d>& sensors)
{
  return std::none_of(taken.begin(), taken.end(), [&](const Footprint& other) { return meet(thing, other); }) &&
         std::all_of(sensors.begin(), sensors.end(), [&](const Eigen::Vector3d& sensor) {
           return distance(thing, sensor.head<2>(), sensor.head<2>()) >= kSensorGap;
         });
}

/// A point of the area at least so far inside it, or nothing when it is too small.
std::optional<Eigen::Vector3d>
pointIn(const WalkArea& area, const Eigen::Vector2d& margin, RandomStream& random)
{
  const Eigen::Vector2d lower = area.lower.head<2>() + margin;
  const Eigen::Vector2d upper = area.upper.head<2>() - margin;
  if ((lower.array() > upper.array()).any())
    return std::nullopt;
  const double x = random.uniform(lower.x(), upper.x());
  return Eigen::Vector3d(x, random.uniform(lower.y(), upper.y()), area.lower.z());
}

/// Somewhere in its area; where it cannot be rotated freely, it stands as before or the other way round.
std::optional<std::pair<Eigen::Vector3d, double>>
newPlaceOf(const LooseItem& item, RandomStream& random)
{
  const Eigen::AlignedBox3d box = boundsOf(item.surfaces);
  const Eigen::Vector2d half = box.min().head<2>().cwiseAbs().cwiseMax(box.max().head<2>().cwiseAbs());
  double yaw = random.uniform(-kPi, kPi);
  Eigen::Vector2d margin = Eigen::Vector2d::Constant(half.norm());
  if ((2 * margin.array() > (item.area.upper - item.area.lower).head<2>().array()).any()) {
    yaw = item.yaw + (random.uniform() < 0.5 ? 0 : kPi);
    margin = Eigen::Rotation2Dd(yaw).toRotationMatrix().cwiseAbs() * half;
  }
  const auto place = pointIn(item.area, margin, random);
  if (!place)
    return std::nullopt;
  return std::make_pair(*place, yaw);
}

SurfaceModel
leafOf(const Door& door)
{
  SurfaceModel leaf;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(door.size.x() / 2, 0, door.size.z() / 2);
  leaf.addBox(T, door.size, parts::paint(leaf, parts::Stuff::Wood));
  constexpr double kHandleHeight = 1.03;
  if (door.size.z() > kHandleHeight + 0.1 && door.size.x() > 0.3) {
    T.translation() = Eigen::Vector3d(door.size.x() - 0.1, 0, kHandleHeight);
    leaf.addBox(T, {0.12, door.size.y() + 2 * kHandle, 0.025}, parts::paint(leaf, parts::Stuff::Metal));
  }
  return leaf;
}

bool
isLeafClear(const Door& door, double yaw, const std::vector<Eigen::Vector3d>& sensors)
{
  const Eigen::Vector2d axis(std::cos(yaw), std::sin(yaw));
  const double gap = kSensorGap + door.size.y() / 2 + kHandle;
  return std::all_of(sensors.begin(), sensors.end(), [&](const Eigen::Vector3d& sensor) {
    const Eigen::Vector2d to = sensor.head<2>() - door.hinge.head<2>();
    const double along = std::clamp(to.dot(axis), 0.0, door.size.x());
    return (to - along * axis).norm() >= gap;
  });
}

void
requireValid(const MovableOptions& options)
{
  std::ostringstream text;
  if (options.people < 0)
    text << "people is " << options.people << ", needs 0 or more";
  else if (!(options.moved_furniture >= 0 && options.moved_furniture <= 1))
    text << "moved_furniture is " << options.moved_furniture << ", needs a share in [0, 1]";
  else if (!(options.shut_doors >= 0 && options.shut_doors <= 1))
    text << "shut_doors is " << options.shut_doors << ", needs a share in [0, 1]";
  else
    return;
  throw SimulationError(text.str());
}

/// Names of the scenes with an option.
std::string
scenesWith(bool SceneEntry::*option)
{
  std::string names;
  for (const SceneEntry& entry : kScenes)
    if (entry.*option)
      names += (names.empty() ? "" : ", ") + std::string(entry.name);
  return names;
}

void
requireValid(const SceneEntry& entry, const SceneOptions& options)
{
  const std::string scene = std::string("scene '") + entry.name + "'";
  if (options.storeys != 0 && !entry.has_storeys)
    throw SimulationError("storeys is " + std::to_string(options.storeys) + ", but " + scene +
                          " has none to choose; these have: " + scenesWith(&SceneEntry::has_storeys));
  if (options.storeys != 0 && (options.storeys < 2 || options.storeys > kMostStoreys))
    throw SimulationError("storeys is " + std::to_string(options.storeys) + ", needs 2 to " +
                          std::to_string(kMostStoreys));
  if (options.alike && !entry.repeats)
    throw SimulationError("alike: nothing repeats in " + scene + "; it does in " + scenesWith(&SceneEntry::repeats));
}

// The path through a mesh of the user.
constexpr double kMeshSensorHeight = 1.2;                       // [m]
constexpr std::array<double, 3> kMeshHeights = {0.4, 1.2, 1.8}; // free above the floor [m]
constexpr double kMeshMargin = 0.5;                             // free on all sides of the path [m]
constexpr double kMeshReach = 60;                               // longest half of a path [m]
constexpr int kMeshGrid = 21;                                   // places tried along x and y
constexpr int kMeshDirections = 16;                             // directions tried at each, over a full turn
constexpr double kFloorBin = 0.1;                               // [m]
constexpr double kFloorStep = 0.3;                              // the floor may differ so much along the path [m]

/// Height at which most level area lies in the lower part of a mesh.
double
floorHeight(const SurfaceModel& model, const Eigen::AlignedBox3d& box)
{
  constexpr double kLevel = 0.9;                  // least vertical part of the normal
  constexpr double kLowerPart = 0.4;              // of the height
  std::map<long, std::pair<double, double>> bins; // area, area times height
  const double limit = box.min().z() + std::max(kFloorBin, kLowerPart * box.sizes().z());
  for (const auto& triangle : model.mesh.triangles) {
    const Eigen::Vector3d a = model.mesh.vertices[triangle[0]].cast<double>();
    const Eigen::Vector3d b = model.mesh.vertices[triangle[1]].cast<double>();
    const Eigen::Vector3d c = model.mesh.vertices[triangle[2]].cast<double>();
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const double height = (a.z() + b.z() + c.z()) / 3;
    if (std::abs(normal.z()) < kLevel * normal.norm() || height > limit)
      continue;
    auto& bin = bins[std::lround(std::floor(height / kFloorBin))];
    bin.first += normal.norm() / 2;
    bin.second += height * normal.norm() / 2;
  }
  double height = box.min().z();
  double most = 0;
  for (const auto& [index, bin] : bins)
    if (bin.first > most) {
      most = bin.first;
      height = bin.second / bin.first;
    }
  return height;
}

/// The floor below a point at sensor height, when it is where a floor is expected.
std::optional<double>
floorBelow(const RayCaster& caster, const Eigen::Vector2d& at, double expected)
{
  const Eigen::Vector3d eye(at.x(), at.y(), expected + kMeshSensorHeight);
  const auto hit = caster.cast(eye, -Eigen::Vector3d::UnitZ(), kMeshSensorHeight + kFloorStep);
  if (!hit || hit->distance < kMeshSensorHeight - kFloorStep)
    return std::nullopt;
  return eye.z() - hit->distance;
}

/// Free length from a place in a direction, for something as wide and high as a person with a sensor.
double
freeLength(const RayCaster& caster, const Eigen::Vector2d& at, double floor, double angle)
{
  const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector3d aside(-direction.y(), direction.x(), 0);
  double length = kMeshReach;
  for (const double height : kMeshHeights)
    for (const double offset : {-0.8 * kMeshMargin, 0.0, 0.8 * kMeshMargin}) {
      const Eigen::Vector3d from = Eigen::Vector3d(at.x(), at.y(), floor + height) + offset * aside;
      if (const auto hit = caster.cast(from, direction, length + kMeshMargin))
        length = std::min(length, hit->distance - kMeshMargin);
    }
  return std::max(0.0, length);
}

/// The points of the path from a place in a direction, the place itself left out, as far as there is floor.
std::vector<Eigen::Vector3d>
walk(const RayCaster& caster, const Eigen::Vector2d& at, double floor, double angle, double length)
{
  constexpr double kStride = 0.5;
  std::vector<Eigen::Vector3d> points;
  double height = floor;
  for (double s = kStride; s <= length; s += kStride) {
    const Eigen::Vector2d place = at + s * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto below = floorBelow(caster, place, height);
    if (!below)
      break;
    height = *below;
    points.emplace_back(place.x(), place.y(), height);
  }
  return points;
}

/// Whether a sensor here has room about it and sees something on most sides.
bool
isInside(const RayCaster& caster, const Eigen::Vector2d& at, double floor, double reach)
{
  int seen = 0;
  for (int i = 0; i < kMeshDirections; ++i) {
    const double angle = 2 * kPi * i / kMeshDirections;
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0);
    for (const double height : kMeshHeights) {
      const auto hit = caster.cast({at.x(), at.y(), floor + height}, direction, reach);
      if (hit && hit->distance < kMeshMargin)
        return false;
      if (hit && height == kMeshSensorHeight)
        ++seen;
    }
  }
  return 2 * seen >= kMeshDirections;
}

std::vector<Eigen::Vector3d>
meshPath(const SurfaceModel& model)
{
  const RayCaster caster(model);
  const Eigen::AlignedBox3d box = boundsOf(model);
  const double floor = floorHeight(model, box);
  const double reach = std::max(1.0, box.diagonal().norm());
  std::vector<Eigen::Vector3d> best;
  double best_score = 0;
  for (int i = 1; i < kMeshGrid; ++i)
    for (int j = 1; j < kMeshGrid; ++j) {
      const Eigen::Vector2d share(static_cast<double>(i) / kMeshGrid, static_cast<double>(j) / kMeshGrid);
      const Eigen::Vector2d at = box.min().head<2>() + share.cwiseProduct(box.sizes().head<2>());
      const auto below = floorBelow(caster, at, floor);
      if (!below || !isInside(caster, at, *below, reach))
        continue;
      // Far from the middle counts less.
      const double weight = 1 - 0.5 * (share - Eigen::Vector2d(0.5, 0.5)).norm();
      for (int k = 0; k < kMeshDirections / 2; ++k) {
        const double angle = 2 * kPi * k / kMeshDirections;
        const double ahead = freeLength(caster, at, *below, angle);
        const double behind = freeLength(caster, at, *below, angle + kPi);
        if (weight * (ahead + behind + kMeshMargin) <= best_score)
          continue;
        std::vector<Eigen::Vector3d> path = walk(caster, at, *below, angle + kPi, behind);
        std::reverse(path.begin(), path.end());
        path.emplace_back(at.x(), at.y(), *below);
        for (const Eigen::Vector3d& point : walk(caster, at, *below, angle, ahead))
          path.push_back(point);
        const double score = weight * ((path.back() - path.front()).norm() + kMeshMargin);
        if (score > best_score) {
          best_score = score;
          best = std::move(path);
        }
      }
    }
  return best;
}

} // namespace

std::vector<std::string>
sceneNames()
{
  std::vector<std::string> names;
  names.reserve(kScenes.size());
  for (const SceneEntry& entry : kScenes)
    names.emplace_back(entry.name);
  return names;
}

Scene
makeScene(const std::string& name, std::uint64_t seed, const SceneOptions& options)
{
  for (const SceneEntry& entry : kScenes)
    if (name == entry.name) {
      requireValid(entry, options);
      Scene scene = entry.make(seed, options);
      scene.name = name;
      return scene;
    }
  std::string known;
  for (const SceneEntry& entry : kScenes)
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  throw SimulationError("unknown scene '" + name + "'; known are " + known);
}

Scene
makeMeshScene(const std::string& path)
{
  Scene scene;
  scene.surfaces = loadMesh(path);
  scene.name = path;
  scene.description = "mesh file " + path;
  scene.path = meshPath(scene.surfaces);
  if (scene.path.empty())
    throw SimulationError(path + ": no free place for a sensor inside (1.2 m above the floor, 0.5 m from everything, "
                                 "surfaces on most sides)");
  const double length = (scene.path.back() - scene.path.front()).norm();
  scene.natural_step = std::clamp(length / 8, 0.2, 5.0);
  scene.recommended_sensor = length > 30 ? "leica_p20" : "hokuyo_utm30lx";
  return scene;
}

SurfaceModel
surfacesAt(const Scene& scene,
           const MovableOptions& options,
           std::uint64_t seed,
           std::size_t scan,
           const std::vector<Eigen::Vector3d>& sensors)
{
  requireValid(options);
  const std::uint64_t stream = scan;
  SurfaceModel model = scene.surfaces;

  // Which things stand elsewhere: a share of a random order.
  const std::size_t items = scene.loose_items.size();
  std::vector<std::size_t> order(items);
  std::iota(order.begin(), order.end(), std::size_t{0});
  RandomStream shuffle(seed, stream, kOrderStream);
  for (std::size_t i = items; i > 1; --i)
    std::swap(order[i - 1], order[static_cast<std::size_t>(shuffle.index(static_cast<int>(i)))]);
  const auto moved = static_cast<std::size_t>(std::lround(options.moved_furniture * static_cast<double>(items)));
  std::vector<bool> moves(items, false);
  for (std::size_t i = 0; i < items; ++i)
    moves[order[i]] = i < moved || scene.loose_items[order[i]].drives;

  std::vector<Footprint> taken;
  const auto put = [&](const LooseItem& item, const Eigen::Vector3d& place, double yaw) {
    taken.push_back(footprintOf(item.surfaces, place, yaw));
    model.append(item.surfaces, parts::standAt(place, yaw));
  };
  for (std::size_t i = 0; i < items; ++i)
    if (!moves[i])
      put(scene.loose_items[i], scene.loose_items[i].place, scene.loose_items[i].yaw);
  // Each person in an area chosen by its size. They come before the things that move: those can stay where they are.
  SurfaceModel people;
  double total = 0;
  for (const WalkArea& area : scene.walk_areas)
    total += (area.upper - area.lower).head<2>().prod();
  for (int i = 0; i < options.people; ++i) {
    RandomStream random(seed, stream, kPersonStream + static_cast<std::uint64_t>(i));
    bool stands = false;
    for (int j = 0; j < kTries && !stands && total > 0; ++j) {
      double rest = random.uniform(0, total);
      std::size_t chosen = 0;
      while (chosen + 1 < scene.walk_areas.size()) {
        const WalkArea& area = scene.walk_areas[chosen];
        rest -= (area.upper - area.lower).head<2>().prod();
        if (rest < 0)
          break;
        ++chosen;
      }
      const auto place = pointIn(scene.walk_areas[chosen], Eigen::Vector2d::Constant(kPersonRadius), random);
      if (!place)
        continue;
      const Footprint ground{
          place->head<2>(), Eigen::Vector2d::Constant(kPersonRadius), 0, place->z(), place->z() + kPersonHeight};
      if (!isClear(ground, taken, sensors))
        continue;
      taken.push_back(ground);
      const double yaw = random.uniform(-kPi, kPi);
      people.append(parts::makePerson(random), parts::standAt(*place, yaw));
      stands = true;
    }
    if (!stands)
      throw SimulationError("people is " + std::to_string(options.people) + ", but scene '" + scene.name +
                            "' has room for only " + std::to_string(i) + " of them in scan " + std::to_string(scan));
  }

  for (std::size_t i = 0; i < items; ++i) {
    if (!moves[i])
      continue;
    const LooseItem& item = scene.loose_items[i];
    RandomStream random(seed, stream, kItemStream + i);
    Eigen::Vector3d place = item.place;
    double yaw = item.yaw;
    for (int j = 0; j < kTries; ++j) {
      const auto found = newPlaceOf(item, random);
      if (found && isClear(footprintOf(item.surfaces, found->first, found->second), taken, sensors)) {
        std::tie(place, yaw) = *found;
        break;
      }
    }
    put(item, place, yaw);
  }

  for (std::size_t i = 0; i < scene.doors.size(); ++i) {
    const Door& door = scene.doors[i];
    double yaw = door.closed_yaw + door.swing;
    if (RandomStream(seed, kShutStream, i).uniform() < options.shut_doors) {
      if (isLeafClear(door, door.closed_yaw, sensors))
        yaw = door.closed_yaw;
    }
    else if (options.doors_move) {
      RandomStream random(seed, stream, kDoorStream + i);
      for (int j = 0; j < kTries; ++j) {
        const double tried = door.closed_yaw + door.swing * random.uniform();
        if (isLeafClear(door, tried, sensors)) {
          yaw = tried;
          break;
        }
      }
    }
    model.append(leafOf(door), parts::standAt(door.hinge, yaw));
  }

  model.append(people);
  return model;
}

} // namespace pcl_ssfr::simulation
