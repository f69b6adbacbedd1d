// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_rooms.h>

#include <array>

/// Rooms that meet through doors only.
namespace pcl_ssfr::simulation {

using namespace rooms;

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr std::size_t kColumns = 4;
constexpr double kHeight = 2.7; // [m]

void
furnish(SceneBuilder& b, std::size_t kind, const Rect& room)
{
  RandomStream& r = b.random();
  switch (kind % 5) {
  case 0:
    b.placeAtAnyWall(parts::makeSofa(r, b.vary(1.6, 2.2)), room, 0);
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(1, 1.6), b.vary(1.6, 2.1)), room, 0);
    b.placeInside(parts::makeTable(r, 0.9, 0.6), room, 0);
    break;
  case 1:
    b.placeAtAnyWall(parts::makeBed(r, b.vary(0.9, 1.6)), room, 0);
    b.placeAtAnyWall(parts::makeCupboard(r, b.vary(1.2, 1.8), 0.6, 2.1), room, 0);
    break;
  case 2:
    b.placeAtAnyWall(parts::makeKitchenRow(r, b.vary(1.8, 2.6)), room, 0);
    b.placeInside(parts::makeTable(r, 1.1, 0.8), room, 0);
    break;
  case 3:
    addDeskWithChair(b, room);
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.8, 1.4), b.vary(1.2, 2.1)), room, 0);
    b.placeAtAnyWall(parts::makeCupboard(r, b.vary(0.8, 1.2), 0.45, b.vary(0.8, 1.9)), room, 0);
    break;
  default:
    furnishStore(b, room);
  }
  b.placeAtAnyWall(parts::makePicture(r), room, 0, 1.4);
  if (b.chance(0.5))
    b.placeAtAnyWall(parts::makePlant(r), room, 0);
  b.addWalkAreas(room, 0, 1, 0.65, 1.4);
  b.placeLooseInside(b.chance(0.5) ? parts::makeChair(r) : parts::makeBox(r), room, 0);
  b.model().append(parts::makePendantLamp(r), parts::standAt({room.centre().x(), room.centre().y(), kHeight}));
}

} // namespace

Scene
makeRoomsWithDoors(std::uint64_t seed)
{
  SceneBuilder b(seed);
  // Two rows of four rooms. One goes east through the southern ones and back through the northern ones.
  std::array<double, kColumns + 1> south{};
  std::array<double, kColumns + 1> north{};
  for (std::size_t i = 0; i < kColumns; ++i) {
    south.at(i + 1) = south.at(i) + b.vary(3.7, 5);
    north.at(i + 1) = north.at(i) + b.vary(3.7, 5);
  }
  const double length = std::max(south.back(), north.back());
  south.back() = length;
  north.back() = length;
  const double middle = b.vary(4.0, 4.8); // the wall between the rows
  const double top = middle + b.vary(4.0, 4.8);
  std::array<double, kColumns> door_south{};
  std::array<double, kColumns> door_north{};
  for (std::size_t i = 1; i < kColumns; ++i) {
    door_south.at(i) = b.vary(1.2, middle - 1.2);
    door_north.at(i) = b.vary(1.2, top - middle - 1.2) + middle;
  }
  const double through = b.vary(std::max(south[3], north[3]) + 1.0, length - 1.0);

  WalkPlan walk;
  constexpr double kBefore = 1.1; // straight through a door, from so far before it [m]
  for (std::size_t i = 0; i < kColumns; ++i) {
    walk.stop({(south.at(i) + south.at(i + 1)) / 2, middle / 2, 0});
    if (i + 1 < kColumns) {
      walk.to({south.at(i + 1) - kBefore, door_south.at(i + 1), 0});
      walk.to({south.at(i + 1) + kBefore, door_south.at(i + 1), 0});
    }
  }
  walk.to({through, middle - kBefore, 0});
  walk.to({through, middle + kBefore, 0});
  for (std::size_t i = kColumns; i-- > 0;) {
    walk.stop({(north.at(i) + north.at(i + 1)) / 2, (middle + top) / 2, 0});
    if (i > 0) {
      walk.to({north.at(i) + kBefore, door_north.at(i), 0});
      walk.to({north.at(i) - kBefore, door_north.at(i), 0});
    }
  }
  b.setPath(walk);

  const double o = kOuter / 2;
  const Rect outline{-kOuter, -kOuter, length + kOuter, top + kOuter};
  parts::addSlab(b.model(), outline, 0, 0.25, {}, Stuff::Wood);
  parts::addSlab(b.model(), outline, kHeight + 0.25, 0.25, {}, Stuff::Plaster);
  std::vector<Opening> windows_south;
  std::vector<Opening> windows_north;
  for (std::size_t i = 0; i < kColumns; ++i) {
    addWindows(b, windows_south, south.at(i), south.at(i + 1));
    addWindows(b, windows_north, north.at(i), north.at(i + 1));
    if (i == 0)
      continue;
    const int opens = b.chance(0.5) ? 1 : -1;
    b.addWall({{south.at(i), 0},
               {south.at(i), middle},
               kInner,
               {{door_south.at(i), kDoorWidth, 0, 2.05, Filling::Door, opens, b.chance(0.5)}},
               Stuff::Plaster},
              0,
              kHeight);
    b.addWall({{north.at(i), middle},
               {north.at(i), top},
               kInner,
               {{door_north.at(i) - middle, kDoorWidth, 0, 2.05, Filling::Door, -opens, b.chance(0.5)}},
               Stuff::Plaster},
              0,
              kHeight);
  }
  b.addWall({{0, -o}, {length, -o}, kOuter, windows_south, Stuff::Plaster}, 0, kHeight);
  b.addWall({{0, top + o}, {length, top + o}, kOuter, windows_north, Stuff::Plaster}, 0, kHeight);
  b.addWall({{-o, -o}, {-o, top + o}, kOuter, {}, Stuff::Plaster}, 0, kHeight);
  b.addWall({{length + o, -o}, {length + o, top + o}, kOuter, {}, Stuff::Plaster}, 0, kHeight);
  b.addWall({{0, middle},
             {length, middle},
             kInner,
             {{through, kDoorWidth, 0, 2.05, Filling::Door, 1, b.chance(0.5)}},
             Stuff::Plaster},
            0,
            kHeight);
  constexpr double kHalf = kInner / 2;
  for (std::size_t i = 0; i < kColumns; ++i) {
    furnish(b, i, {south.at(i) + kHalf, 0, south.at(i + 1) - kHalf, middle - kHalf});
    furnish(b, i + 2, {north.at(i) + kHalf, middle + kHalf, north.at(i + 1) - kHalf, top});
  }
  return b.finish("eight rooms that meet through doors only, one place for a scan in each", 1.2, "leica_p20");
}

} // namespace pcl_ssfr::simulation
