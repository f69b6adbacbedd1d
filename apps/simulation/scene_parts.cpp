// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_parts.h>

#include "common/angles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace pcl_ssfr::simulation::parts {

namespace {

struct StuffEntry {
  const char* name;
  double reflectance;
};

/// In the order of Stuff.
constexpr std::array<StuffEntry, 21> kStuff = {
    {{"plaster", 0.7},    {"wood", 0.5},         {"dark wood", 0.25},     {"asphalt", 0.15},       {"glass", 0.08},
     {"dark cloth", 0.1}, {"light cloth", 0.45}, {"metal", 0.4},          {"concrete", 0.4},       {"foliage", 0.5},
     {"brick", 0.35},     {"tile", 0.6},         {"white plastic", 0.75}, {"black plastic", 0.08}, {"carpet", 0.3},
     {"paper", 0.6},      {"dark paint", 0.12},  {"light paint", 0.6},    {"rubber", 0.05},        {"stone", 0.3},
     {"skin", 0.55}}};

constexpr double kFrameWidth = 0.06;    // of window and door frames [m]
constexpr double kPaneThickness = 0.01; // [m]
constexpr double kSmallest = 1e-6;      // shorter pieces are left out [m]

/// A box of a wall: from \p start to \p end along it, \p low to \p high above its foot, \p depth thick.
struct WallFrame {
  Eigen::Vector2d from;
  Eigen::Vector2d along;
  double yaw;
  double z;

  void
  addPiece(SurfaceModel& model, double start, double end, double low, double high, double depth, Stuff stuff) const
  {
    if (end - start < kSmallest || high - low < kSmallest)
      return;
    const Eigen::Vector2d middle = from + along * ((start + end) / 2);
    model.addBlock({middle.x(), middle.y(), z + low}, {end - start, depth, high - low}, yaw, paint(model, stuff));
  }
};

void
fillOpening(SurfaceModel& model, const WallFrame& frame, const Opening& opening, double thickness)
{
  const double start = opening.centre - opening.width / 2;
  const double end = opening.centre + opening.width / 2;
  if (opening.filling == Filling::Window) {
    const double depth = std::min(0.07, thickness);
    frame.addPiece(model, start, start + kFrameWidth, opening.bottom, opening.top, depth, Stuff::WhitePlastic);
    frame.addPiece(model, end - kFrameWidth, end, opening.bottom, opening.top, depth, Stuff::WhitePlastic);
    const double left = start + kFrameWidth;
    const double right = end - kFrameWidth;
    frame.addPiece(model, left, right, opening.bottom, opening.bottom + kFrameWidth, depth, Stuff::WhitePlastic);
    frame.addPiece(model, left, right, opening.top - kFrameWidth, opening.top, depth, Stuff::WhitePlastic);
    if (opening.width > 1.1)
      frame.addPiece(model,
                     opening.centre - kFrameWidth / 2,
                     opening.centre + kFrameWidth / 2,
                     opening.bottom + kFrameWidth,
                     opening.top - kFrameWidth,
                     depth,
                     Stuff::WhitePlastic);
    frame.addPiece(
        model, left, right, opening.bottom + kFrameWidth, opening.top - kFrameWidth, kPaneThickness, Stuff::Glass);
  }
  if (opening.filling == Filling::Shut) {
    const double depth = std::min(0.05, thickness);
    frame.addPiece(model, start, end, opening.bottom, opening.top, depth, Stuff::Wood);
    frame.addPiece(model, end - 0.16, end - 0.06, opening.bottom + 1, opening.bottom + 1.03, depth + 0.1, Stuff::Metal);
  }
  if (opening.filling == Filling::Shut || opening.filling == Filling::Door) {
    // Trims on both faces, at the sides of the opening.
    const double depth = thickness + 0.03;
    frame.addPiece(model, start - kFrameWidth, start, opening.bottom, opening.top + kFrameWidth, depth, Stuff::Wood);
    frame.addPiece(model, end, end + kFrameWidth, opening.bottom, opening.top + kFrameWidth, depth, Stuff::Wood);
    frame.addPiece(model, start, end, opening.top, opening.top + kFrameWidth, depth, Stuff::Wood);
  }
}

std::uint64_t
hashOf(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed)
{
  std::uint64_t h = seed + 0x9e3779b97f4a7c15ULL;
  for (const std::int64_t v : {x, y, z}) {
    h ^= static_cast<std::uint64_t>(v) + 0x9e3779b97f4a7c15ULL + (h << 6U) + (h >> 2U);
    h = (h ^ (h >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27U)) * 0x94d049bb133111ebULL;
    h ^= h >> 31U;
  }
  return h;
}

double
fade(double t)
{
  return t * t * t * (t * (t * 6 - 15) + 10);
}

} // namespace

std::uint16_t
paint(SurfaceModel& model, Stuff stuff)
{
  const StuffEntry& entry = kStuff.at(static_cast<std::size_t>(stuff));
  return model.addMaterial(entry.name, entry.reflectance);
}

Eigen::Isometry3d
standAt(const Eigen::Vector3d& foot, double yaw)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = foot;
  return T;
}

void
addWall(SurfaceModel& model, const Wall& wall, double z, double height)
{
  const Eigen::Vector2d line = wall.to - wall.from;
  const double length = line.norm();
  if (length < kSmallest)
    return;
  const WallFrame frame{wall.from, line / length, std::atan2(line.y(), line.x()), z};
  std::vector<Opening> openings = wall.openings;
  std::sort(openings.begin(), openings.end(), [](const Opening& a, const Opening& b) { return a.centre < b.centre; });
  double done = -wall.thickness / 2;
  for (const Opening& opening : openings) {
    const double start = opening.centre - opening.width / 2;
    const double end = opening.centre + opening.width / 2;
    frame.addPiece(model, done, start, 0, height, wall.thickness, wall.stuff);
    frame.addPiece(model, start, end, 0, opening.bottom, wall.thickness, wall.stuff);
    frame.addPiece(model, start, end, opening.top, height, wall.thickness, wall.stuff);
    fillOpening(model, frame, opening, wall.thickness);
    done = end;
  }
  frame.addPiece(model, done, length + wall.thickness / 2, 0, height, wall.thickness, wall.stuff);
}

void
addSlab(
    SurfaceModel& model, const Rect& outline, double top, double thickness, const std::vector<Rect>& holes, Stuff stuff)
{
  // Cut along the edges of the holes.
  std::vector<double> xs{outline.x0, outline.x1};
  std::vector<double> ys{outline.y0, outline.y1};
  for (const Rect& hole : holes) {
    for (const double x : {hole.x0, hole.x1})
      if (x > outline.x0 && x < outline.x1)
        xs.push_back(x);
    for (const double y : {hole.y0, hole.y1})
      if (y > outline.y0 && y < outline.y1)
        ys.push_back(y);
  }
  std::sort(xs.begin(), xs.end());
  std::sort(ys.begin(), ys.end());
  const std::uint16_t material = paint(model, stuff);
  for (std::size_t i = 0; i + 1 < xs.size(); ++i)
    for (std::size_t j = 0; j + 1 < ys.size(); ++j) {
      const Eigen::Vector2d centre((xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2);
      const Eigen::Vector2d size(xs[i + 1] - xs[i], ys[j + 1] - ys[j]);
      const bool open = std::any_of(holes.begin(), holes.end(), [&](const Rect& hole) {
        return centre.x() > hole.x0 && centre.x() < hole.x1 && centre.y() > hole.y0 && centre.y() < hole.y1;
      });
      if (!open && size.minCoeff() > kSmallest)
        model.addBlock({centre.x(), centre.y(), top - thickness}, {size.x(), size.y(), thickness}, 0, material);
    }
}

SurfaceModel
makeStairs(double width, int steps, double rise, double tread, Stuff stuff)
{
  SurfaceModel model;
  const std::uint16_t material = paint(model, stuff);
  constexpr double kSlab = 0.25; // thickness of the flight below a step [m]
  for (int i = 0; i < steps; ++i) {
    const double top = rise * (i + 1);
    const double bottom = std::max(0.0, top - rise - kSlab);
    model.addBlock({0, tread * (i + 0.5), bottom}, {width, tread, top - bottom}, 0, material);
  }
  return model;
}

void
addRailing(SurfaceModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height)
{
  constexpr double kPostSpacing = 1.6;
  const double length = (to - from).norm();
  const int fields = std::max(1, static_cast<int>(std::lround(length / kPostSpacing)));
  const Eigen::Vector3d up(0, 0, height);
  for (int i = 0; i <= fields; ++i) {
    const Eigen::Vector3d foot = from + (to - from) * (static_cast<double>(i) / fields);
    addPipe(model, foot, foot + up, 0.02, Stuff::Metal);
  }
  addPipe(model, from + up, to + up, 0.025, Stuff::Metal);
  for (const double share : {0.25, 0.5, 0.75})
    addPipe(model, from + up * share, to + up * share, 0.01, Stuff::Metal);
}

void
addPipe(SurfaceModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, Stuff stuff)
{
  const double length = (to - from).norm();
  model.tubes.push_back({from, (to - from) / length, length, radius, paint(model, stuff)});
}

void
addDisc(SurfaceModel& model,
        const Eigen::Vector3d& centre,
        const Eigen::Vector3d& normal,
        double radius,
        int sides,
        Stuff stuff)
{
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.normalized().cross(u);
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * kPi * i / sides;
    corners.emplace_back(centre + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  addConvexPolygon(model, corners, paint(model, stuff));
}

void
addBlob(SurfaceModel& model,
        const Eigen::Vector3d& centre,
        const Eigen::Vector3d& radii,
        int rings,
        double bump,
        std::uint64_t seed,
        Stuff stuff)
{
  const int sides = 2 * rings;
  const std::uint16_t material = paint(model, stuff);
  TriangleMesh& mesh = model.mesh;
  const auto add = [&](double polar, double azimuth) {
    const Eigen::Vector3d direction(
        std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const Eigen::Vector3d plain = centre + direction.cwiseProduct(radii);
    const double height = bump > 0 ? bump * smoothNoise(plain / (4 * bump), seed) : 0;
    mesh.vertices.emplace_back((plain + height * direction).cast<float>());
  };
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  add(0, 0);
  add(kPi, 0);
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sides; ++j)
      add(kPi * i / rings, 2 * kPi * j / sides);
  const auto vertex = [&](int ring, int side) {
    if (ring == 0)
      return first;
    if (ring == rings)
      return first + 1;
    return first + 2 + static_cast<std::uint32_t>((ring - 1) * sides + side % sides);
  };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sides; ++j) {
      if (i + 1 < rings) {
        mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
        mesh.material.push_back(material);
      }
      if (i > 0) {
        mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        mesh.material.push_back(material);
      }
    }
}

void
addHexahedron(SurfaceModel& model,
              const std::vector<Eigen::Vector3d>& below,
              const std::vector<Eigen::Vector3d>& above,
              Stuff stuff)
{
  const std::uint16_t material = paint(model, stuff);
  model.addPolygon({below.at(3), below.at(2), below.at(1), below.at(0)}, material);
  model.addPolygon({above.at(0), above.at(1), above.at(2), above.at(3)}, material);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    model.addPolygon({below[i], below[j], above[j], above[i]}, material);
  }
}

void
addConvexPolygon(SurfaceModel& model, const std::vector<Eigen::Vector3d>& corners, std::uint16_t material)
{
  for (std::size_t i = 1; i + 1 < corners.size(); i += 2) {
    if (i + 2 < corners.size())
      model.addPolygon({corners[0], corners[i], corners[i + 1], corners[i + 2]}, material);
    else
      model.addPolygon({corners[0], corners[i], corners[i + 1]}, material);
  }
}

double
smoothNoise(const Eigen::Vector3d& point, std::uint64_t seed)
{
  // Gradient noise (Perlin, SIGGRAPH 2002), gradients hashed from the lattice points.
  const Eigen::Vector3d base = point.array().floor();
  const Eigen::Vector3d local = point - base;
  const auto x = static_cast<std::int64_t>(base.x());
  const auto y = static_cast<std::int64_t>(base.y());
  const auto z = static_cast<std::int64_t>(base.z());
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1;
    const int dy = (i >> 1) & 1;
    const int dz = (i >> 2) & 1;
    const std::uint64_t h = hashOf(x + dx, y + dy, z + dz, seed);
    constexpr double kUnit = 1.0 / 1048575.0;
    const Eigen::Vector3d gradient(2 * kUnit * static_cast<double>(h & 0xfffffU) - 1,
                                   2 * kUnit * static_cast<double>((h >> 20U) & 0xfffffU) - 1,
                                   2 * kUnit * static_cast<double>((h >> 40U) & 0xfffffU) - 1);
    const Eigen::Vector3d offset = local - Eigen::Vector3d(dx, dy, dz);
    const double weight = (dx != 0 ? fade(local.x()) : 1 - fade(local.x())) *
                          (dy != 0 ? fade(local.y()) : 1 - fade(local.y())) *
                          (dz != 0 ? fade(local.z()) : 1 - fade(local.z()));
    sum += weight * gradient.dot(offset);
  }
  return 1.6 * sum;
}

} // namespace pcl_ssfr::simulation::parts
