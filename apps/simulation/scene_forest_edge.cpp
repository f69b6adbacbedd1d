// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_makers.h>

#include "common/angles.h"
#include <apps/simulation/scene_outdoors.h>

#include <cmath>

/// A track along the edge of a forest: trunks on one side, a field on the other.
namespace pcl_ssfr::simulation {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Stuff;

Scene
makeForestEdge(std::uint64_t seed)
{
  constexpr double kLength = 110; // [m]
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const std::uint64_t noise = r.next();
  const double phase = b.vary(0, 6);
  const auto track = [phase](double x) { return 3 * std::sin(x / 19 + phase); };
  const outdoors::Ground ground = [=](double x, double y) {
    const double off = std::abs(y - track(x));
    const double rough = 0.18 * parts::smoothNoise({x / 2.5, y / 2.5, 0.7}, noise + 1) * std::min(1.0, off / 3);
    return 0.9 * parts::smoothNoise({x / 30, y / 30, 0.5}, noise) + rough + 0.04 * std::max(0.0, y - track(x) - 4);
  };
  std::vector<Vector3d> path;
  for (double x = 8; x <= kLength - 8; x += 0.5)
    path.emplace_back(x, track(x), ground(x, track(x)));
  b.setPath(path);
  outdoors::addStrip(m, {-15, -45, kLength + 15, 45}, 100, Stuff::Foliage, ground);
  const double hut = b.vary(25, kLength - 30);
  const double hut_y = track(hut) - 13;
  b.place(outdoors::makeBlock(b, 6, 5, 1), {hut, hut_y, ground(hut, hut_y) - 0.1}, b.vary(-0.4, 0.4));
  // The wood is in the north, thinner at its edge.
  for (int i = 0; i < 190; ++i) {
    const double x = b.vary(-12, kLength + 12);
    const double off = 2 + 34 * std::pow(r.uniform(), 0.7);
    outdoors::stand(b, outdoors::makeForestTree(b), {x, track(x) + off}, b.vary(0, 2 * kPi), ground, 0.45);
  }
  const auto scatter = [&](int count, double low, double high, double reach, const auto& make) {
    for (int i = 0; i < count; ++i) {
      const double x = b.vary(-8, kLength + 8);
      outdoors::stand(b, make(), {x, track(x) + b.vary(low, high)}, b.vary(0, 2 * kPi), ground, reach);
    }
  };
  // Bushes and stones at the edge, a stack of logs, single trees and bales in the field, posts of a fence.
  scatter(26, 1.6, 8, 0.7, [&] {
    SurfaceModel bush;
    const double wide = b.vary(0.4, 1.0);
    parts::addBlob(
        bush, {0, 0, 0.4 * wide}, {wide, wide * b.vary(0.7, 1), 0.8 * wide}, 8, 0.15, r.next(), Stuff::Foliage);
    return bush;
  });
  scatter(14, -7, 7, 0.6, [&] {
    SurfaceModel stone;
    const double wide = b.vary(0.25, 0.6);
    parts::addBlob(stone, {0, 0, 0.1}, {wide, 0.8 * wide, 0.6 * wide}, 8, 0.08, r.next(), Stuff::Stone);
    return stone;
  });
  scatter(4, 2, 6, 2.0, [&] {
    SurfaceModel logs;
    for (int k = 0; k < 9; ++k) {
      const int layer = k / 3;
      const double y = 0.4 * (k % 3) + 0.2 * layer, z = 0.2 + 0.36 * layer;
      parts::addPipe(logs, {-2, y, z}, {2, y, z}, 0.19, Stuff::DarkWood);
    }
    return logs;
  });
  scatter(7, -35, -8, 0.5, [&] { return parts::makeTree(r); });
  scatter(9, -35, -6, 0.9, [&] {
    SurfaceModel bale;
    parts::addPipe(bale, {-0.6, 0, 0.6}, {0.6, 0, 0.6}, 0.65, Stuff::Foliage);
    for (const double side : {-0.6, 0.6})
      parts::addDisc(bale, {side, 0, 0.6}, Vector3d::UnitX(), 0.65, 20, Stuff::Foliage);
    return bale;
  });
  for (double x = 0; x < kLength; x += 3.5) {
    const double y = track(x) - 3.2 + b.vary(-0.15, 0.15);
    if (b.chance(0.85))
      parts::addPipe(m, {x, y, ground(x, y) - 0.2}, {x, y, ground(x, y) + b.vary(0.9, 1.3)}, 0.06, Stuff::Wood);
  }
  for (double x = 10; x < kLength - 10; x += 12) {
    const double off = track(x + 1) - 1.6;
    b.addWalkAreas({x, off - 0.5, x + 2, off + 0.5}, ground(x + 1, off), 1, 0.7, 1.2);
  }
  return b.finish("track along the edge of a forest, with a field and a hut, 110 m", 4, "livox_mid360");
}

} // namespace pcl_ssfr::simulation
