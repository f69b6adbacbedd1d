// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"
#include <apps/simulation/scene_makers.h>

#include <algorithm>
#include <array>
#include <cmath>

/// Scenes in which registration is ambiguous, or in which the assumption of planes at right angles does not hold.
namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Filling;
using parts::Rect;
using parts::Stuff;

/// A bar along x that goes on to both ends of the corridor.
void
addBar(SurfaceModel& model, double half_length, const Rect& section, Stuff stuff)
{
  // The rectangle's x is the scene's y, its y the scene's z.
  model.addBlock({0, section.centre().x(), section.y0},
                 {2 * half_length, section.width(), section.depth()},
                 0,
                 parts::paint(model, stuff));
}

/// The model rotated by 180 degrees about z: exact, only signs change.
SurfaceModel
halfTurn(SurfaceModel model)
{
  for (Eigen::Vector3f& v : model.mesh.vertices)
    v.head<2>() = -v.head<2>();
  for (Sphere& sphere : model.spheres)
    sphere.centre.head<2>() = -sphere.centre.head<2>();
  for (Tube& tube : model.tubes) {
    tube.base.head<2>() = -tube.base.head<2>();
    tube.axis.head<2>() = -tube.axis.head<2>();
  }
  return model;
}

WalkArea
halfTurn(const WalkArea& area)
{
  return {{-area.upper.x(), -area.upper.y(), area.lower.z()}, {-area.lower.x(), -area.lower.y(), area.upper.z()}};
}

/// Part of a ring: radii, angles and heights from .. to.
struct Arc {
  Vector2d radius;
  Vector2d angle;
  Vector2d height;
};

/// The faces of an arc; a screen has its inner one only.
void
addArc(SurfaceModel& model, const Arc& arc, Stuff stuff, bool screen)
{
  constexpr double kStep = 0.06; // [rad]
  const std::uint16_t material = parts::paint(model, stuff);
  const int pieces = std::max(1, static_cast<int>(std::ceil((arc.angle.y() - arc.angle.x()) / kStep)));
  const auto corner = [&](double radius, double angle, double z) {
    return Vector3d(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  const auto section = [&](double a) {
    return std::array<Vector3d, 4>{corner(arc.radius.x(), a, arc.height.x()),
                                   corner(arc.radius.x(), a, arc.height.y()),
                                   corner(arc.radius.y(), a, arc.height.y()),
                                   corner(arc.radius.y(), a, arc.height.x())};
  };
  for (int i = 0; i < pieces; ++i) {
    const double step = (arc.angle.y() - arc.angle.x()) / pieces;
    const auto here = section(arc.angle.x() + step * i);
    const auto next = section(arc.angle.x() + step * (i + 1));
    for (std::size_t k = 0; k < (screen ? 1U : 4U); ++k) {
      const std::size_t l = (k + 1) % 4;
      model.addPolygon({here[k], here[l], next[l], next[k]}, material);
    }
    if (!screen && i == 0)
      model.addPolygon({here[0], here[1], here[2], here[3]}, material);
    if (!screen && i + 1 == pieces)
      model.addPolygon({next[0], next[1], next[2], next[3]}, material);
  }
}

/// The cap of a sphere over a circle at height \p z; its middle is higher by \p rise.
void
addDome(SurfaceModel& model, double radius, double z, double rise)
{
  constexpr int kRings = 20;
  constexpr int kSides = 160;
  const std::uint16_t material = parts::paint(model, Stuff::Plaster);
  const double sphere = (radius * radius + rise * rise) / (2 * rise);
  const double centre = z + rise - sphere;
  const double widest = std::asin(radius / sphere);
  const auto point = [&](int ring, int side) {
    const double polar = widest * ring / kRings;
    const double azimuth = 2 * kPi * (side % kSides) / kSides;
    return Vector3d(sphere * std::sin(polar) * std::cos(azimuth),
                    sphere * std::sin(polar) * std::sin(azimuth),
                    centre + sphere * std::cos(polar));
  };
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSides; ++j) {
      if (i == 0)
        model.addPolygon({point(0, 0), point(1, j), point(1, j + 1)}, material);
      else
        model.addPolygon({point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)}, material);
    }
}

/// Points with normal . point <= offset.
struct HalfSpace {
  Vector3d normal;
  double offset;
};

/// The part of a convex polygon within a half space.
std::vector<Vector3d>
clip(const std::vector<Vector3d>& polygon, const HalfSpace& space)
{
  std::vector<Vector3d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& a = polygon[i];
    const Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double da = space.normal.dot(a) - space.offset;
    const double db = space.normal.dot(b) - space.offset;
    if (da <= 0)
      kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0))
      kept.emplace_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

/// The face of a convex body on its half space \p index.
std::vector<Vector3d>
faceOf(const std::vector<HalfSpace>& body, std::size_t index)
{
  constexpr double kFar = 100; // beyond the body [m]
  const HalfSpace& own = body[index];
  const Vector3d u = own.normal.unitOrthogonal() * kFar;
  const Vector3d v = own.normal.cross(u);
  const Vector3d middle = own.normal * own.offset;
  std::vector<Vector3d> face{middle - u - v, middle + u - v, middle + u + v, middle - u + v};
  for (std::size_t i = 0; i < body.size(); ++i)
    if (i != index)
      face = clip(face, body[i]);
  return face;
}

/// Whether no two planes are nearer to a right angle than \p margin [rad].
bool
avoidsRightAngles(const std::vector<HalfSpace>& body, double margin)
{
  for (std::size_t i = 0; i < body.size(); ++i)
    for (std::size_t j = i + 1; j < body.size(); ++j)
      if (std::abs(body[i].normal.dot(body[j].normal)) < std::sin(margin))
        return false;
  return true;
}

/// The leaning walls, the floor and the ceiling of the slanted room.
std::vector<HalfSpace>
drawSlantedRoom(RandomStream& random)
{
  constexpr double kMargin = 12 * kDegree;
  for (;;) {
    std::vector<HalfSpace> body{{-Vector3d::UnitZ(), 0}};
    const double start = random.uniform(0, kPi / 3);
    for (int i = 0; i < 6; ++i) {
      // Six walls about 60 degrees apart lean 16 to 22 degrees, some in, some out.
      const double azimuth = start + kPi / 3 * i + random.uniform(-0.07, 0.07);
      const double lean = random.uniform(0.28, 0.38) * (random.uniform() < 0.25 ? -1 : 1);
      const Vector3d normal(std::cos(lean) * std::cos(azimuth), std::cos(lean) * std::sin(azimuth), std::sin(lean));
      const double distance = (i % 3 == 0 ? 6.4 : 5.2) + random.uniform(-0.5, 0.5);
      body.push_back({normal, distance * std::cos(lean) + 1.5 * std::sin(lean)});
    }
    const double pitch = random.uniform(0.04, 0.09);
    const double azimuth = random.uniform(0, 2 * kPi);
    const Vector3d up(std::sin(pitch) * std::cos(azimuth), std::sin(pitch) * std::sin(azimuth), std::cos(pitch));
    body.push_back({up, 3.5 * std::cos(pitch)});
    if (avoidsRightAngles(body, kMargin))
      return body;
  }
}

/// An oblique lump: no face at right angles to another.
SurfaceModel
makeSlantedBlock(RandomStream& random, double size, double height)
{
  SurfaceModel model;
  const double turn = random.uniform(0, 2 * kPi);
  const double lean = random.uniform(0.3, 0.45) * height;
  std::vector<Vector3d> below;
  std::vector<Vector3d> above;
  const Vector3d shift(lean * std::cos(turn + 0.7), lean * std::sin(turn + 0.7), height);
  for (const double angle : {0.0, 1.1, kPi, kPi + 1.1}) {
    const Vector3d corner(size / 2 * std::cos(turn + angle), size / 2 * std::sin(turn + angle), 0);
    below.push_back(corner);
    above.emplace_back(corner * 0.6 + shift);
  }
  // The top rises to one side.
  above[0].z() += 0.3 * height;
  above[1].z() += 0.3 * height * 0.55;
  above[3].z() -= 0.3 * height * 0.55;
  above[2].z() -= 0.3 * height;
  const std::uint16_t wood = parts::paint(model, Stuff::Wood);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    model.addPolygon({below[i], below[j], above[j]}, wood);
    model.addPolygon({below[i], above[j], above[i]}, wood);
  }
  model.addPolygon(above, wood);
  return model;
}

} // namespace

Scene
makeEndlessCorridor(std::uint64_t seed)
{
  SceneBuilder b(seed);
  // The same cross-section over 600 m: beyond every sensor's range nothing changes along x.
  constexpr double kHalf = 300;
  const double w = b.vary(1.0, 1.3); // half the width
  const double h = b.vary(2.5, 2.9);
  SurfaceModel& m = b.model();
  b.setPath({{-15, 0, 0}, {15, 0, 0}});
  addBar(m, kHalf, {-w - 0.2, -0.2, w + 0.2, 0}, Stuff::Tile);
  addBar(m, kHalf, {-w - 0.2, h, w + 0.2, h + 0.2}, Stuff::Plaster);
  addBar(m, kHalf, {-w - 0.2, 0, -w, h}, Stuff::Plaster);
  addBar(m, kHalf, {w, 0, w + 0.2, h}, Stuff::Plaster);
  for (const double x : {-kHalf + 0.05, kHalf - 0.05})
    m.addBlock({x, 0, 0}, {0.1, 2 * w, h}, 0, parts::paint(m, Stuff::Plaster));
  // Skirtings, a dado rail on one side and a handrail on the other, a cable tray, pipes, a strip of lamps.
  addBar(m, kHalf, {-w, 0, -w + 0.015, 0.1}, Stuff::DarkWood);
  addBar(m, kHalf, {w - 0.015, 0, w, 0.1}, Stuff::DarkWood);
  const double rail = b.vary(0.85, 1.0);
  addBar(m, kHalf, {w - 0.03, rail, w, rail + 0.12}, Stuff::Wood);
  parts::addPipe(m, {-kHalf, -w + 0.08, rail}, {kHalf, -w + 0.08, rail}, 0.025, Stuff::Metal);
  const double tray = b.vary(0.25, 0.4);
  addBar(m, kHalf, {-w + 0.05, h - 0.35, -w + 0.05 + tray, h - 0.33}, Stuff::Metal);
  addBar(m, kHalf, {-w + 0.05, h - 0.33, -w + 0.06, h - 0.27}, Stuff::Metal);
  addBar(m, kHalf, {-w + 0.04 + tray, h - 0.33, -w + 0.05 + tray, h - 0.27}, Stuff::Metal);
  for (int i = 0; i < 3; ++i) {
    const double y = w - 0.12 - 0.16 * i;
    parts::addPipe(m, {-kHalf, y, h - 0.15}, {kHalf, y, h - 0.15}, b.vary(0.025, 0.06), Stuff::Metal);
  }
  addBar(m, kHalf, {-0.1, h - 0.06, 0.1, h}, Stuff::WhitePlastic);
  // People stand at the wall.
  for (const double y : {-w + 0.15, w - 0.8})
    b.scene().walk_areas.push_back({{20, y, 0}, {30, y + 0.65, 0}});
  return b.finish(
      "corridor with the same cross-section everywhere: the way along it cannot be observed", 0.6, "hokuyo_utm30lx");
}

Scene
makeSymmetricRoom(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  // One half is built, x > 0 and the walls in the east and north; half a turn makes the other.
  const double x = b.vary(4.2, 4.8);
  const double y = b.vary(2.8, 3.2);
  const double h = b.vary(2.7, 3.0);
  constexpr double kThickness = 0.3;
  constexpr double kOut = kThickness / 2;
  b.setPath({{-x + 1.3, -y + 1.2, 0}, {-1.6, 0, 0}, {1.6, 0, 0}, {x - 1.3, y - 1.2, 0}});
  const Rect half{0.02, -y, x, y};
  parts::addSlab(b.model(), {-x - 0.3, 0, x + 0.3, y + 0.3}, 0, 0.2, {}, Stuff::Wood);
  parts::addSlab(b.model(), {-x - 0.3, 0, x + 0.3, y + 0.3}, h + 0.2, 0.2, {}, Stuff::Plaster);
  b.addWall({{x + kOut, -y - kOut},
             {x + kOut, y + kOut},
             kThickness,
             {{y + b.vary(-1, 0.2), 1.6, 0.9, 2.2, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            h);
  b.addWall({{x + kOut, y + kOut},
             {-x - kOut, y + kOut},
             kThickness,
             {{x - b.vary(1.2, 1.8), 0.95, 0, 2.1, Filling::Shut, 1, false},
              {x + b.vary(1.5, 2.0), 1.3, 0.9, 2.2, Filling::Window, 1, false}},
             Stuff::Plaster},
            0,
            h);
  if (b.placeAtWall(parts::makeDesk(r), half, 0, SceneBuilder::East)) {
    const Eigen::Isometry3d T = parts::standAt(b.lastFoot(), b.lastYaw());
    b.place(parts::makeOfficeChair(r), T * Vector3d(0, 0.8, 0), b.lastYaw() + kPi + b.vary(-0.5, 0.5));
  }
  b.placeAtWall(parts::makeShelf(r, b.vary(0.9, 1.3), b.vary(1.6, 2.2)), half, 0, SceneBuilder::South);
  b.placeAtWall(parts::makeCupboard(r, b.vary(0.8, 1.2), 0.45, b.vary(0.8, 1.2)), half, 0, SceneBuilder::South);
  b.placeAtWall(parts::makePlant(r), half, 0, SceneBuilder::South);
  b.placeAtWall(parts::makeRadiator(1.0), half, 0, SceneBuilder::North);
  b.placeAtWall(parts::makePicture(r), half, 0, SceneBuilder::East, 1.5);
  b.placeInside(parts::makeTable(r, 0.9, 0.7), half, 0);
  b.model().append(parts::makePendantLamp(r), parts::standAt({x / 2, b.vary(-0.5, 0.5), h}));
  b.addWalkAreas(half, 0, 2, 0.7, 1.6);
  b.placeLooseInside(parts::makeBox(r), half, 0);
  b.settleLooseItems();

  const SurfaceModel other = halfTurn(b.model());
  b.model().append(other);
  Scene& scene = b.scene();
  const std::vector<WalkArea> areas = scene.walk_areas;
  for (const WalkArea& area : areas)
    scene.walk_areas.push_back(halfTurn(area));
  std::vector<LooseItem> items;
  for (LooseItem& item : scene.loose_items) {
    // Rotated in place first: a rotation by the same angle plus 180 degrees would differ in the last bits.
    SurfaceModel rotated;
    rotated.append(item.surfaces, parts::standAt(Vector3d::Zero(), item.yaw));
    LooseItem twin = item;
    item.surfaces = rotated;
    item.yaw = 0;
    twin.surfaces = halfTurn(rotated);
    twin.yaw = 0;
    twin.place.head<2>() = -twin.place.head<2>();
    twin.area = halfTurn(item.area);
    items.push_back(item);
    items.push_back(twin);
  }
  scene.loose_items = items;
  return b.finish("furnished room that half a turn maps exactly onto itself", 0.5, "hokuyo_utm30lx");
}

Scene
makeCylinderHall(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const double radius = b.vary(11, 13);
  const double h = b.vary(5.5, 6.5); // of the wall
  const double way = 0.45 * radius;  // radius of the path
  std::vector<Vector3d> path;
  for (int i = 0; i <= 20; ++i) {
    const double angle = 0.25 * i;
    path.emplace_back(way * std::cos(angle), way * std::sin(angle), 0);
  }
  b.setPath(path);
  parts::addSlab(m, {-radius - 1, -radius - 1, radius + 1, radius + 1}, 0, 0.3, {}, Stuff::Stone);
  m.tubes.push_back({{0, 0, -0.2}, Vector3d::UnitZ(), h + 0.5, radius, parts::paint(m, Stuff::Plaster)});
  // The dome: the cap of a sphere that meets the wall at its height.
  const double rise = b.vary(2.5, 3.5);
  addDome(m, radius, h, rise);
  // Columns in a ring, with a ring beam.
  const int columns = 8 + 2 * r.index(3);
  const double ring = 0.74 * radius;
  const double start = b.vary(0, 1);
  for (int i = 0; i < columns; ++i) {
    const double angle = start + 2 * kPi * i / columns;
    const Vector3d foot(ring * std::cos(angle), ring * std::sin(angle), 0);
    m.addColumn(foot, 0.28, h - 0.4, parts::paint(m, Stuff::Concrete));
    m.addColumn(foot, 0.42, 0.25, parts::paint(m, Stuff::Concrete));
    b.block(Rect{foot.x(), foot.y(), foot.x(), foot.y()}.grown(0.42), 0, h);
  }
  addArc(m, {{ring - 0.3, ring + 0.3}, {0, 2 * kPi}, {h - 0.4, h - 0.05}}, Stuff::Concrete, false);
  // Windows and doors follow the wall; curved benches before it; a round counter in the middle.
  double angle = b.vary(0, 1);
  const double end = angle + 2 * kPi - 0.4;
  while (angle < end) {
    const double span = b.vary(0.18, 0.4);
    const int kind = r.index(4);
    if (kind < 2)
      addArc(m, {{radius - 0.04, radius - 0.02}, {angle, angle + span}, {1.1, b.vary(3.0, 4.2)}}, Stuff::Glass, true);
    else if (kind == 2)
      addArc(m, {{radius - 0.5, radius - 0.01}, {angle, angle + span}, {0, 0.45}}, Stuff::Wood, false);
    else
      addArc(m, {{radius - 0.06, radius - 0.01}, {angle, angle + 0.12}, {0, 2.3}}, Stuff::DarkWood, false);
    angle += span + b.vary(0.08, 0.3);
  }
  const double counter = b.vary(0, 2 * kPi);
  addArc(m, {{1.6, 2.1}, {counter, counter + b.vary(3.5, 4.8)}, {0, b.vary(0.9, 1.1)}}, Stuff::Wood, false);
  b.block({-2.2, -2.2, 2.2, 2.2}, 0, 1.2);
  // The area of the hall that furniture may use: a square within the wall.
  const double side = 0.68 * radius;
  const Rect floor{-side, -side, side, side};
  for (int i = 0; i < 3; ++i)
    b.placeInside(parts::makePlant(r), floor, 0);
  for (int i = 0; i < 2; ++i)
    b.placeInside(parts::makeBench(r), floor, 0);
  b.addWalkAreas(floor, 0, 5, 0.9, 2.4);
  for (int i = 0; i < 5; ++i)
    b.placeLooseInside(i < 3 ? parts::makeChair(r) : parts::makeBox(r), floor, 0);
  for (int i = 0; i < 6; ++i) {
    const double at = start + 2 * kPi * (i + 0.5) / 6;
    m.append(parts::makePendantLamp(r), parts::standAt({way * std::cos(at), way * std::sin(at), h - 0.2}));
    parts::addPipe(m,
                   {way * std::cos(at), way * std::sin(at), h - 0.2},
                   {way * std::cos(at), way * std::sin(at), h + 0.9 * rise},
                   0.01,
                   Stuff::BlackPlastic);
  }
  return b.finish("round hall: a curved wall, columns in a ring, a dome", 1.2, "leica_p20");
}

Scene
makeSlanted(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  SurfaceModel& m = b.model();
  const std::vector<HalfSpace> room = drawSlantedRoom(r);
  constexpr double kRoom = 3.1; // half the square in the middle that the path and the furniture use [m]
  b.setPath({{-1.5, -1.3, 0}, {0.2, -1.4, 0}, {1.5, -0.2, 0}, {0.9, 1.3, 0}, {-0.9, 1.0, 0}});
  for (std::size_t i = 0; i < room.size(); ++i) {
    const std::vector<Vector3d> face = faceOf(room, i);
    parts::addConvexPolygon(m, face, parts::paint(m, i == 0 ? Stuff::Wood : Stuff::Plaster));
    if (i == 0 || i + 1 == room.size())
      continue;
    // A panel on every wall, parallel to it, with a slanting outline: window, door or picture.
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& corner : face)
      middle += corner / static_cast<double>(face.size());
    const Vector3d aside = Vector3d::UnitZ().cross(room[i].normal).normalized();
    const Vector3d up = room[i].normal.cross(aside);
    const double half = b.vary(0.4, 0.9);
    const double high = b.vary(0.4, 0.8);
    const double skew = b.vary(0.3, 0.5) * high;
    const Vector3d inside = middle - 0.03 * room[i].normal + b.vary(-0.5, 0.5) * aside;
    m.addPolygon({inside - half * aside - high * up - skew * aside,
                  inside + half * aside - high * up - skew * aside,
                  inside + half * aside + high * up + skew * aside,
                  inside - half * aside + high * up + skew * aside},
                 parts::paint(m, i % 2 == 0 ? Stuff::Glass : Stuff::DarkWood));
  }
  b.addWalkAreas({-kRoom, -kRoom, kRoom, kRoom}, 0, 3, 0.8, 1.6);
  // Leaning posts and oblique lumps.
  for (int i = 0; i < 3; ++i) {
    const double angle = b.vary(0, 2 * kPi);
    const Vector3d foot(3.6 * std::cos(angle), 3.6 * std::sin(angle), 0);
    SurfaceModel post;
    parts::addPipe(post, Vector3d::Zero(), {0.2 * foot.x(), -0.2 * foot.y(), 2.9}, 0.05, Stuff::Metal);
    b.place(post, foot, 0);
  }
  for (int i = 0; i < 7; ++i)
    b.placeInside(makeSlantedBlock(r, b.vary(0.4, 0.9), b.vary(0.4, 1.1)),
                  {-kRoom - 0.6, -kRoom - 0.6, kRoom + 0.6, kRoom + 0.6},
                  0);
  b.addWalkAreas({-kRoom, -kRoom, kRoom, kRoom}, 0, 3, 0.7, 2);
  for (int i = 0; i < 3; ++i)
    b.placeLooseInside(makeSlantedBlock(r, 0.45, 0.4), {-kRoom, -kRoom, kRoom, kRoom}, 0);
  return b.finish(
      "room without right angles: leaning walls in six directions, a sloping ceiling", 0.5, "hokuyo_utm30lx");
}

} // namespace pcl_ssfr::simulation
