// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>

#include "common/angles.h"
#include <apps/simulation/scene_outdoors.h>

#include <cmath>

/// Buildings about lawns, with trees and paths.
namespace pcl_ssfr::simulation {

using Eigen::Vector2d;
using Eigen::Vector3d;

Scene
makeCampus(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const std::uint64_t noise = r.next();
  const outdoors::Ground ground = [noise](double x, double y) {
    return 0.5 * parts::smoothNoise({x / 35, y / 35, 0.5}, noise);
  };
  // A walk round the lawn in the middle.
  constexpr double kWest = 30;
  constexpr double kEast = 110;
  constexpr double kSouth = 28;
  constexpr double kNorth = 78;
  WalkPlan walk;
  const auto along = [&](const Vector2d& from, const Vector2d& to) {
    const double length = (to - from).norm();
    for (double s = 0; s < length; s += 2) {
      const Vector2d at = from + (to - from) * (s / length);
      walk.to({at.x(), at.y(), ground(at.x(), at.y())});
    }
  };
  along({kWest, kSouth}, {kEast, kSouth});
  along({kEast, kSouth}, {kEast, kNorth});
  along({kEast, kNorth}, {kWest, kNorth});
  along({kWest, kNorth}, {kWest, kSouth + 4});
  b.setPath(walk);
  outdoors::addStrip(b.model(), {-10, -10, 150, 115}, 120, parts::Stuff::Foliage, ground);

  // Buildings about the walk, some not at right angles to the others.
  struct Plot {
    Vector2d at; ///< of the corner
    double yaw;
  };
  const Plot plots[] = {{{2, 2}, 0},
                        {{38, 0}, 0.1},
                        {{88, -2}, -0.12},
                        {{134, 30}, kPi / 2},
                        {{136, 64}, kPi / 2 + 0.3},
                        {{112, 104}, kPi},
                        {{70, 106}, kPi + 0.15},
                        {{9, 100}, -kPi / 2 - 0.05},
                        {{8, 62}, -kPi / 2},
                        {{58, 44}, 0.25}};
  for (const Plot& plot : plots) {
    const SurfaceModel block = outdoors::makeBlock(b, b.vary(17, 26), b.vary(11, 15), 2 + r.index(3));
    const Vector2d at = plot.at + Vector2d(b.vary(-1, 1), b.vary(-1, 1));
    b.place(block, {at.x(), at.y(), ground(at.x(), at.y()) - 0.1}, plot.yaw);
  }
  const auto scatter = [&](int count, double reach, const auto& make) {
    for (int i = 0; i < count; ++i)
      outdoors::stand(b, make(), {b.vary(0, 140), b.vary(-2, 108)}, b.vary(0, 2 * kPi), ground, reach);
  };
  scatter(18, 0.4, [&] { return parts::makeTree(r); });
  scatter(30, 0.4, [&] { return outdoors::makeForestTree(b); });
  scatter(10, 0.3, [&] { return parts::makeLampPost(r); });
  scatter(14, 0.8, [&] { return parts::makeBench(r); });
  scatter(8, 0.4, [&] { return parts::makeBin(r); });
  // Cars on a row of the east.
  for (int i = 0; i < 6; ++i) {
    const double x = 118;
    const double y = 36 + 3.1 * i;
    if (b.chance(0.7))
      b.placeLoose(parts::makeCar(r), {x, y, ground(x, y)}, kPi / 2, {x - 3.5, y - 1.4, x + 3.5, y + 1.4}, true);
  }
  for (int i = 0; i < 8; ++i) {
    const double x = 34 + 9 * i;
    const double y = i % 2 == 0 ? kSouth + 4 : kNorth - 4;
    b.addWalkAreas({x, y - 1, x + 4, y + 1}, ground(x + 2, y), 1, 0.7, 2);
  }
  return b.finish("campus of ten buildings about a lawn with trees, 160 m by 125 m", 8, "velodyne_hdl32e");
}

} // namespace pcl_ssfr::simulation
