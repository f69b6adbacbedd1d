// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>

namespace pcl_ssfr::simulation {

namespace {

using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;
using parts::Wall;

constexpr double kHeight = 2.6;     // of the rooms [m]
constexpr double kUpper = 2.4;      // of the landing above the stairs [m]
constexpr double kSlab = 0.28;      // [m]
constexpr double kOuter = 0.3;      // thickness of outer walls [m]
constexpr double kInner = 0.12;     // and of inner ones [m]
constexpr double kDoorWidth = 1.0;  // [m]
constexpr double kSillHeight = 0.9; // [m]

Opening
window(double centre, double width, double bottom = kSillHeight, double top = 2.2)
{
  return {centre, width, bottom, top, Filling::Window, 1, false};
}

Opening
door(double centre, int side, bool hinge_at_end)
{
  return {centre, kDoorWidth, 0, 2.1, Filling::Door, side, hinge_at_end};
}

/// Chairs at the four sides of a table of this size that was just placed.
void
addChairs(SceneBuilder& builder, double width, double depth, const Rect& room, int most)
{
  const Eigen::Isometry3d T = parts::standAt(builder.lastFoot(), builder.lastYaw());
  const double yaw = builder.lastYaw();
  const double x = width / 4;
  const double y = depth / 2 + 0.28;
  const std::vector<std::pair<Eigen::Vector3d, double>> places{{{x, y, 0}, kPi},
                                                               {{-x, -y, 0}, 0},
                                                               {{-x, y, 0}, kPi},
                                                               {{x, -y, 0}, 0},
                                                               {{width / 2 + 0.28, 0, 0}, kPi / 2},
                                                               {{-width / 2 - 0.28, 0, 0}, -kPi / 2}};
  int chairs = 0;
  for (const auto& [place, turn] : places) {
    if (chairs >= most)
      return;
    const double askew = builder.vary(-0.15, 0.15);
    if (builder.placeLoose(parts::makeChair(builder.random()), T * place, yaw + turn + askew, room))
      ++chairs;
  }
}

void
furnishKitchen(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  b.placeAtWall(parts::makeKitchenRow(r, b.vary(2.2, 2.6)), room, 0, SceneBuilder::South);
  const double width = b.vary(0.7, 0.9);
  if (b.placeAtWall(parts::makeTable(r, width, 0.7), room, 0, SceneBuilder::West))
    addChairs(b, width, 0.7, room, 2);
  b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.5, 0.8), b.vary(1.2, 1.9)), room, 0);
  b.placeAtAnyWall(parts::makePicture(r), room, 0, 1.4);
}

void
furnishBath(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  b.placeAtWall(parts::makeBathTub(), room, 0, SceneBuilder::South);
  b.placeAtWall(parts::makeToilet(), room, 0, SceneBuilder::East);
  b.placeAtWall(parts::makeWashBasin(r), room, 0, SceneBuilder::West);
  b.placeAtAnyWall(parts::makeCupboard(r, 0.6, 0.6, 0.85), room, 0);
  b.placeAtAnyWall(parts::makeRadiator(0.6), room, 0);
}

void
furnishBedroom(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  b.placeAtWall(parts::makeBed(r, b.vary(1.2, 1.4)), room, 0, SceneBuilder::West);
  b.placeAtAnyWall(parts::makeCupboard(r, b.vary(1.0, 1.5), 0.6, b.vary(1.9, 2.2)), room, 0);
  b.placeAtAnyWall(parts::makeCupboard(r, 0.45, 0.4, b.vary(0.45, 0.6)), room, 0);
  b.placeAtAnyWall(parts::makePicture(r), room, 0, 1.4);
}

void
furnishStudy(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  if (b.placeAtWall(parts::makeDesk(r), room, 0, b.chance(0.5) ? SceneBuilder::North : SceneBuilder::West)) {
    const Eigen::Isometry3d T = parts::standAt(b.lastFoot(), b.lastYaw());
    b.placeLoose(
        parts::makeOfficeChair(r), T * Eigen::Vector3d(0, 0.78, 0), b.lastYaw() + kPi + b.vary(-0.5, 0.5), room);
  }
  b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.8, 1.2), b.vary(1.8, 2.2)), room, 0);
  b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.6, 0.9), b.vary(0.8, 1.4)), room, 0);
}

void
furnishLiving(SceneBuilder& b, const Rect& room)
{
  RandomStream& r = b.random();
  b.placeAtWall(parts::makeSofa(r, b.vary(1.9, 2.3)), room, 0, SceneBuilder::South);
  b.placeAtWall(parts::makeCupboard(r, b.vary(1.3, 1.8), 0.42, b.vary(0.45, 0.6)), room, 0, SceneBuilder::East);
  const double width = b.vary(1.3, 1.6);
  if (b.placeInside(parts::makeTable(r, width, 0.85), room, 0))
    addChairs(b, width, 0.85, room, 5);
  b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.9, 1.4), b.vary(1.8, 2.2)), room, 0);
  b.placeAtAnyWall(parts::makeShelf(r, b.vary(0.5, 0.8), b.vary(0.7, 1.1)), room, 0);
  b.placeAtAnyWall(parts::makeSofa(r, 0.95), room, 0);
  b.placeInside(parts::makeTable(r, 0.8, 0.6), room, 0);
  b.placeAtAnyWall(parts::makeCupboard(r, b.vary(0.8, 1.2), 0.5, b.vary(0.8, 1.2)), room, 0);
  for (int i = 0; i < 3; ++i)
    b.placeAtAnyWall(parts::makePlant(r), room, 0);
  for (int i = 0; i < 3; ++i)
    b.placeAtAnyWall(parts::makePicture(r), room, 0, 1.35);
}

/// A lamp that hangs where nobody walks into it.
void
addLamp(SceneBuilder& b, const Rect& room)
{
  const SurfaceModel lamp = parts::makePendantLamp(b.random());
  for (int i = 0; i < 10; ++i) {
    const double x = b.vary(0.3 * room.x0 + 0.7 * room.x1, 0.7 * room.x0 + 0.3 * room.x1);
    const double y = b.vary(0.3 * room.y0 + 0.7 * room.y1, 0.7 * room.y0 + 0.3 * room.y1);
    if (b.place(lamp, {x, y, kHeight}, 0))
      return;
  }
}

} // namespace

Scene
makeApartment(std::uint64_t seed)
{
  SceneBuilder b(seed);
  // Plan, origin in the south-west corner: kitchen and bath in the south, bedroom and study in the north of a passage,
  // the living room with the stairs across the whole depth in the east.
  const double width = b.vary(10.7, 11.2);
  const double depth = b.vary(7.9, 8.3);
  const double passage_south = b.vary(3.7, 3.9);
  const double passage_north = passage_south + b.vary(1.45, 1.6);
  const double living = b.vary(6.0, 6.3);
  const double bath = b.vary(3.5, 3.7);
  const double study = b.vary(3.3, 3.5);
  const double passage = (passage_south + passage_north) / 2;
  const double kitchen_door = b.vary(1.4, 1.9);
  const double bath_door = bath + b.vary(1.0, 1.3);
  const double bedroom_door = b.vary(1.7, 2.3);
  const double study_door = study + b.vary(1.3, 1.6);

  b.setPath({{kitchen_door, 1.75, 0},
             {kitchen_door, passage, 0},
             {bedroom_door, passage, 0},
             {bedroom_door, passage_north + 0.7, 0},
             {bedroom_door, passage, 0},
             {study_door, passage, 0},
             {study_door, passage_north + 1.2, 0},
             {study_door, passage, 0},
             {living + 1.2, passage, 0},
             {living + 1.5, 2.2, 0},
             {living + 1.2, passage, 0},
             {living + 2.0, passage + 1.2, 0},
             {living + 1.2, passage, 0},
             {bath_door, passage, 0},
             {bath_door, passage_south - 1.0, 0}});

  // Stairs along the north wall of the living room, climbing east into a closed landing.
  constexpr int kSteps = 16;
  const double stairs_width = 0.95;
  const double rise = (kHeight + kSlab) / kSteps;
  const double tread = 0.23;
  const double stairs_start = width - kSteps * tread - 0.05;
  const Rect well{stairs_start + 0.6, depth - stairs_width - 0.05, width, depth};

  const Rect outline{0, 0, width, depth};
  parts::addSlab(b.model(), outline.grown(kOuter), 0, 0.3, {}, Stuff::Wood);
  parts::addSlab(b.model(), outline.grown(kOuter), kHeight + kSlab, kSlab, {well}, Stuff::Plaster);
  const double h = kHeight;
  const double o = kOuter / 2;
  b.addWall(
      {{-o, -o},
       {width + o, -o},
       kOuter,
       {window(1.9 + b.vary(-0.2, 0.2), 1.4, 1.1), window(bath + 1.3 + o, 0.6, 1.4), window(living + 2.6, 2.2, 0.1)},
       Stuff::Plaster},
      0,
      h);
  b.addWall(
      {{width + o, -o}, {width + o, depth + o}, kOuter, {window(2.6, 1.6), window(5.0, 1.2)}, Stuff::Plaster}, 0, h);
  b.addWall({{width + o, depth + o},
             {-o, depth + o},
             kOuter,
             {window(width - study - 1.4, 1.5), window(width - 1.7, 1.6)},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{-o, depth + o},
             {-o, -o},
             kOuter,
             {{depth + o - passage, 0.95, 0, 2.1, Filling::Shut, 1, false}, window(depth - 1.5, 1.0)},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{0, passage_south},
             {living, passage_south},
             kInner,
             {door(kitchen_door, -1, true), door(bath_door, -1, false)},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{0, passage_north},
             {living, passage_north},
             kInner,
             {door(bedroom_door, 1, true), door(study_door, 1, false)},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{bath, 0}, {bath, passage_south}, kInner, {}, Stuff::Plaster}, 0, h);
  b.addWall({{study, passage_north}, {study, depth}, kInner, {}, Stuff::Plaster}, 0, h);
  b.addWall(
      {{living, 0}, {living, depth}, kInner, {{passage, 1.3, 0, 2.3, Filling::None, 1, false}}, Stuff::Plaster}, 0, h);

  const double middle = depth - stairs_width / 2 - 0.05;
  b.model().append(parts::makeStairs(stairs_width, kSteps, rise, tread, Stuff::Wood),
                   parts::standAt({stairs_start, middle, 0}, -kPi / 2));
  b.block({stairs_start - 0.6, depth - stairs_width - 0.1, width, depth}, 0, h);
  const double rail = depth - stairs_width - 0.03;
  parts::addPipe(b.model(),
                 {stairs_start, rail, rise + 0.9},
                 {stairs_start + 8 * tread, rail, 9 * rise + 0.9},
                 0.025,
                 Stuff::Wood);
  for (int i = 0; i < 9; ++i)
    parts::addPipe(b.model(),
                   {stairs_start + tread * i, rail, rise * (i + 1)},
                   {stairs_start + tread * i, rail, rise * (i + 1) + 0.9},
                   0.012,
                   Stuff::Metal);
  // The landing: walls about the well and a ceiling.
  const double z = kHeight + kSlab;
  for (const Wall& wall : {Wall{{well.x0 - o, well.y0 - o}, {well.x1 + o, well.y0 - o}, kOuter, {}, Stuff::Plaster},
                           Wall{{well.x1 + o, well.y0 - o},
                                {well.x1 + o, well.y1 + o},
                                kOuter,
                                {{0.68, 0.85, 0, 2.05, Filling::Shut, 1, false}},
                                Stuff::Plaster},
                           Wall{{well.x1 + o, well.y1 + o}, {well.x0 - o, well.y1 + o}, kOuter, {}, Stuff::Plaster},
                           Wall{{well.x0 - o, well.y1 + o}, {well.x0 - o, well.y0 - o}, kOuter, {}, Stuff::Plaster}})
    parts::addWall(b.model(), wall, z, kUpper);
  parts::addSlab(b.model(), well.grown(kOuter), z + kUpper + 0.2, 0.2, {}, Stuff::Plaster);

  const double t = kInner / 2;
  const Rect kitchen{0, 0, bath - t, passage_south - t};
  const Rect bathroom{bath + t, 0, living - t, passage_south - t};
  const Rect bedroom{0, passage_north + t, study - t, depth};
  const Rect office{study + t, passage_north + t, living - t, depth};
  const Rect living_room{living + t, 0, width, depth};
  const Rect passage_room{0, passage_south + t, living - t, passage_north - t};
  furnishKitchen(b, kitchen);
  furnishBath(b, bathroom);
  furnishBedroom(b, bedroom);
  furnishStudy(b, office);
  b.addWalkAreas(living_room, 0, 1, 0.8, 1.5); // people need some room in any case
  furnishLiving(b, living_room);
  for (const Rect& room : {bedroom, office, living_room})
    b.placeAtAnyWall(parts::makeRadiator(b.vary(0.8, 1.2)), room, 0);
  b.placeAtAnyWall(parts::makePicture(b.random()), passage_room, 0, 1.4);
  b.placeAtWall(parts::makeShelf(b.random(), 0.6, 1.0), passage_room, 0, SceneBuilder::West);
  for (const Rect& room : {kitchen, bathroom, bedroom, office, living_room, passage_room})
    addLamp(b, room);

  b.addWalkAreas(living_room, 0, 4, 0.75, 1.8);
  for (const Rect& room : {kitchen, bedroom, office, bathroom})
    b.addWalkAreas(room, 0, 1, 0.65, 1.6);
  for (int i = 0; i < 3; ++i)
    b.placeLooseInside(parts::makeBox(b.random()), i == 0 ? office : living_room, 0);
  return b.finish("flat of five furnished rooms, a passage and stairs, 11 m by 8 m", 0.4, "hokuyo_utm30lx");
}

} // namespace pcl_ssfr::simulation
