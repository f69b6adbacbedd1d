// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_parts.h>

#include "common/angles.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace pcl_ssfr::simulation::parts {

namespace {

using Eigen::Vector3d;

/// A block of a part, its base in the middle at (x, y, z).
void
block(SurfaceModel& model, double x, double y, double z, const Vector3d& size, Stuff stuff, double yaw = 0)
{
  model.addBlock({x, y, z}, size, yaw, paint(model, stuff));
}

void
addLegs(SurfaceModel& model, double width, double depth, double height, double thickness, Stuff stuff)
{
  const double x = width / 2 - thickness;
  const double y = depth / 2 - thickness;
  for (const double sx : {-x, x})
    for (const double sy : {-y, y})
      block(model, sx, sy, 0, {thickness, thickness, height}, stuff);
}

/// Small things on a surface: boxes, bottles, piles of paper.
void
addThings(SurfaceModel& model, RandomStream& random, const Rect& area, double z, int count)
{
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(area.x0, area.x1);
    const double y = random.uniform(area.y0, area.y1);
    const int kind = random.index(3);
    if (kind == 0)
      model.addColumn({x, y, z}, random.uniform(0.03, 0.05), random.uniform(0.08, 0.3), paint(model, Stuff::Tile));
    else if (kind == 1)
      block(model, x, y, z, {0.22, 0.3, random.uniform(0.01, 0.08)}, Stuff::Paper, random.uniform(-0.5, 0.5));
    else
      block(model,
            x,
            y,
            z,
            {random.uniform(0.08, 0.25), random.uniform(0.08, 0.2), random.uniform(0.05, 0.25)},
            Stuff::WhitePlastic,
            random.uniform(-0.5, 0.5));
  }
}

Stuff
anyOf(RandomStream& random, std::initializer_list<Stuff> stuffs)
{
  return *(stuffs.begin() + random.index(static_cast<int>(stuffs.size())));
}

void
addLeaf(SurfaceModel& model, RandomStream& random, const Vector3d& at, double size, std::uint16_t material)
{
  const Eigen::Matrix3d turn = random.rotation();
  const Vector3d u = turn.col(0) * size;
  const Vector3d v = turn.col(1) * size * 0.6;
  model.addPolygon({at - u, at - v, at + u, at + v}, material);
}

} // namespace

SurfaceModel
makeTable(RandomStream& random, double width, double depth)
{
  SurfaceModel model;
  const double height = random.uniform(0.71, 0.77);
  addLegs(model, width, depth, height - 0.03, 0.06, Stuff::Wood);
  block(model, 0, 0, height - 0.03, {width, depth, 0.03}, Stuff::Wood);
  const Rect top{-width / 2 + 0.2, -depth / 2 + 0.2, width / 2 - 0.2, depth / 2 - 0.2};
  addThings(model, random, top, height, random.index(4));
  return model;
}

SurfaceModel
makeChair(RandomStream& random)
{
  SurfaceModel model;
  const double seat = random.uniform(0.43, 0.47);
  const Stuff stuff = anyOf(random, {Stuff::Wood, Stuff::DarkWood, Stuff::DarkCloth});
  addLegs(model, 0.42, 0.42, seat - 0.03, 0.035, Stuff::Wood);
  block(model, 0, 0, seat - 0.03, {0.42, 0.42, 0.03}, stuff);
  for (const double x : {-0.19, 0.19})
    block(model, x, -0.19, seat, {0.035, 0.035, 0.45}, Stuff::Wood);
  block(model, 0, -0.19, seat + 0.2, {0.4, 0.02, 0.22}, stuff);
  return model;
}

SurfaceModel
makeOfficeChair(RandomStream& random)
{
  SurfaceModel model;
  const double seat = random.uniform(0.44, 0.5);
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * kPi * i / 5;
    addPipe(model, {0, 0, 0.08}, {0.28 * std::cos(angle), 0.28 * std::sin(angle), 0.06}, 0.02, Stuff::BlackPlastic);
  }
  addPipe(model, {0, 0, 0.08}, {0, 0, seat}, 0.03, Stuff::Metal);
  block(model, 0, 0, seat, {0.48, 0.46, 0.07}, Stuff::DarkCloth);
  addHexahedron(
      model,
      {{-0.22, -0.26, seat + 0.1}, {0.22, -0.26, seat + 0.1}, {0.22, -0.2, seat + 0.1}, {-0.22, -0.2, seat + 0.1}},
      {{-0.2, -0.34, seat + 0.6}, {0.2, -0.34, seat + 0.6}, {0.2, -0.3, seat + 0.6}, {-0.2, -0.3, seat + 0.6}},
      Stuff::DarkCloth);
  for (const double x : {-0.26, 0.26})
    block(model, x, -0.02, seat + 0.2, {0.05, 0.26, 0.03}, Stuff::BlackPlastic);
  return model;
}

SurfaceModel
makeDesk(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(1.4, 1.7);
  const double depth = 0.8;
  const double height = random.uniform(0.7, 0.76);
  for (const double x : {-width / 2 + 0.03, width / 2 - 0.03})
    block(model, x, 0, 0, {0.04, depth - 0.1, height - 0.03}, Stuff::Metal);
  block(model, 0, 0, height - 0.03, {width, depth, 0.03}, Stuff::Wood);
  const int screens = 1 + random.index(2);
  for (int i = 0; i < screens; ++i) {
    const double x = (i - 0.5 * (screens - 1)) * 0.6;
    const double turn = random.uniform(-0.2, 0.2);
    block(model, x, -0.22, height, {0.22, 0.18, 0.015}, Stuff::BlackPlastic, turn);
    block(model, x, -0.24, height, {0.05, 0.03, 0.25}, Stuff::BlackPlastic, turn);
    block(model, x, -0.21, height + 0.12, {0.54, 0.03, 0.33}, Stuff::BlackPlastic, turn);
  }
  block(model, 0, 0.12, height, {0.44, 0.14, 0.02}, Stuff::BlackPlastic);
  addThings(model, random, {-width / 2 + 0.2, -0.1, width / 2 - 0.2, 0.25}, height, random.index(5));
  block(model, width / 2 - 0.3, -0.02, 0.02, {0.4, 0.55, 0.56}, Stuff::LightPaint);
  return model;
}

SurfaceModel
makeShelf(RandomStream& random, double width, double height)
{
  SurfaceModel model;
  const double depth = random.uniform(0.3, 0.36);
  const Stuff stuff = anyOf(random, {Stuff::Wood, Stuff::DarkWood, Stuff::LightPaint});
  for (const double x : {-width / 2 + 0.01, width / 2 - 0.01})
    block(model, x, 0, 0, {0.02, depth, height}, stuff);
  block(model, 0, -depth / 2 + 0.005, 0, {width - 0.04, 0.01, height}, stuff);
  const int boards = std::max(2, static_cast<int>(std::lround(height / 0.37)));
  const double field = (height - 0.02) / boards;
  for (int i = 0; i <= boards; ++i)
    block(model, 0, 0.005, field * i, {width - 0.04, depth - 0.01, 0.02}, stuff);
  for (int i = 0; i < boards; ++i) {
    // Runs of books, each about as high and deep.
    double x = -width / 2 + 0.04;
    while (x < width / 2 - 0.15) {
      const double run = std::min(random.uniform(0.08, 0.4), width / 2 - 0.04 - x);
      if (random.uniform() < 0.75) {
        const double deep = random.uniform(0.15, depth - 0.04);
        block(model,
              x + run / 2,
              -depth / 2 + 0.01 + deep / 2,
              field * i + 0.02,
              {run, deep, random.uniform(0.4, 0.85) * field},
              anyOf(random, {Stuff::Paper, Stuff::DarkCloth, Stuff::LightCloth, Stuff::WhitePlastic}));
      }
      x += run + 0.01;
    }
  }
  return model;
}

SurfaceModel
makeCupboard(RandomStream& random, double width, double depth, double height)
{
  SurfaceModel model;
  const Stuff stuff = anyOf(random, {Stuff::Wood, Stuff::LightPaint, Stuff::DarkWood});
  block(model, 0, 0, 0, {width, depth - 0.02, height}, stuff);
  const int doors = std::max(1, static_cast<int>(std::lround(width / 0.55)));
  const double leaf = width / doors;
  for (int i = 0; i < doors; ++i) {
    const double x = -width / 2 + leaf * (i + 0.5);
    block(model, x, depth / 2 - 0.01, 0.08, {leaf - 0.01, 0.02, height - 0.1}, stuff);
    const double grip = x + (i % 2 == 0 ? 1 : -1) * (leaf / 2 - 0.05);
    block(model, grip, depth / 2 + 0.015, 0.45 * height, {0.015, 0.03, 0.15}, Stuff::Metal);
  }
  if (height < 1.3)
    addThings(model, random, {-width / 2 + 0.15, -0.1, width / 2 - 0.15, 0.1}, height, random.index(4));
  return model;
}

SurfaceModel
makeBed(RandomStream& random, double width)
{
  SurfaceModel model;
  constexpr double kLength = 2.05;
  block(model, 0, 0, 0.12, {width, kLength, 0.2}, Stuff::Wood);
  addLegs(model, width, kLength, 0.12, 0.08, Stuff::Wood);
  block(model, 0, 0.01, 0.32, {width - 0.06, kLength - 0.08, 0.18}, Stuff::LightCloth);
  block(model, 0, -kLength / 2 + 0.02, 0.32, {width, 0.04, random.uniform(0.4, 0.7)}, Stuff::Wood);
  const int pillows = width > 1.3 ? 2 : 1;
  for (int i = 0; i < pillows; ++i)
    addBlob(model,
            {(i - 0.5 * (pillows - 1)) * width / 2, -kLength / 2 + 0.35, 0.53},
            {0.32, 0.22, 0.09},
            8,
            0.02,
            random.next(),
            Stuff::LightCloth);
  // A rumpled blanket.
  addBlob(model,
          {random.uniform(-0.05, 0.05), 0.35, 0.46},
          {width / 2 - 0.03, 0.62, 0.16},
          12,
          0.05,
          random.next(),
          Stuff::LightCloth);
  return model;
}

SurfaceModel
makeSofa(RandomStream& random, double width)
{
  SurfaceModel model;
  const Stuff stuff = anyOf(random, {Stuff::DarkCloth, Stuff::LightCloth});
  constexpr double kDepth = 0.9;
  block(model, 0, 0, 0.06, {width, kDepth, 0.3}, stuff);
  for (const double x : {-width / 2 + 0.1, width / 2 - 0.1})
    block(model, x, 0, 0.36, {0.2, kDepth, 0.24}, stuff);
  addHexahedron(
      model,
      {{-width / 2, -0.45, 0.36}, {width / 2, -0.45, 0.36}, {width / 2, -0.2, 0.36}, {-width / 2, -0.2, 0.36}},
      {{-width / 2, -0.45, 0.82}, {width / 2, -0.45, 0.82}, {width / 2, -0.33, 0.82}, {-width / 2, -0.33, 0.82}},
      stuff);
  const int cushions = std::max(2, static_cast<int>(std::lround((width - 0.4) / 0.7)));
  const double cushion = (width - 0.42) / cushions;
  for (int i = 0; i < cushions; ++i) {
    const double x = -width / 2 + 0.21 + cushion * (i + 0.5);
    block(model, x, 0.12, 0.36, {cushion - 0.02, 0.62, 0.1}, stuff);
    if (random.uniform() < 0.5)
      addBlob(model, {x, -0.12, 0.62}, {0.22, 0.09, 0.2}, 8, 0.02, random.next(), Stuff::LightCloth);
  }
  return model;
}

SurfaceModel
makeKitchenRow(RandomStream& random, double width)
{
  SurfaceModel model;
  const double base = width - 0.65; // the fridge stands at the end
  const double left = -width / 2;
  block(model, left + base / 2, 0, 0.1, {base, 0.56, 0.76}, Stuff::LightPaint);
  block(model, left + base / 2, -0.03, 0, {base, 0.5, 0.1}, Stuff::DarkPaint);
  block(model, left + base / 2, 0.01, 0.86, {base, 0.62, 0.04}, Stuff::Stone);
  const int fields = std::max(2, static_cast<int>(std::lround(base / 0.6)));
  const int hood = fields / 2; // instead of a cupboard
  for (int i = 0; i < fields; ++i) {
    const double x = left + base / fields * (i + 0.5);
    block(model, x, 0.29, 0.12, {base / fields - 0.01, 0.02, 0.72}, Stuff::LightPaint);
    block(model, x, 0.31, 0.76, {0.2, 0.02, 0.015}, Stuff::Metal);
    if (i != hood)
      block(model, x, -0.13, 1.42, {base / fields - 0.005, 0.34, 0.66}, Stuff::LightPaint);
  }
  const double middle = left + base / fields * (hood + 0.5);
  addHexahedron(
      model,
      {{middle - 0.3, -0.3, 1.55}, {middle + 0.3, -0.3, 1.55}, {middle + 0.3, 0.15, 1.55}, {middle - 0.3, 0.15, 1.55}},
      {{middle - 0.12, -0.3, 1.8},
       {middle + 0.12, -0.3, 1.8},
       {middle + 0.12, -0.06, 1.8},
       {middle - 0.12, -0.06, 1.8}},
      Stuff::Metal);
  addPipe(model, {left + 0.4, -0.2, 0.9}, {left + 0.4, -0.2, 1.2}, 0.015, Stuff::Metal);
  addPipe(model, {left + 0.4, -0.2, 1.2}, {left + 0.4, 0, 1.15}, 0.012, Stuff::Metal);
  addThings(model, random, {left + 0.2, -0.15, left + base - 0.2, 0.1}, 0.9, 3 + random.index(5));
  block(model, width / 2 - 0.31, 0, 0.02, {0.6, 0.62, random.uniform(1.7, 1.9)}, Stuff::WhitePlastic);
  return model;
}

SurfaceModel
makeBathTub()
{
  SurfaceModel model;
  for (const double y : {-0.34, 0.34})
    block(model, 0, y, 0, {1.7, 0.07, 0.56}, Stuff::Tile);
  for (const double x : {-0.8, 0.8})
    block(model, x, 0, 0, {0.1, 0.61, 0.56}, Stuff::Tile);
  block(model, 0, 0, 0.1, {1.5, 0.61, 0.04}, Stuff::Tile);
  addPipe(model, {0.7, -0.3, 0.56}, {0.7, -0.3, 1.9}, 0.012, Stuff::Metal);
  return model;
}

SurfaceModel
makeToilet()
{
  SurfaceModel model;
  block(model, 0, -0.28, 0.38, {0.38, 0.16, 0.4}, Stuff::Tile);
  addBlob(model, {0, 0.02, 0.22}, {0.18, 0.28, 0.2}, 8, 0, 0, Stuff::Tile);
  block(model, 0, -0.06, 0, {0.2, 0.4, 0.3}, Stuff::Tile);
  block(model, 0, 0.02, 0.4, {0.36, 0.48, 0.03}, Stuff::WhitePlastic);
  return model;
}

SurfaceModel
makeWashBasin(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(0.55, 0.75);
  block(model, 0, 0, 0.72, {width, 0.46, 0.14}, Stuff::Tile);
  addPipe(model, {0, -0.1, 0.1}, {0, -0.1, 0.72}, 0.05, Stuff::Tile);
  addPipe(model, {0, -0.16, 0.86}, {0, -0.16, 0.98}, 0.015, Stuff::Metal);
  block(model, 0, -0.22, 1.15, {width, 0.015, 0.8}, Stuff::Glass);
  return model;
}

SurfaceModel
makeRadiator(double width)
{
  SurfaceModel model;
  for (const double y : {-0.02, 0.04})
    block(model, 0, y, 0.15, {width, 0.02, 0.55}, Stuff::LightPaint);
  block(model, 0, 0.01, 0.68, {width, 0.08, 0.015}, Stuff::LightPaint);
  addPipe(model, {width / 2 + 0.03, 0, 0}, {width / 2 + 0.03, 0, 0.2}, 0.01, Stuff::Metal);
  return model;
}

SurfaceModel
makePlant(RandomStream& random)
{
  SurfaceModel model;
  const double height = random.uniform(0.6, 1.3);
  model.addColumn({0, 0, 0}, 0.16, 0.3, paint(model, Stuff::Brick));
  addPipe(model, {0, 0, 0.3}, {0, 0, height}, 0.015, Stuff::DarkWood);
  const std::uint16_t material = paint(model, Stuff::Foliage);
  for (int i = 0; i < 60; ++i) {
    const double angle = random.uniform(0, 2 * kPi);
    const double radius = random.uniform(0.03, 0.24);
    addLeaf(model,
            random,
            {radius * std::cos(angle), radius * std::sin(angle), random.uniform(0.4, height + 0.2)},
            random.uniform(0.05, 0.1),
            material);
  }
  return model;
}

SurfaceModel
makeBox(RandomStream& random)
{
  SurfaceModel model;
  const Vector3d size(random.uniform(0.35, 0.7), random.uniform(0.3, 0.6), random.uniform(0.25, 0.6));
  block(model, 0, 0, 0, size, Stuff::Paper);
  if (random.uniform() < 0.4)
    block(model, 0.03, 0.02, size.z(), {0.3, 0.28, random.uniform(0.15, 0.3)}, Stuff::Paper, random.uniform(-0.3, 0.3));
  return model;
}

SurfaceModel
makeBench(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(1.5, 2.2);
  for (const double x : {-width / 2 + 0.2, width / 2 - 0.2})
    block(model, x, 0, 0, {0.08, 0.4, 0.42}, Stuff::Metal);
  for (const double y : {-0.17, -0.04, 0.09})
    block(model, 0, y, 0.42, {width, 0.1, 0.04}, Stuff::Wood);
  for (const double z : {0.62, 0.78})
    block(model, 0, -0.25, z, {width, 0.03, 0.1}, Stuff::Wood);
  for (const double x : {-width / 2 + 0.2, width / 2 - 0.2})
    block(model, x, -0.22, 0.42, {0.06, 0.04, 0.48}, Stuff::Metal);
  return model;
}

SurfaceModel
makePicture(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(0.3, 1.1);
  const double height = random.uniform(0.3, 0.8);
  block(model, 0, 0, 0, {width, 0.025, height}, Stuff::DarkWood);
  block(model, 0, 0.0125, 0.04, {width - 0.08, 0.01, height - 0.08}, Stuff::Paper);
  return model;
}

SurfaceModel
makePendantLamp(RandomStream& random)
{
  SurfaceModel model;
  const double drop = random.uniform(0.15, 0.3);
  addPipe(model, {0, 0, -drop}, {0, 0, 0}, 0.006, Stuff::BlackPlastic);
  model.spheres.push_back({{0, 0, -drop - 0.12}, random.uniform(0.1, 0.16), paint(model, Stuff::WhitePlastic)});
  return model;
}

SurfaceModel
makePanelLamp(double length)
{
  SurfaceModel model;
  block(model, 0, 0, -0.07, {length, 0.2, 0.06}, Stuff::WhitePlastic);
  return model;
}

SurfaceModel
makeCar(RandomStream& random)
{
  SurfaceModel model;
  const Stuff paintwork = anyOf(random, {Stuff::DarkPaint, Stuff::LightPaint, Stuff::Metal});
  const double length = random.uniform(3.8, 4.7);
  const double half_width = random.uniform(0.84, 0.92);
  const double height = random.uniform(1.4, 1.65);
  const double front = length / 2;
  const double waist = random.uniform(0.82, 0.92);
  // Body: a lower part that leans in at bow and stern; lies along y, the bow at +y.
  addHexahedron(
      model,
      {{-half_width, -front, 0.28}, {half_width, -front, 0.28}, {half_width, front, 0.28}, {-half_width, front, 0.28}},
      {{-half_width + 0.02, -front + 0.08, waist},
       {half_width - 0.02, -front + 0.08, waist},
       {half_width - 0.02, front - 0.15, waist - 0.12},
       {-half_width + 0.02, front - 0.15, waist - 0.12}},
      paintwork);
  // Cabin: four sides of glass that slant, a roof, and posts at the corners.
  const double stern = -front + random.uniform(0.15, 0.6);
  const double bow = front - random.uniform(0.9, 1.15);
  const std::vector<Vector3d> below{{-half_width + 0.04, stern, waist},
                                    {half_width - 0.04, stern, waist},
                                    {half_width - 0.04, bow, waist - 0.09},
                                    {-half_width + 0.04, bow, waist - 0.09}};
  const double roof = half_width - 0.2;
  const std::vector<Vector3d> above{
      {-roof, stern + 0.4, height}, {roof, stern + 0.4, height}, {roof, bow - 0.8, height}, {-roof, bow - 0.8, height}};
  addHexahedron(model, below, above, Stuff::Glass);
  addHexahedron(model,
                above,
                {above[0] + Vector3d(0.03, 0.03, 0.03),
                 above[1] + Vector3d(-0.03, 0.03, 0.03),
                 above[2] + Vector3d(-0.03, -0.03, 0.03),
                 above[3] + Vector3d(0.03, -0.03, 0.03)},
                paintwork);
  for (std::size_t i = 0; i < 4; ++i)
    addPipe(model, below[i], above[i], 0.035, paintwork);
  for (const double x : {-half_width, half_width}) {
    addPipe(model, {x * 0.94, (stern + bow) / 2, waist}, {x * 0.78, (stern + bow) / 2, height}, 0.035, paintwork);
    block(model, x * 1.06, bow - 0.25, waist - 0.02, {0.16, 0.1, 0.13}, paintwork);
    for (const double y : {-front + 0.75, front - 0.8}) {
      const double inner = x * 0.78;
      const double outer = x * 1.02;
      addPipe(model, {inner, y, 0.31}, {outer, y, 0.31}, 0.31, Stuff::Rubber);
      addDisc(model, {outer, y, 0.31}, {x, 0, 0}, 0.31, 16, Stuff::Rubber);
      addDisc(model, {outer + 0.01 * (x > 0 ? 1 : -1), y, 0.31}, {x, 0, 0}, 0.2, 12, Stuff::Metal);
    }
  }
  return model;
}

SurfaceModel
makeTree(RandomStream& random)
{
  SurfaceModel model;
  const double trunk = random.uniform(2.4, 3.4);
  const double radius = random.uniform(0.1, 0.2);
  const Vector3d crown(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), trunk + random.uniform(1.2, 2));
  const Vector3d radii(random.uniform(1.4, 2.2), random.uniform(1.4, 2.2), random.uniform(1.5, 2.4));
  const Vector3d fork(0, 0, trunk);
  addPipe(model, {0, 0, -0.2}, fork, radius, Stuff::DarkWood);
  for (int i = 0; i < 7; ++i) {
    const Vector3d tip = crown + (random.rotation().col(0) * 0.7).cwiseProduct(radii);
    addPipe(model, fork - Vector3d(0, 0, random.uniform(0, 0.5)), tip, 0.04, Stuff::DarkWood);
  }
  // Leaves, dense towards the outside of the crown.
  const std::uint16_t material = paint(model, Stuff::Foliage);
  for (int i = 0; i < 700; ++i) {
    const double depth = std::pow(random.uniform(), 0.4);
    const Vector3d at = crown + (random.rotation().col(0) * depth).cwiseProduct(radii);
    addLeaf(model, random, at, random.uniform(0.08, 0.18), material);
  }
  return model;
}

SurfaceModel
makeLampPost(RandomStream& random)
{
  SurfaceModel model;
  const double height = random.uniform(6, 7.5);
  addPipe(model, {0, 0, -0.2}, {0, 0, 1.2}, 0.09, Stuff::Metal);
  addPipe(model, {0, 0, 1.2}, {0, 0, height}, 0.06, Stuff::Metal);
  addPipe(model, {0, 0, height}, {0, 1.2, height + 0.2}, 0.04, Stuff::Metal);
  block(model, 0, 1.3, height + 0.1, {0.2, 0.6, 0.12}, Stuff::Metal);
  return model;
}

SurfaceModel
makeSign(RandomStream& random)
{
  SurfaceModel model;
  const double height = random.uniform(2.2, 2.6);
  addPipe(model, {0, 0, -0.2}, {0, 0, height + 0.7}, 0.03, Stuff::Metal);
  if (random.uniform() < 0.5)
    addDisc(model, {0, 0.04, height + 0.35}, {0, 1, 0}, 0.3, 16, Stuff::LightPaint);
  else
    block(model, 0, 0.04, height + 0.1, {0.5, 0.01, 0.55}, Stuff::LightPaint);
  return model;
}

SurfaceModel
makeBin(RandomStream& random)
{
  SurfaceModel model;
  const double width = random.uniform(0.45, 0.6);
  addHexahedron(model,
                {{-0.8 * width / 2, -0.25, 0},
                 {0.8 * width / 2, -0.25, 0},
                 {0.8 * width / 2, 0.2, 0},
                 {-0.8 * width / 2, 0.2, 0}},
                {{-width / 2, -0.35, 0.98}, {width / 2, -0.35, 0.98}, {width / 2, 0.3, 0.98}, {-width / 2, 0.3, 0.98}},
                Stuff::BlackPlastic);
  addHexahedron(
      model,
      {{-width / 2, -0.35, 0.98}, {width / 2, -0.35, 0.98}, {width / 2, 0.33, 0.98}, {-width / 2, 0.33, 0.98}},
      {{-width / 2, -0.3, 1.08}, {width / 2, -0.3, 1.08}, {width / 2, 0.28, 1.0}, {-width / 2, 0.28, 1.0}},
      Stuff::BlackPlastic);
  return model;
}

SurfaceModel
makePerson(RandomStream& random)
{
  SurfaceModel model;
  const double height = random.uniform(1.55, 1.95);
  const double hip = 0.5 * height;
  const double shoulder = 0.82 * height;
  const double stride = random.uniform(-0.16, 0.16);
  const Stuff trousers = anyOf(random, {Stuff::DarkCloth, Stuff::LightCloth});
  const Stuff shirt = anyOf(random, {Stuff::DarkCloth, Stuff::LightCloth});
  for (const double side : {-1.0, 1.0}) {
    const double step = side * stride;
    addPipe(model, {side * 0.1, step, 0}, {side * 0.09, 0, hip}, 0.075, trousers);
    block(model, side * 0.1, step + 0.03, 0, {0.09, 0.24, 0.08}, Stuff::Rubber);
    const double swing = -0.9 * step;
    addPipe(model, {side * 0.2, 0, shoulder}, {side * 0.23, swing, 0.6 * height}, 0.045, shirt);
    addPipe(model, {side * 0.23, swing, 0.6 * height}, {side * 0.21, swing + 0.05, 0.47 * height}, 0.035, Stuff::Skin);
  }
  addBlob(model, {0, 0, (hip + shoulder) / 2}, {0.2, 0.13, (shoulder - hip) / 2 + 0.1}, 10, 0.02, random.next(), shirt);
  addPipe(model, {0, 0, shoulder}, {0, 0, height - 0.2}, 0.055, Stuff::Skin);
  model.spheres.push_back({{0, 0.01, height - 0.12}, 0.115, paint(model, Stuff::Skin)});
  return model;
}

} // namespace pcl_ssfr::simulation::parts
