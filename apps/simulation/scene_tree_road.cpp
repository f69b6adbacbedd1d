// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>

#include "common/angles.h"
#include <apps/simulation/scene_outdoors.h>

#include <cmath>

/// A road with trees, parked and moving cars, and hardly any building.
namespace pcl_ssfr::simulation {

using Eigen::Vector3d;
using parts::Rect;
using parts::Stuff;

Scene
makeTreeRoad(std::uint64_t seed)
{
  constexpr double kLength = 180;           // [m]
  constexpr double kLane = 3.4;             // [m]
  constexpr double kEdge = 2 * kLane + 2.6; // of the asphalt, lay-bys included [m]
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const std::uint64_t noise = r.next();
  const outdoors::Ground road = [noise](double x, double y) {
    return 0.4 * parts::smoothNoise({x / 45, 0.5, 0.5}, noise) - 0.02 * std::abs(y);
  };
  // Verges fall off into a ditch and rise to the fields.
  const outdoors::Ground verge = [=](double x, double y) {
    const double off = std::abs(y) - kEdge;
    const double ditch = -0.7 * std::exp(-std::pow((off - 4) / 1.3, 2));
    const double field = 0.35 * parts::smoothNoise({x / 14, y / 14, 0.2}, noise + 1) * std::min(1.0, off / 4);
    return road(x, std::copysign(kEdge, y)) + ditch + field;
  };
  const double lane = -kLane / 2;
  std::vector<Vector3d> path;
  for (double x = 12; x <= kLength - 12; x += 1)
    path.emplace_back(x, lane, road(x, lane));
  b.setPath(path);
  SurfaceModel& m = b.model();
  outdoors::addStrip(m, {-20, -kEdge, kLength + 20, kEdge}, 8, Stuff::Asphalt, road);
  outdoors::addStrip(m, {-20, kEdge, kLength + 20, kEdge + 28}, 22, Stuff::Foliage, verge);
  outdoors::addStrip(m, {-20, -kEdge - 28, kLength + 20, -kEdge}, 22, Stuff::Foliage, verge);

  // Parked cars in the lay-bys, moving ones in the other lanes.
  for (const double side : {-1.0, 1.0})
    for (double x = 8; x + 14 < kLength; x += 15)
      if (b.chance(0.45)) {
        const double y = side * (kEdge - 1.2);
        b.placeLoose(parts::makeCar(r),
                     {x + b.vary(3, 11), y, road(x + 7, y)},
                     kPi / 2 + (b.chance(0.5) ? 0 : kPi) + b.vary(-0.02, 0.02),
                     Rect{x, y - 1.2, x + 14, y + 1.2},
                     true);
      }
  for (const double y : {-1.5 * kLane, 0.5 * kLane, 1.5 * kLane})
    for (double x = 5; x + 40 < kLength; x += 42)
      if (b.chance(0.75))
        b.placeTraffic(parts::makeCar(r),
                       {x + b.vary(5, 35), y, road(x + 20, y)},
                       y > 0 ? kPi / 2 : -kPi / 2,
                       {x, y - 1.4, x + 40, y + 1.4});
  // Two rows of trees, as an avenue has them, with gaps; bushes, posts and signs; a few houses far off.
  for (const double side : {-1.0, 1.0}) {
    const double pitch = b.vary(9, 12);
    for (double x = b.vary(-8, 2); x < kLength + 8; x += pitch + b.vary(-1.2, 1.2))
      if (b.chance(0.85))
        outdoors::stand(b,
                        b.chance(0.4) ? parts::makeTree(r) : outdoors::makeForestTree(b),
                        {x, side * (kEdge + 1.5 + b.vary(-0.3, 0.3))},
                        b.vary(0, 2 * kPi),
                        verge,
                        0.3);
    for (int i = 0; i < 14; ++i)
      outdoors::stand(b,
                      outdoors::makeForestTree(b),
                      {b.vary(-15, kLength + 15), side * b.vary(kEdge + 8, kEdge + 26)},
                      b.vary(0, 2 * kPi),
                      verge,
                      0.3);
    for (double x = b.vary(0, 20); x < kLength; x += 50)
      outdoors::stand(b, parts::makeSign(r), {x, side * (kEdge + 0.6)}, b.chance(0.5) ? kPi / 2 : -kPi / 2, verge, 0.3);
    for (double x = b.vary(0, 30); x < kLength; x += 38)
      outdoors::stand(b, parts::makeLampPost(r), {x, side * (kEdge + 0.9)}, side > 0 ? kPi : 0, verge, 0.3);
    const double x = b.vary(30, kLength - 45);
    const double y = side * (kEdge + 13);
    if (side > 0)
      m.append(outdoors::makeHouse(b, 11), parts::standAt({x, y, verge(x, y)}));
    else
      m.append(outdoors::makeHouse(b, 11), parts::standAt({x + 11, y, verge(x, y)}, kPi));
    for (double at = 4; at + 8 < kLength; at += 24)
      b.addWalkAreas({at, side * (kEdge + 0.75) - 0.6, at + 8, side * (kEdge + 0.75) + 0.6},
                     verge(at + 4, side * (kEdge + 0.75)),
                     1,
                     0.7,
                     2);
  }
  return b.finish("road of four lanes with trees, parked cars and moving ones, 180 m", 5, "velodyne_hdl32e");
}

} // namespace pcl_ssfr::simulation
