// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>

#include "common/angles.h"
#include <apps/simulation/scene_rooms.h>

#include <algorithm>
#include <utility>

/// Storeys of offices on top of each other: two_floors_alike and tower.
namespace pcl_ssfr::simulation {

using namespace rooms;

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kStorey = 3.5;  // from floor to floor [m]
constexpr double kCeiling = 0.3; // thickness of slabs [m]
constexpr double h = kStorey - kCeiling;
constexpr std::uint64_t kFurnishing = 0x6675726eULL; // stream of the furniture of storeys

/// A storey with what its walk needs to know.
struct Storey {
  Scene scene;
  std::vector<Vector3d> floor;  ///< of the walk, from the far end to the stairs
  std::vector<Vector3d> stairs; ///< of the walk, to the next storey
  Rect shaft;                   ///< of the stairs
  Rect outline;                 ///< with the shaft, outer walls included
};

/** \brief Offices in the south, an open floor with two rows of columns, stairs up in the east.
 * The seed decides the walls. \param[in] furnishing 0: furniture follows from the same numbers; else from its own
 * \param[in] stairs whether they lead up from here
 */
Storey
makeStorey(std::uint64_t seed, std::uint64_t furnishing, bool stairs)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const double length = b.vary(21.5, 22.5);
  const double depth = b.vary(12.6, 13.2);
  const double offices = b.vary(4.1, 4.5);
  // Two flights of ten steps side by side, a wall between them, a landing at the far end.
  constexpr int kSteps = 10;
  constexpr double kRise = kStorey / 2 / kSteps;
  constexpr double kTread = 0.33;
  constexpr double kFlight = 1.4;  // width
  constexpr double kSpine = 0.15;  // wall between the flights
  constexpr double kLanding = 1.6; // depth
  const double foot = length + kOuter + 0.6;
  const double head = foot + kSteps * kTread;
  const double shaft = offices + 2.2; // its southern face
  const double up = shaft + kFlight / 2;
  const double down = up + kFlight + kSpine;
  const double shaft_north = shaft + 2 * kFlight + kSpine;
  const double aisle = offices + b.vary(3.2, 3.5);

  // On stairs the path follows the edges of the steps.
  const double edge = (kSteps - 1) * kTread;
  const std::vector<Vector3d> floor{{1.6, aisle, 0}, {length - 4, aisle, 0}, {length - 1.6, down, 0}};
  const std::vector<Vector3d> way_up{{length - 1.2, up, 0},
                                     {foot - kTread, up, 0},
                                     {foot + edge, up, kStorey / 2},
                                     {head + kLanding / 2, up, kStorey / 2},
                                     {head + kLanding / 2, down, kStorey / 2},
                                     {head + kTread, down, kStorey / 2},
                                     {head - edge, down, kStorey}};
  std::vector<Vector3d> path = floor;
  path.insert(path.end(), way_up.begin(), way_up.end());
  for (auto point = floor.rbegin(); point != floor.rend(); ++point)
    path.emplace_back(point->x(), point->y(), kStorey);
  b.setPath(path);

  const double o = kOuter / 2;
  const double far = head + kLanding;
  parts::addSlab(b.model(), {-kOuter, -kOuter, length + kOuter, depth + kOuter}, 0, kCeiling, {}, Stuff::Carpet);
  parts::addSlab(b.model(), {length + kOuter, shaft, foot, shaft_north}, 0, kCeiling, {}, Stuff::Concrete);
  const RoomRow row = planRow(b, length, 5);
  addRow(b, row, offices, 0, h);
  std::vector<Opening> north;
  addWindows(b, north, 0.5, length / 2);
  addWindows(b, north, length / 2, length - 0.5);
  b.addWall({{0, depth + o}, {length, depth + o}, kOuter, north, Stuff::Plaster}, 0, h);
  b.addWall(
      {{-o, -o}, {-o, depth + o}, kOuter, {{depth - 3, 1.8, 0.9, 2.3, Filling::Window, 1, false}}, Stuff::Plaster},
      0,
      h);
  b.addWall({{length + o, -o},
             {length + o, depth + o},
             kOuter,
             {{(shaft + shaft_north) / 2 + o, shaft_north - shaft, 0, 2.5, Filling::None, 1, false}},
             Stuff::Plaster},
            0,
            h);
  // The shaft, the stairs up from this floor and the landing on the way.
  b.addWall({{length + kOuter, shaft - o}, {far + o, shaft - o}, kOuter, {}, Stuff::Concrete}, -kCeiling, kStorey);
  b.addWall({{length + kOuter, shaft_north + o}, {far + o, shaft_north + o}, kOuter, {}, Stuff::Concrete},
            -kCeiling,
            kStorey);
  b.addWall({{far + o, shaft},
             {far + o, shaft_north},
             kOuter,
             {{1.45, 1.0, 1.9, 2.7, Filling::Window, 1, false}},
             Stuff::Concrete},
            -kCeiling,
            kStorey);
  const double spine = shaft + kFlight + kSpine / 2;
  b.addWall({{foot + kSpine / 2, spine}, {head - kSpine / 2, spine}, kSpine, {}, Stuff::Concrete}, -kCeiling, kStorey);
  if (stairs) {
    b.model().append(parts::makeStairs(kFlight, kSteps, kRise, kTread, Stuff::Concrete),
                     parts::standAt({foot, up, 0}, -kPi / 2));
    b.model().append(parts::makeStairs(kFlight, kSteps, kRise, kTread, Stuff::Concrete),
                     parts::standAt({head, down, kStorey / 2}, kPi / 2));
    parts::addSlab(b.model(), {head, shaft, far, shaft_north}, kStorey / 2, 0.25, {}, Stuff::Concrete);
  }
  else
    parts::addRailing(b.model(), {foot, shaft + 0.05, 0}, {foot, shaft + kFlight - 0.05, 0}, 1.0);
  b.block({length - 1, shaft - 0.5, far, shaft_north + 0.5}, 0, h);

  // Columns of the open floor, with beams between them.
  const Rect open{0, offices + kInner / 2, length, depth};
  const double spacing = length / 4;
  for (const double y : {offices + 1.6, depth - 2.2}) {
    for (int i = 0; i < 4; ++i) {
      const double x = spacing * (i + 0.5);
      b.model().addColumn({x, y, 0}, 0.22, h, parts::paint(b.model(), Stuff::Concrete));
      b.block(Rect{x, y, x, y}.grown(0.25), 0, h);
    }
    b.model().addBlock({length / 2, y, h - 0.25}, {length, 0.3, 0.25}, 0, parts::paint(b.model(), Stuff::Concrete));
  }
  if (furnishing > 0)
    r = RandomStream(seed, furnishing, kFurnishing);
  for (std::size_t i = 0; i < row.doors.size(); ++i)
    furnishOffice(b, roomOf(row, i, offices, 0), h);
  for (int i = 0; i < 4; ++i)
    addDeskWithChair(b, open);
  for (int i = 0; i < 2; ++i)
    if (b.placeInside(parts::makeTable(r, 1.6, 0.9), open, 0))
      b.placeLooseInside(parts::makeChair(r), open, 0);
  for (int i = 0; i < 4; ++i)
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.9, 1.4), b.vary(1.2, 2.1)), open, 0);
  for (int i = 0; i < 3; ++i)
    b.placeAtAnyWall(parts::makePlant(r), open, 0);
  b.placeAtAnyWall(parts::makeSofa(r, 1.9), open, 0);
  for (double x = 2; x < length - 1; x += 3.5)
    for (const double y : {aisle + 1.4, aisle + 4.2})
      b.model().append(parts::makePanelLamp(1.2), parts::standAt({x, y, h}));
  b.addWalkAreas(open, 0, 5, 0.9, 2.4);
  for (std::size_t i = 0; i < row.doors.size(); ++i)
    b.addWalkAreas(roomOf(row, i, offices, 0), 0, 1, 0.65, 1.6);
  for (int i = 0; i < 3; ++i)
    b.placeLooseInside(parts::makeBox(r), open, 0);

  return {b.finish("", 1.0, "sick_lms200"),
          floor,
          way_up,
          {length + kOuter, shaft, far, shaft_north},
          {-kOuter, -kOuter, far + kOuter, depth + kOuter}};
}

} // namespace

Scene
makeTwoFloorsAlike(std::uint64_t seed)
{
  // Two storeys to walk in, and one below and above, so that the stairs look the same from both.
  const Storey storey = makeStorey(seed, 0, true);
  Scene scene;
  scene.description = "two identical storeys of offices with columns, joined by stairs";
  scene.natural_step = storey.scene.natural_step;
  scene.recommended_sensor = storey.scene.recommended_sensor;
  scene.path = storey.scene.path;
  for (int k = -1; k <= 2; ++k) {
    const Vector3d lift(0, 0, kStorey * k);
    if (k == 0 || k == 1) {
      appendScene(scene, storey.scene, lift);
      continue;
    }
    scene.surfaces.append(storey.scene.surfaces, parts::standAt(lift));
    for (const LooseItem& item : storey.scene.loose_items)
      scene.surfaces.append(item.surfaces, parts::standAt(item.place + lift, item.yaw));
  }
  parts::addSlab(scene.surfaces, storey.outline, 3 * kStorey, kCeiling, {}, Stuff::Concrete);
  validate(scene.surfaces);
  return scene;
}

Scene
makeTower(std::uint64_t seed, const SceneOptions& options)
{
  constexpr int kUsual = 4;
  const int storeys = options.storeys > 0 ? options.storeys : kUsual;
  Scene scene;
  WalkPlan walk;
  for (int k = 0; k < storeys; ++k) {
    const bool top = k + 1 == storeys;
    Storey storey = makeStorey(seed, options.alike ? 1 : static_cast<std::uint64_t>(k) + 1, !top);
    const Vector3d lift(0, 0, kStorey * k);
    snap(storey.scene);
    appendScene(scene, storey.scene, lift);
    // To the far end of the floor and back to the stairs; scans are taken on the way back.
    const std::vector<Vector3d>& floor = storey.floor;
    if (k > 0)
      for (auto point = floor.rbegin(); point != floor.rend(); ++point)
        walk.to(*point + lift);
    walk.stop(floor[0] + Vector3d(0.9, 0, 0) + lift);
    walk.stop((floor[0] + floor[1]) / 2 + lift);
    walk.to(floor[1] + lift);
    walk.stop(floor[2] + lift);
    if (k == 0)
      parts::addSlab(scene.surfaces, storey.shaft, 0, kCeiling, {}, Stuff::Concrete);
    if (top) {
      parts::addSlab(scene.surfaces, storey.outline, kStorey * storeys, kCeiling, {}, Stuff::Concrete);
      break;
    }
    // On both flights and on the landing between them.
    const std::vector<Vector3d>& up = storey.stairs;
    for (std::size_t i = 0; i < up.size(); ++i) {
      if (i == 2 || i + 1 == up.size())
        walk.stop((up[i - 1] + up[i]) / 2 + lift);
      walk.to(up[i] + lift);
      if (i == 3)
        walk.stop((up[3] + up[4]) / 2 + lift);
    }
  }
  scene.path = walk.points();
  scene.stations = walk.stations();
  scene.description = "tower of storeys with the same walls and columns, joined by a stair case";
  scene.natural_step = 2.5;
  scene.recommended_sensor = "velodyne_vlp16";
  validate(scene.surfaces);
  return scene;
}

} // namespace pcl_ssfr::simulation
