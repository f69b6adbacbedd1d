// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>
#include <apps/simulation/scene_makers.h>

#include <algorithm>
#include <utility>

/// Storeys of offices: office_floor and two_floors_alike.
namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::kPi;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

constexpr double kOuter = 0.3;     // thickness of outer walls [m]
constexpr double kInner = 0.12;    // and of inner ones [m]
constexpr double kDoorWidth = 1.0; // [m]

/// Where the walls between \p count rooms stand: widths within a quarter of the average.
std::vector<double>
splitLength(SceneBuilder& b, double length, int count)
{
  std::vector<double> ends{0};
  for (int i = 0; i < count; ++i)
    ends.push_back(ends.back() + b.vary(0.75, 1.25));
  for (double& end : ends)
    end *= length / ends.back();
  ends.back() = length;
  return ends;
}

void
addDeskWithChair(SceneBuilder& b, const Rect& room)
{
  if (!b.placeAtAnyWall(parts::makeDesk(b.random()), room, 0))
    return;
  const Eigen::Isometry3d T = parts::standAt(b.lastFoot(), b.lastYaw());
  b.placeLoose(parts::makeOfficeChair(b.random()),
               T * Vector3d(b.vary(-0.2, 0.2), b.vary(0.75, 0.85), 0),
               b.lastYaw() + kPi + b.vary(-0.6, 0.6),
               room);
}

void
furnishOffice(SceneBuilder& b, const Rect& room, double height)
{
  RandomStream& r = b.random();
  const int desks = room.width() > 4 ? 2 + r.index(2) : 1 + r.index(2);
  for (int i = 0; i < desks; ++i)
    addDeskWithChair(b, room);
  for (int i = 0; i < 2; ++i)
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.8, 1.2), b.vary(1.2, 2.1)), room, 0);
  b.placeAtAnyWall(parts::makeCupboard(r, b.vary(0.8, 1.2), 0.45, b.vary(0.75, 1.9)), room, 0);
  if (b.chance(0.6))
    b.placeAtAnyWall(parts::makePlant(r), room, 0);
  b.placeAtAnyWall(parts::makePicture(r), room, 0, 1.4);
  b.model().append(parts::makePanelLamp(1.5),
                   parts::standAt({room.centre().x(), room.centre().y(), height}, b.chance(0.5) ? kPi / 2 : 0));
}

void
furnishMeetingRoom(SceneBuilder& b, const Rect& room, double height)
{
  RandomStream& r = b.random();
  const double width = std::min(room.width() - 2.2, b.vary(1.8, 2.4));
  const Vector2d c = room.centre();
  if (width > 0.8 && b.place(parts::makeTable(r, width, 1.0), {c.x(), c.y() + b.vary(-0.2, 0.2), 0}, 0)) {
    const Vector3d foot = b.lastFoot();
    for (const double side : {-1.0, 1.0})
      for (double x = -width / 2 + 0.35; x < width / 2; x += 0.62)
        b.placeLoose(
            parts::makeChair(r), foot + Vector3d(x, side * 0.82, 0), (side > 0 ? kPi : 0) + b.vary(-0.25, 0.25), room);
  }
  SurfaceModel board;
  board.addBlock({0, 0, 0.9}, {1.5, 0.04, 1.1}, 0, parts::paint(board, Stuff::WhitePlastic));
  b.placeAtAnyWall(board, room, 0);
  b.placeAtAnyWall(parts::makeCupboard(r, b.vary(1.0, 1.5), 0.45, 0.8), room, 0);
  b.model().append(parts::makePanelLamp(1.5), parts::standAt({c.x(), c.y(), height}));
}

void
furnishStore(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  for (int i = 0; i < 6; ++i)
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.9, 1.3), b.vary(1.9, 2.2)), room, 0);
  for (int i = 0; i < 4; ++i)
    b.placeAtAnyWall(parts::makeBox(r), room, 0);
}

/// Windows of a room in an outer wall that runs from \p start along x or against it.
void
addWindows(SceneBuilder& b, std::vector<Opening>& openings, double from, double to)
{
  const double free = to - from - 0.8;
  const int count = free > 3 ? 2 : 1;
  const double width = std::min(1.8, free / count - 0.3);
  const double bottom = b.vary(0.85, 0.95);
  for (int i = 0; i < count && width > 0.4; ++i)
    openings.push_back({from + 0.4 + free * (i + 0.5) / count, width, bottom, bottom + 1.4, Filling::Window, 1, false});
}

/// A row of rooms on one side of a corridor.
struct RoomRow {
  std::vector<double> ends;  ///< of the rooms along x [m]
  std::vector<double> doors; ///< middle of each room's door [m]
};

RoomRow
planRow(SceneBuilder& b, double length, int rooms)
{
  RoomRow row;
  row.ends = splitLength(b, length, rooms);
  for (int i = 0; i < rooms; ++i) {
    const auto k = static_cast<std::size_t>(i);
    row.doors.push_back(b.vary(row.ends[k] + 0.95, row.ends[k + 1] - 0.95));
  }
  return row;
}

/// The walls of a row: \p y of its corridor wall and of its outer face; doors open into the rooms.
void
addRow(SceneBuilder& b, const RoomRow& row, double corridor, double outer, double height)
{
  const int away = outer > corridor ? 1 : -1;
  std::vector<Opening> doors;
  std::vector<Opening> windows;
  for (std::size_t i = 0; i < row.doors.size(); ++i) {
    doors.push_back({row.doors[i], kDoorWidth, 0, 2.1, Filling::Door, away, b.chance(0.5)});
    addWindows(b, windows, row.ends[i], row.ends[i + 1]);
    if (i > 0)
      b.addWall({{row.ends[i], corridor}, {row.ends[i], outer}, kInner, {}, Stuff::Plaster}, 0, height);
  }
  const double length = row.ends.back();
  b.addWall({{0, corridor}, {length, corridor}, kInner, doors, Stuff::Plaster}, 0, height);
  const double middle = outer + away * kOuter / 2;
  b.addWall({{0, middle}, {length, middle}, kOuter, windows, Stuff::Plaster}, 0, height);
  for (std::size_t i = 0; i < row.doors.size(); ++i) {
    const double x = (row.ends[i] + row.ends[i + 1]) / 2;
    b.place(parts::makeRadiator(1.1), {x, outer - away * 0.08, 0}, away > 0 ? kPi : 0);
  }
}

Rect
roomOf(const RoomRow& row, std::size_t i, double corridor, double outer)
{
  constexpr double kHalf = kInner / 2;
  const double x0 = row.ends[i] + (i > 0 ? kHalf : 0);
  const double x1 = row.ends[i + 1] - (i + 2 < row.ends.size() ? kHalf : 0);
  return outer > corridor ? Rect{x0, corridor + kHalf, x1, outer} : Rect{x0, outer, x1, corridor - kHalf};
}

} // namespace

Scene
makeOfficeFloor(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const double length = b.vary(24.5, 25.5);
  const double depth = b.vary(4.4, 4.9);   // of the southern rooms
  const double passage = b.vary(2.0, 2.3); // width of the corridor
  const double h = b.vary(2.9, 3.1);
  const double hung = b.vary(2.5, 2.6); // ceiling of the corridor
  const double south = depth;           // walls of the corridor
  const double north = depth + passage;
  const double top = north + b.vary(4.2, 4.8);
  const double middle = (south + north) / 2;
  const RoomRow below = planRow(b, length, 6);
  const RoomRow above = planRow(b, length, 5);

  // Along the corridor, with a look into four rooms.
  std::vector<std::pair<double, double>> visits{{below.doors[1], south - 1.7},
                                                {above.doors[1], north + 1.7},
                                                {below.doors[3], south - 1.9},
                                                {above.doors[3], north + 1.9}};
  std::sort(visits.begin(), visits.end());
  std::vector<Vector3d> path{{1.2, middle, 0}};
  for (const auto& [x, y] : visits) {
    path.emplace_back(x, middle, 0);
    path.emplace_back(x, y, 0);
    path.emplace_back(x, middle, 0);
  }
  path.emplace_back(length - 1.2, middle, 0);
  b.setPath(path);

  const Rect outline{0, 0, length, top};
  parts::addSlab(b.model(), outline.grown(kOuter), 0, 0.3, {}, Stuff::Carpet);
  parts::addSlab(b.model(), outline.grown(kOuter), h + 0.3, 0.3, {}, Stuff::Plaster);
  parts::addSlab(b.model(), {0, south, length, north}, hung + 0.03, 0.03, {}, Stuff::WhitePlastic);
  addRow(b, below, south, 0, h);
  addRow(b, above, north, top, h);
  const double o = kOuter / 2;
  b.addWall(
      {{-o, -o}, {-o, top + o}, kOuter, {{middle + o, 1.2, 0, 2.2, Filling::Shut, 1, false}}, Stuff::Plaster}, 0, h);
  b.addWall({{length + o, -o},
             {length + o, top + o},
             kOuter,
             {{middle + o, 1.4, 0.9, 2.2, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            h);

  const std::size_t meeting = static_cast<std::size_t>(r.index(5));
  const std::size_t store = static_cast<std::size_t>(r.index(6));
  std::vector<Rect> rooms;
  for (std::size_t i = 0; i < below.doors.size(); ++i) {
    rooms.push_back(roomOf(below, i, south, 0));
    if (i == store)
      furnishStore(b, rooms.back());
    else
      furnishOffice(b, rooms.back(), h);
  }
  for (std::size_t i = 0; i < above.doors.size(); ++i) {
    rooms.push_back(roomOf(above, i, north, top));
    if (i == meeting)
      furnishMeetingRoom(b, rooms.back(), h);
    else
      furnishOffice(b, rooms.back(), h);
  }
  const Rect corridor{0, south + kInner / 2, length, north - kInner / 2};
  for (int i = 0; i < 6; ++i)
    b.placeAtWall(parts::makePicture(r), corridor, 0, b.chance(0.5) ? SceneBuilder::South : SceneBuilder::North, 1.4);
  for (int i = 0; i < 3; ++i)
    b.placeAtWall(parts::makeCupboard(r, b.vary(0.7, 1.2), 0.4, b.vary(0.9, 1.9)),
                  corridor,
                  0,
                  b.chance(0.5) ? SceneBuilder::South : SceneBuilder::North);
  SurfaceModel extinguisher;
  parts::addPipe(extinguisher, {0, 0, 0.6}, {0, 0, 1.1}, 0.08, Stuff::DarkPaint);
  for (int i = 0; i < 2; ++i)
    b.placeAtWall(extinguisher, corridor, 0, b.chance(0.5) ? SceneBuilder::South : SceneBuilder::North);
  for (double x = 1.5; x < length - 1; x += 3)
    b.model().append(parts::makePanelLamp(1.2), parts::standAt({x, middle, hung}));
  for (const Rect& room : rooms)
    b.addWalkAreas(room, 0, 2, 0.65, 1.8);
  for (int i = 0; i < 5; ++i) {
    const Rect& room = rooms[static_cast<std::size_t>(r.index(static_cast<int>(rooms.size())))];
    b.placeLooseInside(parts::makeBox(r), room, 0);
  }
  return b.finish("storey of offices on both sides of a corridor, 25 m long", 0.8, "sick_lms200");
}

Scene
makeTwoFloorsAlike(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  // One storey, made once and stacked: offices in the south, an open floor with two rows of columns, stairs in the
  // east.
  constexpr double kStorey = 3.5; // from floor to floor [m]
  constexpr double kCeiling = 0.3;
  constexpr double h = kStorey - kCeiling;
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
  std::vector<Vector3d> path = floor;
  path.emplace_back(length - 1.2, up, 0);
  path.emplace_back(foot - kTread, up, 0);
  path.emplace_back(foot + edge, up, kStorey / 2);
  path.emplace_back(head + kLanding / 2, up, kStorey / 2);
  path.emplace_back(head + kLanding / 2, down, kStorey / 2);
  path.emplace_back(head + kTread, down, kStorey / 2);
  path.emplace_back(head - edge, down, kStorey);
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
  b.model().append(parts::makeStairs(kFlight, kSteps, kRise, kTread, Stuff::Concrete),
                   parts::standAt({foot, up, 0}, -kPi / 2));
  b.model().append(parts::makeStairs(kFlight, kSteps, kRise, kTread, Stuff::Concrete),
                   parts::standAt({head, down, kStorey / 2}, kPi / 2));
  parts::addSlab(b.model(), {head, shaft, far, shaft_north}, kStorey / 2, 0.25, {}, Stuff::Concrete);
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

  // Two storeys to walk in, and one below and above, so that the stairs look the same from both.
  Scene storey = b.finish("two identical storeys of offices with columns, joined by stairs", 1.0, "sick_lms200");
  Scene scene = storey;
  scene.surfaces = SurfaceModel();
  scene.doors.clear();
  scene.walk_areas.clear();
  scene.loose_items.clear();
  for (int k = -1; k <= 2; ++k) {
    const Vector3d lift(0, 0, kStorey * k);
    scene.surfaces.append(storey.surfaces, parts::standAt(lift));
    if (k < 0 || k > 1) {
      for (const LooseItem& item : storey.loose_items)
        scene.surfaces.append(item.surfaces, parts::standAt(item.place + lift, item.yaw));
      continue;
    }
    for (Door door : storey.doors) {
      door.hinge += lift;
      scene.doors.push_back(door);
    }
    for (WalkArea area : storey.walk_areas) {
      area.lower += lift;
      area.upper += lift;
      scene.walk_areas.push_back(area);
    }
    for (LooseItem item : storey.loose_items) {
      item.place += lift;
      item.area.lower += lift;
      item.area.upper += lift;
      scene.loose_items.push_back(item);
    }
  }
  parts::addSlab(
      scene.surfaces, {-kOuter, -kOuter, far + kOuter, depth + kOuter}, 3 * kStorey, kCeiling, {}, Stuff::Concrete);
  validate(scene.surfaces);
  return scene;
}

} // namespace pcl_ssfr::simulation
