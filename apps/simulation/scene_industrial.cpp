// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>

#include "common/angles.h"
#include <apps/simulation/scene_outdoors.h>

#include <cmath>

/// Sheds, tanks, pipe racks and stacks of containers.
namespace pcl_ssfr::simulation {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

/// A shed with gates in its long sides and a low gable, from x = 0, y = 0.
SurfaceModel
makeShed(SceneBuilder& b, double length, double depth)
{
  SurfaceModel model;
  const double height = b.vary(6, 8);
  const double rise = b.vary(0.8, 1.6);
  constexpr double kWall = 0.25;
  for (const double y : {kWall / 2, depth - kWall / 2}) {
    std::vector<Opening> openings;
    for (double x = 5; x + 5 < length; x += b.vary(8, 12))
      openings.push_back({x, b.vary(3, 4.5), 0.5, 0.5 + b.vary(3.5, 4.5), Filling::Shut, 1, false});
    parts::addWall(model, {{0, y}, {length, y}, kWall, openings, Stuff::Metal}, -0.5, height + 0.5);
    // Posts before the wall.
    for (double x = 0.3; x < length; x += 5)
      model.addBlock({x, y < depth / 2 ? -0.12 : depth + 0.12, -0.5},
                     {0.25, 0.25, height + 0.5},
                     0,
                     parts::paint(model, Stuff::Metal));
  }
  const std::uint16_t metal = parts::paint(model, Stuff::Metal);
  for (const double x : {kWall / 2, length - kWall / 2}) {
    model.addBlock({x, depth / 2, -0.5}, {kWall, depth, height + 0.5}, 0, metal);
    model.addPolygon({{x, 0, height}, {x, depth, height}, {x, depth / 2, height + rise}}, metal);
  }
  for (const double y : {-0.3, depth + 0.3})
    model.addPolygon({{-0.3, y, height - 0.1},
                      {length + 0.3, y, height - 0.1},
                      {length + 0.3, depth / 2, height + rise},
                      {-0.3, depth / 2, height + rise}},
                     metal);
  for (double x = b.vary(4, 8); x < length; x += b.vary(8, 14))
    model.addColumn({x, depth * b.vary(0.3, 0.7), height}, b.vary(0.3, 0.6), b.vary(1.2, 2.5), metal);
  return model;
}

SurfaceModel
makeContainers(SceneBuilder& b)
{
  SurfaceModel model;
  const int rows = 1 + b.random().index(3);
  for (int i = 0; i < rows; ++i) {
    const int high = 1 + b.random().index(3);
    for (int k = 0; k < high; ++k)
      model.addBlock({2.6 * i, b.vary(-0.15, 0.15), 2.6 * k - 0.1},
                     {2.44, b.chance(0.5) ? 6.06 : 6.0, 2.59},
                     0,
                     parts::paint(model, b.chance(0.5) ? Stuff::DarkPaint : Stuff::LightPaint));
  }
  return model;
}

SurfaceModel
makeTank(SceneBuilder& b)
{
  SurfaceModel model;
  const double radius = b.vary(2, 4.5);
  const double height = b.vary(5, 11);
  model.addColumn({0, 0, -0.3}, radius, height, parts::paint(model, Stuff::LightPaint));
  parts::addPipe(model, {radius + 0.3, 0, 0}, {radius + 0.3, 0, height - 0.3}, 0.12, Stuff::Metal);
  parts::addRailing(
      model, {-radius * 0.7, -radius * 0.7, height - 0.3}, {radius * 0.7, -radius * 0.7, height - 0.3}, 1);
  for (double z = 0.4; z < height; z += 0.4)
    parts::addPipe(model, {-0.25, -radius - 0.15, z}, {0.25, -radius - 0.15, z}, 0.02, Stuff::Metal);
  return model;
}

} // namespace

Scene
makeIndustrialSite(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const std::uint64_t noise = r.next();
  const outdoors::Ground ground = [noise](double x, double y) {
    return 0.12 * parts::smoothNoise({x / 25, y / 25, 0.4}, noise);
  };
  // Along the road between the sheds, round the tanks, back behind.
  WalkPlan walk;
  const std::vector<Vector2d> corners{{8, 40}, {70, 40}, {70, 62}, {118, 62}, {118, 34}, {78, 34}};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double length = (corners[i + 1] - corners[i]).norm();
    for (double s = 0; s < length; s += 2) {
      const Vector2d at = corners[i] + (corners[i + 1] - corners[i]) * (s / length);
      walk.to({at.x(), at.y(), ground(at.x(), at.y())});
    }
  }
  b.setPath(walk);
  outdoors::addStrip(m, {-10, -5, 145, 105}, 110, Stuff::Concrete, ground);
  const auto put = [&](const SurfaceModel& part, double x, double y, double yaw) {
    b.place(part, {x, y, ground(x, y)}, yaw);
  };
  put(makeShed(b, b.vary(38, 44), b.vary(18, 22)), 8, b.vary(10, 12), 0);
  put(makeShed(b, b.vary(26, 32), b.vary(20, 24)), 12, b.vary(48, 50), 0.03);
  put(makeShed(b, b.vary(28, 34), 14), b.vary(78, 84), 72, -0.05);
  put(makeShed(b, 22, 12), b.vary(86, 90), 5, 0.2);
  put(outdoors::makeBlock(b, 14, 10, 2), 54, 18, 0);
  for (const Vector2d& at : {Vector2d(86, 49), {97, 48}, {108, 49}, {84, 24}, {95, 23}, {55, 74}})
    put(makeTank(b), at.x() + b.vary(-1, 1), at.y() + b.vary(-1, 1), b.vary(0, 2 * kPi));
  for (const Vector2d& at : {Vector2d(52, 52), {60, 58}, {54, 86}, {126, 45}, {130, 70}, {100, 90}, {126, 20}})
    put(makeContainers(b), at.x(), at.y(), b.vary(-0.1, 0.1) + (b.chance(0.5) ? 0 : kPi / 2));
  // A rack of pipes over the road: posts, beams, and pipes that go on.
  const double rack = 44.5;
  for (double x = 12; x < 82; x += 7) {
    for (const double y : {rack - 1.2, rack + 1.2}) {
      m.addBlock({x, y, -0.3}, {0.2, 0.2, 5.6}, 0, parts::paint(m, Stuff::Metal));
      b.block(Rect{x, y, x, y}.grown(0.15), -0.3, 6);
    }
    m.addBlock({x, rack, 5.1}, {0.2, 2.8, 0.2}, 0, parts::paint(m, Stuff::Metal));
  }
  for (int i = 0; i < 5; ++i) {
    const double y = rack - 1 + 0.5 * i;
    parts::addPipe(m, {12, y, 5.5}, {b.vary(60, 82), y, 5.5}, b.vary(0.06, 0.2), Stuff::Metal);
  }
  // A chimney, a fence of posts, lamps, boxes and lorries' trailers.
  m.addColumn({68, 88, -0.3}, 1.1, 20, parts::paint(m, Stuff::Brick));
  b.block({66.9, 86.9, 69.1, 89.1}, -0.3, 20);
  for (double x = -4; x < 140; x += 4)
    for (const double y : {-1.0, 101.0})
      parts::addPipe(m, {x, y, -0.3}, {x, y, 2.2}, 0.04, Stuff::Metal);
  for (int i = 0; i < 10; ++i)
    outdoors::stand(b, parts::makeLampPost(r), {b.vary(0, 135), b.vary(0, 100)}, b.vary(0, 2 * kPi), ground, 0.3);
  for (int i = 0; i < 24; ++i)
    outdoors::stand(b, parts::makeBox(r), {b.vary(5, 130), b.vary(30, 70)}, b.vary(0, 2 * kPi), ground, 0.5);
  for (int i = 0; i < 8; ++i) {
    const double x = b.vary(10, 115);
    const double y = b.vary(25, 68);
    b.placeLoose(
        parts::makeCar(r), {x, y, ground(x, y)}, b.chance(0.5) ? 0 : kPi / 2, {x - 5, y - 5, x + 5, y + 5}, true);
  }
  for (int i = 0; i < 8; ++i)
    b.addWalkAreas({10.0 + 7 * i, 36, 15.0 + 7 * i, 39}, ground(12.5 + 7 * i, 37.5), 1, 0.8, 2);
  return b.finish("industrial site with sheds, tanks, pipe racks and containers, 155 m by 110 m", 7, "velodyne_hdl32e");
}

} // namespace pcl_ssfr::simulation
