// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>
#include <apps/simulation/scene_outdoors.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector3d;
using outdoors::addStrip;
using outdoors::makeHouse;
using parts::Rect;
using parts::Stuff;

constexpr double kLength = 120; // of the street [m]
constexpr double kKerb = 3.7;   // from the middle [m]
constexpr double kKerbRise = 0.13;
constexpr double kFacade = 6.6; // from the middle [m]

/// Height of the road and the pavements: gentle waves along the street, a camber across it, worn asphalt.
class Ground {
public:
  explicit Ground(std::uint64_t seed) : seed_(seed) {}

  double
  road(double x, double y) const
  {
    const double waves = 0.22 * parts::smoothNoise({x / 30, 0.5, 0.5}, seed_);
    const double wear = 0.012 * parts::smoothNoise({x / 1.7, y / 1.7, 0.3}, seed_ + 1);
    return waves + wear - 0.02 * std::abs(y);
  }
  double
  pavement(double x, double y) const
  {
    return road(x, std::copysign(kKerb, y)) + kKerbRise + 0.015 * (std::abs(y) - kKerb);
  }

private:
  std::uint64_t seed_;
};

void
addGround(SurfaceModel& model, const Ground& ground)
{
  constexpr double kBeyond = 25; // the ground goes on beyond both ends [m]
  const double west = -kBeyond;
  const double east = kLength + kBeyond;
  addStrip(
      model, {west, -kKerb, east, kKerb}, 8, Stuff::Asphalt, [&](double x, double y) { return ground.road(x, y); });
  for (const double side : {-1.0, 1.0}) {
    const auto pavement = [&](double x, double y) { return ground.pavement(x, y); };
    const double near = side * kKerb;
    const double far = side * (kFacade + 30);
    addStrip(model,
             {west, std::min(near, side * kFacade), east, std::max(near, side * kFacade)},
             2,
             Stuff::Concrete,
             pavement);
    // Yards and the ground of the side street.
    addStrip(model,
             {west, std::min(side * kFacade, far), east, std::max(side * kFacade, far)},
             3,
             Stuff::Concrete,
             [&](double x, double) { return ground.pavement(x, side * kFacade); });
    // The kerb stone.
    const std::uint16_t stone = parts::paint(model, Stuff::Stone);
    for (double x = west; x < east; x += 1)
      model.addPolygon({{x, near, ground.road(x, near)},
                        {x + 1, near, ground.road(x + 1, near)},
                        {x + 1, near, ground.pavement(x + 1, near)},
                        {x, near, ground.pavement(x, near)}},
                       stone);
  }
}

} // namespace

Scene
makeStreet(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const Ground ground(r.next());
  // Along the street, not quite in its middle.
  const double sway = b.vary(0.4, 0.8);
  const double phase = b.vary(0, 6);
  std::vector<Vector3d> path;
  for (double x = 10; x <= 110; x += 1) {
    const double y = sway * std::sin(x / 17 + phase);
    path.emplace_back(x, y, ground.road(x, y));
  }
  b.setPath(path);
  addGround(m, ground);

  // Buildings on both sides; a side street opens between two of them, other streets close the view at the ends.
  for (const double side : {-1.0, 1.0}) {
    const double gap = b.vary(45, 70);
    bool opened = false;
    double x = -12 + b.vary(0, 3);
    while (x < kLength + 8) {
      if (!opened && x > gap) {
        opened = true;
        const double lane = b.vary(7, 9);
        const SurfaceModel far = makeHouse(b, lane + 8);
        const double z = ground.pavement(x, side * kFacade);
        if (side > 0)
          m.append(far, parts::standAt({x - 4, kFacade + 19, z}));
        else
          m.append(far, parts::standAt({x + lane + 4, -kFacade - 19, z}, kPi));
        x += lane;
        continue;
      }
      const double width = b.vary(7.5, 14);
      const double setback = b.chance(0.25) ? b.vary(0.2, 0.8) : 0;
      const double y = kFacade + setback;
      const double z = ground.pavement(x + width / 2, side * kFacade);
      if (side > 0)
        m.append(makeHouse(b, width), parts::standAt({x, y, z}));
      else
        m.append(makeHouse(b, width), parts::standAt({x + width, -y, z}, kPi));
      x += width;
      if (b.chance(0.2))
        x += b.vary(0.8, 3); // a narrow passage between neighbours
    }
  }
  const double z_west = ground.road(-16, 0);
  const double z_east = ground.road(kLength + 16, 0);
  m.append(makeHouse(b, 22), parts::standAt({-18, -11, z_west}, kPi / 2));
  m.append(makeHouse(b, 22), parts::standAt({kLength + 18, 11, z_east}, -kPi / 2));

  // Cars at the kerb, bow either way; each may stand elsewhere in its strip.
  constexpr double kStrip = 13;
  for (const double side : {-1.0, 1.0})
    for (double x = 3; x + kStrip < kLength; x += kStrip + 0.5) {
      const Rect strip{x, side > 0 ? 1.45 : -kKerb, x + kStrip, side > 0 ? kKerb : -1.45};
      const int cars = std::min(2, r.index(4));
      for (int i = 0; i < cars; ++i) {
        const double at = x + kStrip * (i + 0.5) / cars + b.vary(-0.6, 0.6);
        const double y = side * (kKerb - b.vary(1.08, 1.14));
        b.placeLoose(parts::makeCar(r),
                     {at, y, ground.road(x + kStrip / 2, y)},
                     (b.chance(0.5) ? 1 : -1) * kPi / 2 + b.vary(-0.02, 0.02),
                     strip,
                     true);
      }
    }
  // Trees, lamps and signs near the kerb, bins and benches at the facades.
  const double line = kKerb + 0.5;
  for (const double side : {-1.0, 1.0}) {
    const double facing = side > 0 ? kPi : 0; // towards the road
    const auto stand = [&](const SurfaceModel& part, double x, double y, double yaw, double reach = 0.2) {
      // Only the foot takes ground: crowns and arms reach over road and path.
      const Rect foot = Rect{x, side * y, x, side * y}.grown(reach);
      if (!b.isFree(foot, -1, 4))
        return;
      b.block(foot, -1, 4);
      m.append(part, parts::standAt({x, side * y, ground.pavement(x, side * y)}, yaw));
    };
    for (double x = b.vary(2, 8); x < kLength; x += b.vary(12, 18))
      stand(parts::makeTree(r), x, line + 0.2, b.vary(0, 2 * kPi));
    for (double x = b.vary(5, 15); x < kLength; x += b.vary(24, 30))
      stand(parts::makeLampPost(r), x, line, facing);
    for (double x = b.vary(4, 12); x < kLength; x += b.vary(14, 30))
      stand(parts::makeSign(r), x, line - 0.1, b.chance(0.5) ? kPi / 2 : -kPi / 2);
    for (int i = 0; i < 9; ++i)
      stand(parts::makeBin(r), b.vary(0, kLength), kFacade - 0.75, facing + b.vary(-0.1, 0.1), 0.4);
    // A cable over the street from facade to facade now and then.
    if (side > 0)
      for (double x = b.vary(10, 20); x < kLength; x += b.vary(22, 35))
        parts::addPipe(m, {x, -kFacade, 6.3}, {x + b.vary(-1, 1), kFacade, 6.3}, 0.012, Stuff::BlackPlastic);
    for (double x = 2; x < kLength - 12; x += 10) {
      const Rect strip{x, side > 0 ? kKerb + 0.95 : -kFacade + 0.5, x + 9, side > 0 ? kFacade - 0.5 : -kKerb - 0.95};
      const double z = ground.pavement(strip.centre().x(), strip.centre().y());
      b.addWalkAreas(strip, z, 1, 0.7, 9);
    }
  }
  return b.finish("street of facades with roofs, balconies, parked cars and trees, 120 m", 3, "velodyne_hdl32e");
}

} // namespace pcl_ssfr::simulation
