// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_outdoors.h>

#include "common/angles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ssfr::simulation::outdoors {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

namespace {

constexpr double kWall = 0.4;   // thickness of facades [m]
constexpr double kBuried = 0.6; // walls go so far below their floor [m]

void
addBalcony(SceneBuilder& b, SurfaceModel& model, double x, double width, double z)
{
  const double depth = b.vary(0.9, 1.3);
  model.addBlock({x, -depth / 2, z - 0.15}, {width, depth, 0.15}, 0, parts::paint(model, Stuff::Concrete));
  const double left = x - width / 2 + 0.03;
  const double right = x + width / 2 - 0.03;
  if (b.chance(0.4)) {
    // A solid parapet.
    model.addBlock({x, -depth + 0.05, z}, {width, 0.08, 0.95}, 0, parts::paint(model, Stuff::Concrete));
    return;
  }
  parts::addRailing(model, {left, -depth + 0.04, z}, {right, -depth + 0.04, z}, 1.0);
  parts::addRailing(model, {left, -0.05, z}, {left, -depth + 0.04, z}, 1.0);
  parts::addRailing(model, {right, -0.05, z}, {right, -depth + 0.04, z}, 1.0);
}

/// A gabled roof over the outline; the ridge along the street or across it.
void
addRoof(SceneBuilder& b, SurfaceModel& model, double width, double depth, double z, Stuff walls)
{
  const std::uint16_t tile = parts::paint(model, Stuff::Brick);
  const std::uint16_t gable = parts::paint(model, walls);
  const bool along = b.chance(0.7);
  const double span = along ? depth : width;
  const double rise = span / 2 * b.vary(0.55, 0.9);
  constexpr double kOver = 0.4;
  const double drop = kOver * rise / (span / 2);
  const auto point = [&](double across, double lengthwise, double height) {
    return along ? Vector3d(lengthwise, across, height) : Vector3d(across, lengthwise, height);
  };
  const double length = along ? width : depth;
  // Along the street neighbours touch: no overhang at the gables.
  const double end = along ? 0 : kOver;
  for (const double side : {0.0, span}) {
    const double eaves = side > 0 ? span + kOver : -kOver;
    model.addPolygon({point(eaves, -end, z - drop),
                      point(eaves, length + end, z - drop),
                      point(span / 2, length + end, z + rise),
                      point(span / 2, -end, z + rise)},
                     tile);
  }
  for (const double lengthwise : {0.0, length})
    model.addPolygon({point(0, lengthwise, z), point(span, lengthwise, z), point(span / 2, lengthwise, z + rise)},
                     gable);
  const Vector3d chimney = point(span * b.vary(0.55, 0.7), length * b.vary(0.2, 0.8), z + 0.3 * rise);
  model.addBlock(chimney, {0.6, 0.8, rise * 0.7 + 0.9}, 0, tile);
  if (along) {
    // A gutter and dormers towards the street.
    parts::addPipe(model, {0, -kOver, z - drop}, {width, -kOver, z - drop}, 0.07, Stuff::Metal);
    const int dormers = b.random().index(3);
    for (int i = 0; i < dormers; ++i) {
      const double x = width * (i + 1) / (dormers + 1);
      const double foot = 0.25 * span / 2;
      const double low = z + 0.25 * rise;
      const double high = std::min(low + 1.5, z + 0.85 * rise);
      const double back = (high - z) / rise * span / 2;
      parts::addHexahedron(
          model,
          {{x - 0.7, foot, low}, {x + 0.7, foot, low}, {x + 0.7, foot + 0.05, low}, {x - 0.7, foot + 0.05, low}},
          {{x - 0.7, foot, high}, {x + 0.7, foot, high}, {x + 0.7, back, high}, {x - 0.7, back, high}},
          Stuff::LightPaint);
      model.addPolygon({{x - 0.45, foot - 0.01, low + 0.3},
                        {x + 0.45, foot - 0.01, low + 0.3},
                        {x + 0.45, foot - 0.01, high - 0.2},
                        {x - 0.45, foot - 0.01, high - 0.2}},
                       parts::paint(model, Stuff::Glass));
    }
  }
}

} // namespace

void
addStrip(SurfaceModel& model, const Rect& area, int rows, Stuff stuff, const Ground& height)
{
  const std::uint16_t material = parts::paint(model, stuff);
  const int columns = std::max(1, static_cast<int>(std::lround(area.width())));
  const auto first = static_cast<std::uint32_t>(model.mesh.vertices.size());
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= rows; ++j) {
      const double x = area.x0 + area.width() * i / columns;
      const double y = area.y0 + area.depth() * j / rows;
      model.mesh.vertices.emplace_back(Vector3d(x, y, height(x, y)).cast<float>());
    }
  const auto vertex = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (rows + 1) + j); };
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      model.mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      model.mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      model.mesh.material.insert(model.mesh.material.end(), 2, material);
    }
}

SurfaceModel
makeHouse(SceneBuilder& b, double width)
{
  SurfaceModel model;
  RandomStream& r = b.random();
  const Stuff walls = r.index(3) == 0 ? Stuff::Brick : (r.index(4) == 0 ? Stuff::Stone : Stuff::Plaster);
  const double depth = b.vary(9, 12);
  const int storeys = 2 + r.index(3);
  const double ground = b.vary(3.3, 4.0);
  const double upper = b.vary(2.8, 3.2);
  const int columns = std::max(2, static_cast<int>(std::lround(width / b.vary(2.2, 2.9))));
  const double pitch = width / columns;
  const double pane = std::min(pitch - 0.6, b.vary(1.0, 1.4));
  const int door = r.index(columns);
  const bool shop = b.chance(0.35);
  const Vector2d from(kWall / 2, kWall / 2);
  const Vector2d to(width - kWall / 2, kWall / 2);
  const double offset = -kWall / 2; // openings count from the wall's line

  std::vector<Opening> openings;
  for (int i = 0; i < columns; ++i) {
    const double x = pitch * (i + 0.5) + offset;
    if (i == door)
      openings.push_back({x, 1.15, kBuried, kBuried + 2.3, Filling::Shut, 1, false});
    else if (shop)
      openings.push_back({x, pitch - 0.5, kBuried + 0.5, kBuried + 2.8, Filling::Window, 1, false});
    else
      openings.push_back({x, pane, kBuried + 1.0, kBuried + 2.5, Filling::Window, 1, false});
  }
  parts::addWall(model, {from, to, kWall, openings, walls}, -kBuried, ground + kBuried);
  const double step = pitch * (door + 0.5);
  model.addBlock({step, -0.15, -0.3}, {1.5, 0.3, 0.42}, 0, parts::paint(model, Stuff::Stone));
  if (shop) {
    model.addPolygon({{0.4, 0, ground - 0.3},
                      {width - 0.4, 0, ground - 0.3},
                      {width - 0.4, -1.1, ground - 0.75},
                      {0.4, -1.1, ground - 0.75}},
                     parts::paint(model, Stuff::LightCloth));
  }

  const bool balconies = b.chance(0.55);
  const int balcony = r.index(columns);
  for (int k = 1; k < storeys; ++k) {
    const double z = ground + upper * (k - 1);
    openings.clear();
    for (int i = 0; i < columns; ++i) {
      const bool french = balconies && (i == balcony || (columns > 4 && i == columns - 1 - balcony));
      const double x = pitch * (i + 0.5);
      openings.push_back({x + offset, pane, french ? 0.1 : 0.85, 2.35, Filling::Window, 1, false});
      if (french)
        addBalcony(b, model, x, pane + 1.0, z + 0.1);
      else
        model.addBlock({x, -0.04, z + 0.79}, {pane + 0.2, 0.14, 0.06}, 0, parts::paint(model, Stuff::Stone));
    }
    parts::addWall(model, {from, to, kWall, openings, walls}, z, upper);
    model.addBlock({width / 2, -0.03, z - 0.1}, {width, 0.06, 0.2}, 0, parts::paint(model, Stuff::Stone));
  }
  const double top = ground + upper * (storeys - 1);
  const std::uint16_t material = parts::paint(model, walls);
  for (const double x : {kWall / 2, width - kWall / 2})
    model.addBlock({x, depth / 2 + kWall / 2, -kBuried}, {kWall, depth - kWall, top + kBuried}, 0, material);
  model.addBlock({width / 2, depth - kWall / 2, -kBuried}, {width, kWall, top + kBuried}, 0, material);
  addRoof(b, model, width, depth, top, walls);
  const double pipe = b.chance(0.5) ? 0.15 : width - 0.15;
  parts::addPipe(model, {pipe, -0.08, 0}, {pipe, -0.08, top - 0.1}, 0.05, Stuff::Metal);
  return model;
}

SurfaceModel
makeBlock(SceneBuilder& b, double width, double depth, int storeys)
{
  SurfaceModel model;
  const Stuff walls = b.chance(0.4) ? Stuff::Brick : (b.chance(0.5) ? Stuff::Concrete : Stuff::Plaster);
  const double storey = b.vary(3.2, 3.8);
  const double pitch = b.vary(2.6, 3.6);
  const double pane = pitch * b.vary(0.4, 0.65);
  const double o = kWall / 2;
  const std::array<Vector2d, 5> corners = {
      Vector2d(o, o), {width - o, o}, {width - o, depth - o}, {o, depth - o}, {o, o}};
  for (std::size_t side = 0; side < 4; ++side) {
    const double length = (corners.at(side + 1) - corners.at(side)).norm();
    const int columns = std::max(1, static_cast<int>(std::floor((length - 1) / pitch)));
    const int door = b.random().index(columns);
    for (int k = 0; k < storeys; ++k) {
      const double foot = k == 0 ? kBuried : 0;
      std::vector<Opening> openings;
      for (int i = 0; i < columns; ++i) {
        const double x = length / 2 + pitch * (i - (columns - 1) / 2.0);
        if (k == 0 && i == door)
          openings.push_back({x, std::min(1.6, pitch - 0.4), foot, foot + 2.4, Filling::Shut, 1, false});
        else
          openings.push_back({x, pane, foot + 0.9, foot + 2.5, Filling::Window, 1, false});
      }
      parts::addWall(
          model, {corners.at(side), corners.at(side + 1), kWall, openings, walls}, storey * k - foot, storey + foot);
    }
  }
  // The flat roof with its parapet, and what stands on it.
  const double top = storey * storeys;
  parts::addSlab(model, {-0.15, -0.15, width + 0.15, depth + 0.15}, top + 0.25, 0.4, {}, Stuff::Concrete);
  model.addBlock({width * b.vary(0.25, 0.7), depth / 2, top + 0.25},
                 {b.vary(3, 5), std::min(depth - 2, b.vary(3, 4)), b.vary(2, 2.8)},
                 0,
                 parts::paint(model, Stuff::Metal));
  // Something before the first wall that no other has: a canopy over the door of the south.
  model.addBlock(
      {width * b.vary(0.2, 0.8), -0.7, 2.7}, {b.vary(2, 4), 1.5, 0.15}, 0, parts::paint(model, Stuff::Metal));
  return model;
}

SurfaceModel
makeForestTree(SceneBuilder& b)
{
  SurfaceModel model;
  const double height = b.vary(7, 14);
  const double radius = b.vary(0.09, 0.24);
  const double lean = b.vary(0, 0.05) * height;
  const double angle = b.vary(0, 2 * kPi);
  const Vector3d top(lean * std::cos(angle), lean * std::sin(angle), height * 0.8);
  parts::addPipe(model, {0, 0, -0.5}, top, radius, Stuff::DarkWood);
  constexpr int kRings = 7;
  const bool conifer = b.chance(0.5);
  const int crowns = conifer ? 1 : 2 + b.random().index(2);
  for (int i = 0; i < crowns; ++i) {
    const double wide = conifer ? b.vary(1.0, 1.6) : b.vary(0.9, 1.7);
    const double high = conifer ? height * 0.3 : wide * b.vary(0.7, 1.1);
    const Vector3d centre =
        conifer ? Vector3d(top.x(), top.y(), height * 0.68)
                : Vector3d(top.x() + b.vary(-1, 1), top.y() + b.vary(-1, 1), height - high - b.vary(0, 1.5));
    parts::addBlob(model, centre, {wide, wide, high}, kRings, 0.25, b.random().next(), Stuff::Foliage);
  }
  // Dry branches low on the trunk.
  for (int i = b.random().index(4); i > 0; --i) {
    const double z = b.vary(2.2, 0.45 * height);
    const double yaw = b.vary(0, 2 * kPi);
    const Vector3d foot = top * (z / top.z());
    parts::addPipe(model,
                   {foot.x(), foot.y(), z},
                   {foot.x() + 0.9 * std::cos(yaw), foot.y() + 0.9 * std::sin(yaw), z + b.vary(-0.2, 0.4)},
                   0.025,
                   Stuff::DarkWood);
  }
  return model;
}

bool
stand(SceneBuilder& b, const SurfaceModel& part, const Vector2d& at, double yaw, const Ground& height, double reach)
{
  const Rect foot = Rect{at.x(), at.y(), at.x(), at.y()}.grown(reach);
  const double z = height(at.x(), at.y());
  if (!b.isFree(foot, z - 1, 5))
    return false;
  b.block(foot, z - 1, 5);
  b.model().append(part, parts::standAt({at.x(), at.y(), z}, yaw));
  return true;
}

} // namespace pcl_ssfr::simulation::outdoors
