// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

constexpr double kOuter = 0.5;   // thickness of the walls [m]
constexpr double kGallery = 5.0; // height of the galleries [m]

/// A row of openings along a wall.
std::vector<Opening>
rowOf(double length, double spacing, double width, double bottom, double top, Filling filling)
{
  std::vector<Opening> openings;
  const int count = static_cast<int>(std::floor(length / spacing));
  openings.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    openings.push_back({length * (i + 0.5) / count, width, bottom, top, filling, 1, false});
  return openings;
}

/// A stall: a counter with a slanting awning on four posts.
SurfaceModel
makeStall(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(2.2, 3.2);
  const double x = width / 2 - 0.05;
  model.addBlock({0, 0.5, 0}, {width, 0.6, 0.95}, 0, parts::paint(model, Stuff::Wood));
  model.addBlock({0, -0.85, 0}, {width, 0.3, random.uniform(1.5, 2)}, 0, parts::paint(model, Stuff::DarkWood));
  for (const double px : {-x, x})
    for (const double py : {-0.95, 0.95})
      parts::addPipe(model, {px, py, 0}, {px, py, py < 0 ? 2.7 : 2.3}, 0.03, Stuff::Metal);
  model.addPolygon({{-x - 0.1, -1, 2.71}, {x + 0.1, -1, 2.71}, {x + 0.1, 1.2, 2.25}, {-x - 0.1, 1.2, 2.25}},
                   parts::paint(model, Stuff::LightCloth));
  return model;
}

/// A board on two feet.
SurfaceModel
makeBoard(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(1, 1.8);
  for (const double x : {-width / 2 + 0.1, width / 2 - 0.1}) {
    model.addBlock({x, 0, 0}, {0.06, 0.5, 0.04}, 0, parts::paint(model, Stuff::Metal));
    model.addBlock({x, 0, 0}, {0.05, 0.05, 2.0}, 0, parts::paint(model, Stuff::Metal));
  }
  model.addBlock({0, 0.03, 0.7}, {width, 0.03, 1.3}, 0, parts::paint(model, Stuff::Paper));
  return model;
}

/// A gallery along x between two depths, with a railing at its inner edge; \p z of its floor.
void
addGallery(SceneBuilder& b, const Rect& floor, double rail, double z)
{
  SurfaceModel& m = b.model();
  parts::addSlab(m, floor, z, 0.35, {}, Stuff::Concrete);
  parts::addRailing(m, {floor.x0, rail, z}, {floor.x1, rail, z}, 1.1);
  // Cables, pipes and lamps below it.
  const double middle = floor.centre().y();
  m.addBlock({floor.centre().x(), middle - 1, z - 0.6}, {floor.width(), 0.3, 0.03}, 0, parts::paint(m, Stuff::Metal));
  for (int i = 0; i < 2; ++i) {
    const double y = middle + 0.6 + 0.3 * i;
    parts::addPipe(m, {floor.x0, y, z - 0.55}, {floor.x1, y, z - 0.55}, b.vary(0.05, 0.1), Stuff::Metal);
  }
  for (double x = floor.x0 + 3; x < floor.x1 - 2; x += b.vary(5.5, 7))
    m.append(parts::makePanelLamp(1.5), parts::standAt({x, middle, z - 0.35}));
}

} // namespace

Scene
makeHall(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const double length = b.vary(63.5, 66);
  const double depth = b.vary(35, 37);
  const double h = b.vary(11.5, 12.5);
  const double aisle = b.vary(6.8, 7.3); // depth of the side aisles under the galleries
  const double middle = depth / 2;
  const int bays = 10;
  const double bay = length / bays;
  // The patio: a courtyard between glass walls, open to the sky, off the middle of the hall.
  const Rect patio{0.60 * length, middle - 4.5, 0.60 * length + b.vary(11, 13), middle + b.vary(3.8, 4.5)};
  const double mezzanine = b.vary(8.5, 9.5); // reaches so far from the western wall
  const double level = 3.6;                  // of the mezzanine's floor

  b.setPath({{12, middle + 0.4, 0},
             {patio.x0 - 5, middle, 0},
             {patio.x0 - 2, patio.y0 - 2.2, 0},
             {patio.x1 + 1.5, patio.y0 - 2.3, 0},
             {patio.x1 + 4, middle, 0},
             {patio.x1 + 1, patio.y1 + 2.3, 0},
             {patio.x0 - 2, patio.y1 + 2.3, 0},
             {0.42 * length, depth - aisle - 2.2, 0},
             {16, depth - aisle - 2.4, 0},
             {13, depth - 0.55 * aisle, 0},
             {6, depth - 0.55 * aisle, 0},
             {4.5, middle + 2, 0}});

  const Rect outline{0, 0, length, depth};
  parts::addSlab(m, outline.grown(kOuter), 0, 0.3, {patio}, Stuff::Stone);
  parts::addSlab(m, patio, -0.05, 0.25, {}, Stuff::Carpet);
  parts::addSlab(m, outline.grown(kOuter), h + 0.3, 0.3, {patio}, Stuff::Concrete);

  // Outer walls: doors and shop windows below, high windows above the galleries.
  const double o = kOuter / 2;
  const double split = kGallery - 0.35;
  const auto shell = [&](const Vector2d& from, const Vector2d& to, double spacing) {
    const double side = (to - from).norm();
    std::vector<Opening> low = rowOf(side, spacing, 2.6, 0.4, 3.2, Filling::Window);
    for (Opening& opening : low)
      if (b.chance(0.35))
        opening = {opening.centre, 1.8, 0, 2.5, Filling::Shut, 1, false};
    b.addWall({from, to, kOuter, low, Stuff::Plaster}, 0, split);
    b.addWall({from, to, kOuter, rowOf(side, spacing, 3.2, 1.4, h - split - 1.2, Filling::Window), Stuff::Brick},
              split,
              h - split);
  };
  shell({-o, -o}, {length + o, -o}, bay);
  shell({length + o, -o}, {length + o, depth + o}, 7);
  shell({length + o, depth + o}, {-o, depth + o}, bay);
  shell({-o, depth + o}, {-o, -o}, 8);

  // Galleries on both long sides carried by columns that go up to the roof; beams across the hall.
  const double from = mezzanine + 2; // the galleries begin east of the stairs to the mezzanine
  addGallery(b, {from, 0, length, aisle}, aisle - 0.1, kGallery);
  addGallery(b, {from, depth - aisle, length, depth}, depth - aisle + 0.1, kGallery);
  parts::addRailing(m, {from + 0.05, 0.2, kGallery}, {from + 0.05, aisle, kGallery}, 1.1);
  parts::addRailing(m, {from + 0.05, depth - aisle, kGallery}, {from + 0.05, depth - 0.2, kGallery}, 1.1);
  for (int i = 0; i < bays; ++i) {
    const double x = bay * (i + 0.5);
    for (const double y : {aisle, depth - aisle}) {
      m.addColumn({x, y, 0}, 0.3, h, parts::paint(m, Stuff::Concrete));
      m.addBlock({x, y, 0}, {0.9, 0.9, 0.3}, 0, parts::paint(m, Stuff::Stone));
      b.block(Rect{x, y, x, y}.grown(0.45), 0, h);
    }
    const bool over_patio = x > patio.x0 - 0.5 && x < patio.x1 + 0.5;
    if (!over_patio) {
      m.addBlock({x, middle, h - 0.9}, {0.35, depth, 0.9}, 0, parts::paint(m, Stuff::Concrete));
      for (const double y : {middle - 5, middle + 5})
        m.append(parts::makePendantLamp(r), parts::standAt({x + bay / 2 < patio.x0 ? x + bay / 2 : x, y, h - 0.9}));
    }
  }
  // A ventilation duct with hangers, and pipes along the hall under the beams.
  const double duct = middle - 9 + b.vary(-0.5, 0.5);
  parts::addPipe(m, {1, duct, h - 1.5}, {length - 1, duct, h - 1.5}, 0.45, Stuff::Metal);
  for (double x = 3; x < length - 2; x += 4)
    parts::addPipe(m, {x, duct, h - 1.1}, {x, duct, h}, 0.012, Stuff::Metal);
  for (int i = 0; i < 3; ++i) {
    const double y = middle + 9.5 + 0.25 * i;
    parts::addPipe(m, {0.2, y, h - 1.1}, {length - 0.2, y, h - 1.1}, 0.06, Stuff::Metal);
  }

  // The mezzanine in the west with its stairs.
  const Rect platform{0, aisle + 1, mezzanine, depth - aisle - 1};
  parts::addSlab(m, platform, level, 0.35, {}, Stuff::Concrete);
  parts::addRailing(m, {mezzanine - 0.05, platform.y0 + 2.4, level}, {mezzanine - 0.05, platform.y1, level}, 1.1);
  parts::addRailing(m, {0.1, platform.y1 - 0.05, level}, {mezzanine, platform.y1 - 0.05, level}, 1.1);
  parts::addRailing(m, {0.1, platform.y0 + 0.05, level}, {mezzanine, platform.y0 + 0.05, level}, 1.1);
  for (const double y : {platform.y0 + 3, middle - 1.2, platform.y1 - 3})
    if (b.isFree(Rect{mezzanine - 0.7, y, mezzanine - 0.7, y}.grown(0.2), 0, level)) {
      m.addColumn({mezzanine - 0.7, y, 0}, 0.2, level - 0.35, parts::paint(m, Stuff::Metal));
      b.block(Rect{mezzanine - 0.7, y, mezzanine - 0.7, y}.grown(0.2), 0, level);
    }
  constexpr int kSteps = 20;
  const double tread = 0.29;
  const double flight = platform.y0 + 1.2;
  m.append(parts::makeStairs(2, kSteps, level / kSteps, tread, Stuff::Concrete),
           parts::standAt({mezzanine + kSteps * tread, flight, 0}, kPi / 2));
  b.block({mezzanine - 0.5, flight - 1.3, mezzanine + kSteps * tread + 1, flight + 1.3}, 0, level);
  for (const double y : {flight - 1, flight + 1}) {
    const Vector3d low(mezzanine + kSteps * tread, y, 1.0);
    const Vector3d high(mezzanine, y, level + 1.0);
    parts::addPipe(m, low, high, 0.03, Stuff::Metal);
    for (int i = 0; i <= kSteps; i += 2) {
      const Vector3d post = low + (high - low) * (static_cast<double>(i) / kSteps);
      parts::addPipe(m, post - Vector3d(0, 0, 1.0), post, 0.015, Stuff::Metal);
    }
  }
  // A room under the mezzanine's southern part, and a counter on it.
  const double office = platform.y0 + 4.5;
  b.addWall({{0, office}, {4.5, office}, 0.15, {{3.2, 1.0, 0, 2.1, Filling::Door, -1, false}}, Stuff::Plaster},
            0,
            level - 0.35);
  b.addWall({{4.5, office}, {4.5, platform.y0}, 0.15, {{2, 1.6, 1, 2.2, Filling::Window, 1, false}}, Stuff::Plaster},
            0,
            level - 0.35);
  b.addWall({{4.5, platform.y0}, {0, platform.y0}, 0.15, {}, Stuff::Plaster}, 0, level - 0.35);
  m.append(parts::makeSofa(r, 2.2), parts::standAt({0.6, middle, level}, -kPi / 2));
  for (int i = 0; i < 3; ++i)
    m.append(parts::makeTable(r, 1.2, 0.8),
             parts::standAt({b.vary(3, 7), platform.y0 + 5 + 3.5 * i, level}, b.vary(0, 1)));

  // The patio: posts and panes up to the roof, trees and plants inside.
  const auto glass = [&](const Vector2d& a, const Vector2d& c) {
    const double side = (c - a).norm();
    for (double z = 0; z + 0.5 < h; z += h / 3) {
      std::vector<Opening> panes =
          rowOf(side, 2.2, side / std::floor(side / 2.2) - 0.12, 0.06, h / 3 - 0.06, Filling::Window);
      b.addWall({a, c, 0.12, panes, Stuff::Metal}, z, h / 3);
    }
  };
  glass({patio.x0, patio.y0}, {patio.x1, patio.y0});
  glass({patio.x1, patio.y0}, {patio.x1, patio.y1});
  glass({patio.x1, patio.y1}, {patio.x0, patio.y1});
  glass({patio.x0, patio.y1}, {patio.x0, patio.y0});
  for (int i = 0; i < 3; ++i)
    m.append(parts::makeTree(r),
             parts::standAt({patio.x0 + 2.5 + 3 * i, patio.centre().y() + b.vary(-1.5, 1.5), 0}, b.vary(0, 2 * kPi)));
  b.block(patio.grown(0.1), 0, h);

  // What stands in the hall.
  const Rect nave{1, aisle + 0.5, length - 1, depth - aisle - 0.5};
  const Rect south{from + 1, 0, length, aisle - 0.6};
  const Rect north{from + 1, depth - aisle + 0.6, length, depth};
  for (int i = 0; i < 9; ++i)
    b.placeInside(makeStall(r), i < 5 ? Rect{20, nave.y0, length - 2, nave.y1} : (i % 2 == 0 ? north : south), 0);
  for (int i = 0; i < 18; ++i)
    b.placeInside(parts::makeBench(r), i < 10 ? nave : (i % 2 == 0 ? south : north), 0);
  for (int i = 0; i < 10; ++i)
    b.placeInside(makeBoard(r), i < 5 ? south : north, 0);
  for (int i = 0; i < 14; ++i)
    b.placeInside(parts::makePlant(r), i < 6 ? nave : (i % 2 == 0 ? south : north), 0);
  for (int i = 0; i < 8; ++i)
    b.placeInside(parts::makeTable(r, 0.9, 0.9), {nave.x1 - 14, nave.y0, nave.x1, nave.y1}, 0);
  for (int i = 0; i < 8; ++i) {
    const Rect& room = i % 2 == 0 ? south : north;
    const auto side = i % 2 == 0 ? SceneBuilder::South : SceneBuilder::North;
    b.placeAtWall(parts::makeCupboard(r, b.vary(1, 2), 0.5, b.vary(0.9, 2.1)), room, 0, side);
    b.placeAtWall(parts::makeShelf(r, b.vary(1, 2), b.vary(1.6, 2.1)), room, kGallery, side);
  }
  for (int i = 0; i < 6; ++i)
    b.placeInside(parts::makeTable(r, 1.4, 0.8), i % 2 == 0 ? south : north, kGallery);
  b.addWalkAreas(nave, 0, 8, 1.5, 5);
  b.addWalkAreas(south, 0, 4, 1.2, 4);
  b.addWalkAreas(north, 0, 4, 1.2, 4);
  for (int i = 0; i < 24; ++i)
    b.placeLooseInside(
        i % 3 == 0 ? parts::makeBox(r) : parts::makeChair(r), i % 2 == 0 ? nave : (i % 4 == 1 ? south : north), 0);
  return b.finish("hall with columns, galleries, a mezzanine and a patio, 65 m by 36 m", 8, "leica_p20");
}

} // namespace pcl_ssfr::simulation
