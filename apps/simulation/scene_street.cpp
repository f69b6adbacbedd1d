// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>
#include <apps/simulation/scene_makers.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::kPi;
using parts::Opening;
using parts::Rect;
using parts::Stuff;

constexpr double kLength = 120; // of the street [m]
constexpr double kKerb = 3.7;   // from the middle [m]
constexpr double kKerbRise = 0.13;
constexpr double kFacade = 6.6; // from the middle [m]
constexpr double kWall = 0.4;   // thickness of facades [m]
constexpr double kBuried = 0.6; // walls go so far below their floor [m]

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

/// A strip of ground between two rows of points, in steps of about a metre.
template <typename Height>
void
addStrip(SurfaceModel& model, const Rect& area, int rows, Stuff stuff, const Height& height)
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

/// A building whose facade is on y = 0 and faces -y; it stands from x = 0 to \p width, behind the facade.
SurfaceModel
makeBuilding(SceneBuilder& b, double width)
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
        const SurfaceModel far = makeBuilding(b, lane + 8);
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
        m.append(makeBuilding(b, width), parts::standAt({x, y, z}));
      else
        m.append(makeBuilding(b, width), parts::standAt({x + width, -y, z}, kPi));
      x += width;
      if (b.chance(0.2))
        x += b.vary(0.8, 3); // a narrow passage between neighbours
    }
  }
  const double z_west = ground.road(-16, 0);
  const double z_east = ground.road(kLength + 16, 0);
  m.append(makeBuilding(b, 22), parts::standAt({-18, -11, z_west}, kPi / 2));
  m.append(makeBuilding(b, 22), parts::standAt({kLength + 18, 11, z_east}, -kPi / 2));

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
