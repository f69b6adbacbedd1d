// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>

/// A car park of several levels.
namespace pcl_ssfr::simulation {

using Eigen::Vector3d;
using parts::Filling;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kLength = 48; // [m]
constexpr double kDepth = 32;  // [m]
constexpr double kLevel = 3.0; // from floor to floor, on the grid of snap() [m]
constexpr double kSlab = 0.3;  // [m]
constexpr double kFoot = 14;   // ramps rise from here [m]
constexpr double kHead = 34;   // to here [m]
constexpr Rect kRamp{kFoot, 14, kHead, 18};
constexpr double kSouthAisle = 8;
constexpr double kNorthAisle = 24;
constexpr double kEast = 43.5; // of the eastern way, clear of columns
constexpr std::uint64_t kCarStream = 0x63617273ULL;

/// A level; \p cars decides who parks there. The lowest has no ramp from below, the highest none up.
Scene
makeLevel(std::uint64_t seed, std::uint64_t cars, bool lowest, bool highest)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const double h = kLevel - kSlab;
  b.setPath({{kHead + 3, 16, 0},
             {kEast, 18, 0},
             {kEast, kNorthAisle, 0},
             {6, kNorthAisle, 0},
             {6, 20, 0},
             {kFoot - 3, 16, 0},
             {kFoot, 16, 0},
             {kFoot - 3, 16, 0},
             {6, 20, 0},
             {6, kSouthAisle, 0},
             {kEast, kSouthAisle, 0},
             {kEast, 18, 0}});
  const std::vector<Rect> holes = lowest ? std::vector<Rect>{} : std::vector<Rect>{kRamp};
  parts::addSlab(m, {-0.3, -0.3, kLength + 0.3, kDepth + 0.3}, 0, kSlab, holes, Stuff::Concrete);
  // Parapets all round, columns, beams, the stair core in a corner.
  for (const double y : {-0.15, kDepth + 0.15})
    m.addBlock({kLength / 2, y, 0}, {kLength, 0.2, 1.1}, 0, parts::paint(m, Stuff::Concrete));
  for (const double x : {-0.15, kLength + 0.15})
    m.addBlock({x, kDepth / 2, 0}, {0.2, kDepth, 1.1}, 0, parts::paint(m, Stuff::Concrete));
  for (double x = 0.4; x < kLength; x += 7.9)
    for (const double y : {5.2, 10.8, 21.2, 26.8}) {
      m.addBlock({x, y, 0}, {0.4, 0.4, h}, 0, parts::paint(m, Stuff::Concrete));
      b.block(Rect{x, y, x, y}.grown(0.25), 0, h);
    }
  if (!highest)
    for (double x = 0.4; x < kLength; x += 7.9)
      for (const double y : {8.0, 24.0})
        m.addBlock({x, y, h - 0.25}, {0.35, kDepth / 2 - 2, 0.25}, 0, parts::paint(m, Stuff::Concrete));
  const Rect core{44, 28, 48, 32};
  b.addWall(
      {{core.x0, core.y0}, {core.x0, core.y1}, 0.2, {{1.6, 1.0, 0, 2.1, Filling::Shut, 1, false}}, Stuff::Concrete},
      0,
      h);
  b.addWall({{core.x0, core.y0}, {core.x1, core.y0}, 0.2, {}, Stuff::Concrete}, 0, h);
  b.block(core, 0, h);
  // Railings along the opening, and the ramp up.
  for (const double y : {kRamp.y0, kRamp.y1})
    parts::addRailing(m, {kRamp.x0, y, 0}, {kRamp.x1, y, 0}, 1.0);
  if (!lowest || !highest)
    b.block(kRamp.grown(0.1), 0, h);
  if (!highest) {
    const double d = 0.25;
    parts::addHexahedron(
        m,
        {{kRamp.x0, kRamp.y0, -d},
         {kRamp.x1, kRamp.y0, kLevel - d},
         {kRamp.x1, kRamp.y1, kLevel - d},
         {kRamp.x0, kRamp.y1, -d}},
        {{kRamp.x0, kRamp.y0, 0}, {kRamp.x1, kRamp.y0, kLevel}, {kRamp.x1, kRamp.y1, kLevel}, {kRamp.x0, kRamp.y1, 0}},
        Stuff::Concrete);
  }
  // Four rows of places; most are taken.
  r = RandomStream(seed, cars, kCarStream);
  for (const double y : {2.45, 12.0, 20.0, 29.5})
    for (double x = 2.0; x + 2 < kLength; x += 2.6) {
      if ((y > 11 && y < 21 && x > kRamp.x0 - 1.6 && x < kRamp.x1 + 1.6) || !b.chance(0.7))
        continue;
      b.placeLoose(parts::makeCar(r),
                   {x, y + b.vary(-0.08, 0.08), 0},
                   (b.chance(0.5) ? 0 : kPi) + b.vary(-0.03, 0.03),
                   {x - 1.25, y - 2.6, x + 1.25, y + 2.6},
                   true);
    }
  if (b.chance(0.6))
    b.placeInside(parts::makeBin(r), {36, 1, 46, 5}, 0);
  b.addWalkAreas({2, 5.6, 46, 6.9}, 0, 2, 0.7, 1.2);
  b.addWalkAreas({2, 25.1, 44, 26.4}, 0, 2, 0.7, 1.2);
  Scene scene = b.finish("", 1, "");
  snap(scene);
  return scene;
}

} // namespace

Scene
makeCarParkLevels(std::uint64_t seed, const SceneOptions& options)
{
  constexpr int kUsual = 3;
  const int levels = options.storeys > 0 ? options.storeys : kUsual;
  Scene scene;
  WalkPlan walk;
  for (int k = 0; k < levels; ++k) {
    const double z = kLevel * k;
    const bool highest = k + 1 == levels;
    appendScene(
        scene, makeLevel(seed, options.alike ? 0 : static_cast<std::uint64_t>(k) + 1, k == 0, highest), {0, 0, z});
    // From the head of the ramp round the level to its foot.
    walk.stop({kHead + 3, 16, z});
    walk.to({kEast, 18, z});
    walk.to({kEast, kNorthAisle, z});
    walk.stop({34, kNorthAisle, z});
    walk.stop({14, kNorthAisle, z});
    walk.to({6, kNorthAisle, z});
    walk.to({6, 20, z});
    if (highest) {
      walk.to({6, kSouthAisle, z});
      walk.stop({22, kSouthAisle, z});
      break;
    }
    walk.stop({kFoot - 3, 16, z});
    walk.to({kFoot, 16, z});
    walk.stop({(kFoot + kHead) / 2, 16, z + kLevel / 2});
    walk.to({kHead, 16, z + kLevel});
  }
  scene.path = walk.points();
  scene.stations = walk.stations();
  scene.description = "car park of three levels alike, joined by ramps, 48 m by 32 m";
  scene.natural_step = 5;
  scene.recommended_sensor = "velodyne_hdl32e";
  validate(scene.surfaces);
  return scene;
}

} // namespace pcl_ssfr::simulation
