// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>
#include <apps/simulation/scene_makers.h>

namespace pcl_ssfr::simulation {

namespace {

using parts::Filling;
using parts::Opening;
using parts::Stuff;

constexpr double kHeight = 2.8;     // of the walls [m]
constexpr double kThickness = 0.25; // [m]

Opening
hole(double centre, double width, double bottom, double top)
{
  return {centre, width, bottom, top, Filling::None, 1, false};
}

} // namespace

Scene
makeBasicModel(std::uint64_t seed)
{
  // Walls, openings and a gabled roof, nothing else: an L of a large room, a small one and a porch.
  SceneBuilder b(seed);
  const double width = b.vary(8.6, 9.4);
  const double depth = b.vary(5.6, 6.4);
  const double wing = b.vary(3.2, 3.8);  // width of the wing in the north-east
  const double reach = b.vary(2.8, 3.4); // of the wing to the north
  const double ridge = b.vary(1.4, 1.8); // above the walls
  const double inner = b.vary(5.3, 5.8); // wall between the rooms
  const double t = kThickness;
  const double middle = depth / 2;
  b.setPath({{1.5, middle - 0.4, 0},
             {inner - 1.0, middle, 0},
             {width - 1.6, middle, 0},
             {width - 1.6, depth + reach - 1.4, 0}});

  parts::addSlab(b.model(), {-t, -t, width + t, depth + reach + t}, 0, 0.3, {}, Stuff::Concrete);
  const auto wall = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::vector<Opening> openings) {
    b.addWall({from, to, t, std::move(openings), Stuff::Plaster}, 0, kHeight);
  };
  const double o = t / 2;
  wall({-o, -o}, {width + o, -o}, {hole(2.0, 1.4, 0.9, 2.2), hole(inner + 1.6, 1.0, 0.9, 2.2)});
  wall({width + o, -o}, {width + o, depth + reach + o}, {hole(1.6, 1.2, 0.9, 2.2), hole(depth + 0.9, 0.8, 1.1, 2.0)});
  wall({width + o, depth + reach + o}, {width - wing - o, depth + reach + o}, {hole(1.5, 1.0, 0, 2.1)});
  wall({width - wing - o, depth + reach + o}, {width - wing - o, depth + o}, {});
  wall({width - wing - o, depth + o}, {-o, depth + o}, {hole(2.2, 1.8, 0.6, 2.2)});
  wall({-o, depth + o}, {-o, -o}, {hole(1.7, 1.0, 0, 2.1)});
  wall({inner, 0}, {inner, depth}, {hole(middle, 1.4, 0, 2.1)});
  // Between the rooms and the wing: a beam over a wide passage.
  wall({width - wing, depth + o}, {width, depth + o}, {hole(wing - 1.6, 1.8, 0, 2.3)});

  // The roof of the main part, ridge along x, open to the rooms; its gables are walls.
  const std::uint16_t brick = parts::paint(b.model(), Stuff::Brick);
  const std::uint16_t plaster = parts::paint(b.model(), Stuff::Plaster);
  const double top = kHeight + ridge;
  const double over = 0.4; // eaves
  const double drop = ridge * over / middle;
  const double west = -over;
  const double east = width + over;
  b.model().addPolygon(
      {{west, -over, kHeight - drop}, {east, -over, kHeight - drop}, {east, middle, top}, {west, middle, top}}, brick);
  b.model().addPolygon({{west, middle, top},
                        {east, middle, top},
                        {east, depth + over, kHeight - drop},
                        {west, depth + over, kHeight - drop}},
                       brick);
  for (const double x : {-o, width + o})
    b.model().addPolygon({{x, 0, kHeight}, {x, depth, kHeight}, {x, middle, top}}, plaster);
  // The wing has a flat one, the porch a post.
  parts::addSlab(
      b.model(), {width - wing - t, depth, width + t, depth + reach + t}, kHeight + 0.2, 0.2, {}, Stuff::Concrete);
  b.block({width - wing - t, depth, width + t, depth + reach + t}, kHeight, 0.2);

  // A stove with its pipe and a low wall: what makes the directions distinguishable.
  SurfaceModel stove;
  stove.addBlock({0, 0, 0}, {0.7, 0.6, b.vary(0.8, 1.1)}, 0, parts::paint(stove, Stuff::Brick));
  b.placeAtWall(stove, {0, 0, inner - o, depth}, 0, SceneBuilder::North);
  SurfaceModel counter;
  counter.addBlock({0, 0, 0}, {1.8, 0.5, 0.9}, 0, parts::paint(counter, Stuff::Concrete));
  b.placeAtWall(counter, {inner + o, 0, width, depth}, 0, SceneBuilder::South);
  b.addWalkAreas({0, 0, inner - o, depth}, 0, 2);
  b.addWalkAreas({inner + o, 0, width, depth}, 0, 1);
  return b.finish("the paper's basic model: a small house of two rooms, a wing and a gabled roof", 0.6, "leica_p20");
}

} // namespace pcl_ssfr::simulation
