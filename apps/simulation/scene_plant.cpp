// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>

/// A plant hall of equal bays.
namespace pcl_ssfr::simulation {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kBay = 6; // on the grid of snap() [m]
constexpr int kBays = 8;
constexpr double kHalf = 11;    // half the hall's width [m]
constexpr double kHeight = 7.5; // to the roof [m]
constexpr double kWall = 0.25;  // [m]
constexpr double kGap = 5.4;    // a way between the machines, from the bay's western end [m]
constexpr std::uint64_t kShiftStream = 0x62617973ULL;

/// A machine of a row, its front to -y; what is drawn decides how it looks.
SurfaceModel
makeMachine(RandomStream& r)
{
  SurfaceModel model;
  const double length = r.uniform(2.6, 3.2);
  const double depth = r.uniform(1.5, 2.0);
  const std::uint16_t metal = parts::paint(model, Stuff::Metal);
  const std::uint16_t dark = parts::paint(model, Stuff::DarkPaint);
  model.addBlock({0, 0, 0}, {length, depth, r.uniform(0.7, 1.0)}, 0, dark);
  const double tower = r.uniform(0.7, 1.1);
  const double at = r.uniform(-0.3, 0.3) * length;
  model.addBlock({at, 0.15 * depth, 0.6}, {tower, 0.7 * depth, r.uniform(1.5, 2.2)}, 0, metal);
  model.addBlock(
      {at - 0.9 * tower, -0.1 * depth, 0.7}, {0.5 * tower, 0.4, 0.7}, 0, parts::paint(model, Stuff::LightPaint));
  const double pipe = r.uniform(0.08, 0.16);
  parts::addPipe(model, {length / 2 - 0.3, 0.3 * depth, 0.5}, {length / 2 - 0.3, 0.3 * depth, 4.2}, pipe, Stuff::Metal);
  parts::addPipe(
      model, {length / 2 - 0.3, 0.3 * depth, 4.2}, {length / 2 - 0.3, depth / 2 + 1.2, 4.2}, pipe, Stuff::Metal);
  model.addBlock({-length / 2 + 0.3, -depth / 2 + 0.2, 0.9}, {0.4, 0.25, 0.6}, 0.3, metal);
  return model;
}

/// A bay from x = 0 to kBay. \param[in] shift decides what the shift left standing about
Scene
makeBay(std::uint64_t seed, std::uint64_t shift)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  b.setPath({{0, 0, 0}, {kGap, 0, 0}, {kGap, 6, 0}, {kGap, -6, 0}, {kGap, 0, 0}, {kBay, 0, 0}});
  parts::addSlab(m, {0, -kHalf - kWall, kBay, kHalf + kWall}, 0, 0.3, {}, Stuff::Concrete);
  parts::addSlab(m, {0, -kHalf - kWall, kBay, kHalf + kWall}, kHeight + 0.2, 0.2, {}, Stuff::Metal);
  for (const double side : {-1.0, 1.0}) {
    const double y = side * (kHalf + kWall / 2);
    b.addWall(
        {{0, y}, {kBay, y}, kWall, {{kBay / 2, 4.5, 4.5, 6, Filling::Window, 1, false}}, Stuff::Metal}, 0, kHeight);
    // A column on the western line, with its bracket, the crane's rail, and half of the truss.
    m.addBlock({0.2, side * (kHalf - 0.25), 0}, {0.4, 0.5, kHeight}, 0, parts::paint(m, Stuff::Concrete));
    m.addBlock({0.2, side * (kHalf - 0.75), 5.2}, {0.4, 0.5, 0.4}, 0, parts::paint(m, Stuff::Concrete));
    m.addBlock({kBay / 2, side * (kHalf - 0.8), 5.6}, {kBay, 0.3, 0.5}, 0, parts::paint(m, Stuff::Metal));
    parts::addPipe(m, {0.2, side * kHalf, 6.7}, {0.2, 0, 7.3}, 0.06, Stuff::Metal);
    for (int i = 0; i < 4; ++i) {
      const double from = side * (kHalf - 0.2 - 2.7 * i);
      const double to = side * (kHalf - 1.5 - 2.7 * i);
      parts::addPipe(m, {0.2, from, kHeight}, {0.2, to, 6.7 + 0.6 * (1 - std::abs(to) / kHalf)}, 0.04, Stuff::Metal);
    }
    b.block(Rect{0.2, side * (kHalf - 0.25), 0.2, side * (kHalf - 0.25)}.grown(0.3), 0, kHeight);
    // The same two machines in every bay: they come from the numbers of the hall.
    b.place(makeMachine(r), {2.7, side * 4.2, 0}, side > 0 ? 0 : kPi);
    b.place(makeMachine(r), {2.9, side * 8.2, 0}, side > 0 ? 0 : kPi);
  }
  m.append(parts::makePanelLamp(1.5), parts::standAt({kBay / 2, 0, kHeight - 0.6}));
  r = RandomStream(seed, shift, kShiftStream);
  const Rect all{0.5, -kHalf + 0.1, kBay, kHalf - 0.1};
  const int things = 2 + r.index(3);
  for (int i = 0; i < things; ++i)
    b.placeInside(parts::makeBox(r), all, 0);
  if (b.chance(0.5))
    b.placeAtAnyWall(parts::makeCupboard(r, b.vary(0.8, 1.4), 0.5, b.vary(1, 2)), all, 0);
  if (b.chance(0.5))
    b.placeAtAnyWall(parts::makeShelf(r, b.vary(1, 1.8), b.vary(1.5, 2.2)), all, 0);
  b.addWalkAreas(all, 0, 2, 0.8, 1.8);
  b.placeLooseInside(parts::makeBox(r), all, 0);
  Scene scene = b.finish("", 1, "");
  snap(scene);
  return scene;
}

} // namespace

Scene
makePlantHall(std::uint64_t seed, const SceneOptions& options)
{
  SceneBuilder b(seed + 1);
  RandomStream& r = b.random();
  const double length = kBay * kBays;
  WalkPlan walk;
  walk.stop({1, 0, 0});
  for (int i = 0; i < kBays; ++i) {
    const double x = kBay * i + kGap;
    walk.stop({x, 0, 0});
    // Between the machines, north and south in turn.
    if (i % 2 == 0) {
      walk.stop({x, i % 4 == 0 ? 6.0 : -6.0, 0});
      walk.to({x, 0, 0});
    }
  }
  b.setPath(walk);
  const double o = kWall / 2;
  b.addWall(
      {{-o, -kHalf}, {-o, kHalf}, kWall, {{kHalf, 3.6, 0, 4, Filling::Shut, 1, false}}, Stuff::Metal}, 0, kHeight);
  b.addWall({{length + o, -kHalf},
             {length + o, kHalf},
             kWall,
             {{4, 1.0, 0, 2.1, Filling::Shut, 1, false}, {14, 3, 3.5, 5.5, Filling::Window, 1, false}},
             Stuff::Brick},
            0,
            kHeight);
  // The crane stands over one of the bays.
  const double crane = kBay * r.index(kBays) + b.vary(2, 4);
  b.model().addBlock({crane, 0, 6.0}, {0.5, 2 * kHalf - 1.6, 0.6}, 0, parts::paint(b.model(), Stuff::LightPaint));
  b.model().addBlock({crane, b.vary(-6, 6), 5.5}, {0.9, 1.2, 0.5}, 0, parts::paint(b.model(), Stuff::DarkPaint));
  for (int i = 0; i < kBays; ++i)
    appendScene(b.scene(), makeBay(seed, options.alike ? 0 : static_cast<std::uint64_t>(i) + 1), {kBay * i, 0, 0});
  return b.finish("plant hall of eight equal bays with the same machines, 48 m by 22 m", 3, "velodyne_hdl32e");
}

} // namespace pcl_ssfr::simulation
