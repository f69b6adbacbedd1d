// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_rooms.h>

#include "common/angles.h"

#include <algorithm>

namespace pcl_ssfr::simulation::rooms {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

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

} // namespace

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

} // namespace pcl_ssfr::simulation::rooms
