// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_rooms.h>

#include <algorithm>
#include <utility>

/// A storey of offices.
namespace pcl_ssfr::simulation {

using namespace rooms;

using Eigen::Vector3d;
using parts::Filling;
using parts::Rect;
using parts::Stuff;

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

} // namespace pcl_ssfr::simulation
