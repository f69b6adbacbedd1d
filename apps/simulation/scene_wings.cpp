// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_rooms.h>

/// Two wings with the same walls, joined by a link building.
namespace pcl_ssfr::simulation {

using namespace rooms;

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kLength = 16.5; // of a wing [m]
constexpr double kApart = 25;    // corridors of the two wings, on the grid of snap() [m]
constexpr double kHalf = 1.05;   // half the corridor's width [m]
constexpr double kDepth = 4.5;   // of rooms [m]
constexpr double kHeight = 3.0;  // [m]
constexpr double kLinkWidth = 6; // [m]
constexpr double kEnd = 3.5;     // the link goes on beyond the corridors [m]
constexpr double kOut = kHalf + kDepth;
constexpr std::uint64_t kFurnishing = 0x77696e67ULL;

/// A wing along x with its corridor on y = 0, and its walk: in from the west and out again.
struct Wing {
  Scene scene;
  std::vector<Vector3d> corridor; ///< three places
  std::vector<Vector3d> rooms;    ///< the way into a room from the second and third of them: before its door, inside
};

Wing
makeWing(std::uint64_t seed, std::uint64_t furnishing)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const RoomRow north = planRow(b, kLength, 4);
  const RoomRow south = planRow(b, kLength, 3);
  Wing wing;
  wing.corridor = {{1.5, 0, 0}, {north.doors[1], 0, 0}, {south.doors[2], 0, 0}};
  wing.rooms = {{north.doors[1], kHalf + 1.8, 0}, {south.doors[2], -kHalf - 1.8, 0}};
  b.setPath({{-1, 0, 0},
             wing.corridor[1],
             wing.rooms[0],
             wing.corridor[1],
             {kLength - 1.2, 0, 0},
             wing.corridor[2],
             wing.rooms[1]});
  const Rect outline{0, -kOut - kOuter, kLength + kOuter, kOut + kOuter};
  parts::addSlab(b.model(), outline, 0, 0.3, {}, Stuff::Carpet);
  parts::addSlab(b.model(), outline, kHeight + 0.3, 0.3, {}, Stuff::Plaster);
  addRow(b, north, kHalf, kOut, kHeight);
  addRow(b, south, -kHalf, -kOut, kHeight);
  const double o = kOuter / 2;
  b.addWall(
      {{o, -kOut - o}, {o, kOut + o}, kOuter, {{kOut + o, 2 * kHalf, 0, 2.5, Filling::None, 1, false}}, Stuff::Plaster},
      0,
      kHeight);
  b.addWall({{kLength + o, -kOut - o},
             {kLength + o, kOut + o},
             kOuter,
             {{kOut + o, 1.3, 0.6, 2.3, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            kHeight);
  for (double x = 1.8; x < kLength - 1; x += 3.2)
    b.model().append(parts::makePanelLamp(1.2), parts::standAt({x, 0, kHeight}));
  r = RandomStream(seed, furnishing, kFurnishing);
  for (std::size_t i = 0; i < north.doors.size(); ++i)
    furnishOffice(b, roomOf(north, i, kHalf, kOut), kHeight);
  for (std::size_t i = 0; i < south.doors.size(); ++i)
    if (i == 1)
      furnishMeetingRoom(b, roomOf(south, i, -kHalf, -kOut), kHeight);
    else
      furnishOffice(b, roomOf(south, i, -kHalf, -kOut), kHeight);
  const Rect corridor{kOuter, -kHalf + kInner / 2, kLength, kHalf - kInner / 2};
  for (int i = 0; i < 3; ++i)
    b.placeAtWall(parts::makePicture(r), corridor, 0, b.chance(0.5) ? SceneBuilder::South : SceneBuilder::North, 1.4);
  b.placeAtWall(parts::makeCupboard(r, b.vary(0.7, 1.1), 0.38, b.vary(0.9, 1.9)),
                corridor,
                0,
                b.chance(0.5) ? SceneBuilder::South : SceneBuilder::North);
  for (std::size_t i = 0; i < north.doors.size(); ++i)
    b.addWalkAreas(roomOf(north, i, kHalf, kOut), 0, 1, 0.65, 1.8);
  wing.scene = b.finish("", 1, "");
  snap(wing.scene);
  return wing;
}

} // namespace

Scene
makeTwinWings(std::uint64_t seed, const SceneOptions& options)
{
  const Wing first = makeWing(seed, 1);
  const Wing second = makeWing(seed, options.alike ? 1 : 2);
  const Vector3d shift(0, kApart, 0);
  const double middle = -kLinkWidth / 2;
  WalkPlan walk;
  const auto visit = [&walk](const Wing& wing, const Vector3d& at) {
    walk.stop(wing.corridor[0] + at);
    walk.stop(wing.corridor[1] + at);
    walk.stop(wing.rooms[0] + at);
    walk.to(wing.corridor[1] + at);
    walk.stop(wing.corridor[2] + at);
    walk.stop(wing.rooms[1] + at);
    walk.to(wing.corridor[2] + at);
    walk.to(wing.corridor[0] + at);
  };
  visit(first, Vector3d::Zero());
  walk.stop({middle, 0, 0});
  walk.stop({middle, kApart / 3, 0});
  walk.stop({middle, kApart * 2 / 3, 0});
  walk.stop({middle, kApart, 0});
  visit(second, shift);

  SceneBuilder b(seed + 1);
  RandomStream& r = b.random();
  b.setPath(walk);
  const Rect link{-kLinkWidth, -kEnd, 0, kApart + kEnd};
  const double h = kHeight + 0.4;
  parts::addSlab(b.model(), {link.x0 - kOuter, link.y0 - kOuter, 0, link.y1 + kOuter}, 0, 0.3, {}, Stuff::Stone);
  parts::addSlab(
      b.model(), {link.x0 - kOuter, link.y0 - kOuter, 0.3, link.y1 + kOuter}, h + 0.3, 0.3, {}, Stuff::Plaster);
  const double o = kOuter / 2;
  std::vector<Opening> front;
  for (double y = 2; y + 2 < link.depth(); y += 2.6)
    front.push_back({y, 2.2, 0.3, 2.8, Filling::Window, 1, false});
  b.addWall({{link.x0 - o, link.y0}, {link.x0 - o, link.y1}, kOuter, front, Stuff::Plaster}, 0, h);
  b.addWall({{link.x0, link.y0 - o},
             {link.x1, link.y0 - o},
             kOuter,
             {{3, 1.8, 0, 2.3, Filling::Shut, 1, false}},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{link.x0, link.y1 + o}, {link.x1, link.y1 + o}, kOuter, {}, Stuff::Brick}, 0, h);
  // Between the wings, and above their ends, which are lower.
  b.addWall({{o, kOut + kOuter},
             {o, kApart - kOut - kOuter},
             kOuter,
             {{3, 2.2, 0.8, 2.4, Filling::Window, 1, false}, {8, 3.0, 0.8, 2.4, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            h);
  for (const double y : {0.0, kApart})
    b.addWall(
        {{o, y - kOut - kOuter}, {o, y + kOut + kOuter}, kOuter, {}, Stuff::Plaster}, kHeight + 0.3, h - kHeight - 0.3);
  for (const double y : {4.0, 9.5, 15.5, 21.0}) {
    const double x = link.x0 + 1.1;
    b.model().addColumn({x, y, 0}, 0.2, h, parts::paint(b.model(), Stuff::Concrete));
    b.block(Rect{x, y, x, y}.grown(0.22), 0, h);
  }
  // What stands in the link is nowhere else.
  b.placeAtWall(parts::makeKitchenRow(r, 2.4), {link.x0, 9, 0, 16}, 0, SceneBuilder::East);
  for (int i = 0; i < 3; ++i)
    b.placeAtAnyWall(parts::makeSofa(r, b.vary(1.4, 2.2)), link, 0);
  for (int i = 0; i < 4; ++i)
    b.placeAtAnyWall(parts::makePlant(r), link, 0);
  for (int i = 0; i < 2; ++i)
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.9, 1.6), b.vary(1.5, 2.1)), link, 0);
  for (int i = 0; i < 3; ++i)
    b.placeAtAnyWall(parts::makePicture(r), link, 0, 1.4);
  b.placeInside(parts::makeTable(r, 1.4, 0.8), link, 0);
  b.addWalkAreas(link, 0, 3, 0.8, 2.0);
  appendScene(b.scene(), first.scene, Vector3d::Zero());
  appendScene(b.scene(), second.scene, shift);
  return b.finish("two wings of offices with the same walls, joined by a link building", 2, "velodyne_vlp16");
}

} // namespace pcl_ssfr::simulation
