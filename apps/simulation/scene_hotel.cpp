// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_rooms.h>

/// A corridor between rooms that are all alike.
namespace pcl_ssfr::simulation {

using namespace rooms;

using Eigen::Vector3d;
using parts::Filling;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kWidth = 3.875;   // of a room with its western wall, on the grid of snap() [m]
constexpr double kDepth = 6.25;    // of a room, from the corridor's wall to the window [m]
constexpr double kHeight = 2.75;   // [m]
constexpr double kDoor = 0.8;      // middle of the door from the western wall [m]
constexpr double kPlace = 1.0;     // of the scanner in the room, from the western wall [m]
constexpr double kBath = 1.55;     // western wall of the bath room [m]
constexpr double kBathDepth = 2.2; // [m]
constexpr double kPassage = 1.875; // width of the corridor [m]
constexpr double kLobby = 4.5;     // at its western end [m]
constexpr int kRooms = 4;          // on each side
constexpr std::uint64_t kGuestStream = 0x67756573ULL;

/** \brief The room north of the corridor, its corridor wall on y = 0, its western wall on x = 0.
 * \param[in] guest decides what the guest left lying about
 */
Scene
makeRoom(std::uint64_t seed, std::uint64_t guest)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const Rect room{kInner / 2, kInner / 2, kWidth - kInner / 2, kDepth};
  b.setPath({{kDoor, -kPassage / 2, 0}, {kDoor, 2.6, 0}, {kPlace, 4.2, 0}});
  b.addWall(
      {{0, 0}, {kWidth, 0}, kInner, {{kDoor, 0.95, 0, 2.1, Filling::Door, 1, false}}, Stuff::Plaster}, 0, kHeight);
  b.addWall({{0, 0}, {0, kDepth}, kInner, {}, Stuff::Plaster}, 0, kHeight);
  b.addWall({{0, kDepth + kOuter / 2},
             {kWidth, kDepth + kOuter / 2},
             kOuter,
             {{kWidth / 2, 2.2, 0.4, 2.3, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            kHeight);
  b.addWall({{kBath, 0}, {kBath, kBathDepth}, 0.1, {{1.2, 0.8, 0, 2.05, Filling::Shut, 1, false}}, Stuff::Plaster},
            0,
            kHeight);
  b.addWall({{kBath, kBathDepth}, {kWidth, kBathDepth}, 0.1, {}, Stuff::Plaster}, 0, kHeight);
  parts::addSlab(b.model(), {0, -kPassage / 2, kWidth, kDepth + kOuter}, 0, 0.25, {}, Stuff::Carpet);
  parts::addSlab(b.model(), {0, -kPassage / 2, kWidth, kDepth + kOuter}, kHeight + 0.25, 0.25, {}, Stuff::Plaster);
  b.block({kBath, 0, kWidth, kBathDepth + 0.1}, 0, kHeight);
  // As the hotel furnished it.
  b.placeAtWall(parts::makeBed(r, 1.4), {kBath, kBathDepth + 0.3, room.x1, 4.9}, 0, SceneBuilder::East);
  b.placeAtWall(parts::makeTable(r, 1.2, 0.5), {kBath, 4.9, room.x1, room.y1}, 0, SceneBuilder::North);
  b.placeAtWall(parts::makeCupboard(r, 1.0, 0.5, 0.75), {room.x0, 5.0, 1.3, room.y1}, 0, SceneBuilder::North);
  b.placeAtWall(parts::makeRadiator(1.0), room, 0, SceneBuilder::North, 0.05);
  b.placeAtWall(parts::makePicture(r), {room.x0, 2.4, room.x1, room.y1}, 0, SceneBuilder::East, 1.5);
  b.model().append(parts::makePendantLamp(r), parts::standAt({2.3, 4.4, kHeight}));
  b.model().append(parts::makePanelLamp(0.9), parts::standAt({kDoor + 0.1, -kPassage / 2 + 0.35, kHeight}));
  // As the guest left it.
  r = RandomStream(seed, guest, kGuestStream);
  b.placeLooseInside(parts::makeChair(r), {kBath + 0.1, 4.6, room.x1, room.y1}, 0);
  b.addWalkAreas({room.x0, 2.4, room.x1, room.y1}, 0, 2, 0.65, 1.4);
  const int things = 1 + r.index(3);
  for (int i = 0; i < things; ++i)
    b.placeAtAnyWall(parts::makeBox(r), {room.x0, 2.4, room.x1, room.y1}, 0);
  Scene scene = b.finish("", 1, "");
  snap(scene);
  return scene;
}

} // namespace

Scene
makeHotelCorridor(std::uint64_t seed, const SceneOptions& options)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const double length = kRooms * kWidth;
  const double half = kPassage / 2;
  WalkPlan walk;
  walk.stop({-kLobby / 2, 0.5, 0});
  walk.to({-1, 0, 0});
  for (int i = 0; i < kRooms; ++i)
    for (const double side : {1.0, -1.0}) {
      const double x = kWidth * i + (side > 0 ? kDoor : kWidth - kDoor);
      const double inside = kWidth * i + (side > 0 ? kPlace : kWidth - kPlace);
      walk.stop({x, 0, 0});
      walk.to({x, side * (half + 2.6), 0});
      walk.stop({inside, side * (half + 4.2), 0});
      walk.to({x, side * (half + 2.6), 0});
      walk.to({x, 0, 0});
    }
  walk.stop({length - 0.8, 0, 0});
  b.setPath(walk);

  // The lobby with the lift in the west, a window in the east.
  const double north = half + 1.6;
  const Rect lobby{-kLobby, -half, 0, north};
  parts::addSlab(b.model(), {-kLobby - kOuter, -half - kOuter, 0, north + kOuter}, 0, 0.25, {}, Stuff::Stone);
  parts::addSlab(
      b.model(), {-kLobby - kOuter, -half - kOuter, 0, north + kOuter}, kHeight + 0.25, 0.25, {}, Stuff::Plaster);
  b.addWall({{-kLobby - kOuter / 2, -half},
             {-kLobby - kOuter / 2, north},
             kOuter,
             {{half + 0.9, 1.1, 0, 2.1, Filling::Shut, 1, false}},
             Stuff::Plaster},
            0,
            kHeight);
  b.addWall({{-kLobby, -half - kOuter / 2}, {0, -half - kOuter / 2}, kOuter, {}, Stuff::Plaster}, 0, kHeight);
  b.addWall({{-kLobby, north + kOuter / 2},
             {0, north + kOuter / 2},
             kOuter,
             {{1.2, 0.9, 0, 2.1, Filling::Shut, 1, false}},
             Stuff::Plaster},
            0,
            kHeight);
  b.addWall({{length + kOuter / 2, -half - kDepth},
             {length + kOuter / 2, half + kDepth},
             kOuter,
             {{kDepth + half, 1.2, 0.5, 2.2, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            kHeight);
  // The western wall of the southern rooms' row, which a room that is rotated by 180 degrees leaves open.
  b.addWall({{0, -half - kDepth}, {0, -half - kInner}, kInner, {}, Stuff::Plaster}, 0, kHeight);
  b.placeAtWall(parts::makeSofa(r, 1.5), lobby, 0, SceneBuilder::South);
  b.placeAtWall(parts::makePlant(r), lobby, 0, SceneBuilder::West);
  b.placeAtWall(parts::makePicture(r), lobby, 0, SceneBuilder::South, 1.5);
  b.addWalkAreas(lobby, 0, 1, 0.65, 1.4);
  for (int i = 0; i < kRooms; ++i)
    for (const bool south : {false, true}) {
      const std::uint64_t guest = options.alike ? 0 : 1 + 2 * static_cast<std::uint64_t>(i) + (south ? 1 : 0);
      const Vector3d foot(onGrid(kWidth * (south ? i + 1 : i)), onGrid(south ? -half : half), 0);
      appendScene(b.scene(), makeRoom(seed, guest), foot, south);
    }
  return b.finish("hotel corridor between eight rooms alike, one lobby", 1.2, "velodyne_vlp16");
}

} // namespace pcl_ssfr::simulation
