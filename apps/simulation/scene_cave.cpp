// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/footprint.h>

#include "common/angles.h"
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scene_builder.h>
#include <apps/simulation/scene_makers.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Stuff;

constexpr int kSections = 300; // along the cave
constexpr int kSides = 120;    // around it

/// A winding tube with chambers, its wall displaced by noise.
class CaveShape {
public:
  explicit CaveShape(RandomStream& random)
      : seed_(random.next()), length_(random.uniform(36, 42)), phase_(random.uniform(0, 6)), rise_(random.uniform(0, 6))
  {}

  double
  length() const
  {
    return length_;
  }

  /// The middle of the cave at a share of its length.
  Vector3d
  centre(double share) const
  {
    const double u = length_ * share;
    return {u, 3.2 * std::sin(u / 6.5 + phase_), 1.1 * std::sin(u / 10 + rise_)};
  }

  /// Level and across the cave, unit.
  Vector3d
  aside(double share) const
  {
    const Vector3d along = centre(share + 1e-4) - centre(share - 1e-4);
    return Vector3d(-along.y(), along.x(), 0).normalized();
  }

  Vector3d
  wall(double share, double angle) const
  {
    const double u = length_ * share;
    // Chambers and narrows; both ends close.
    const double ends = std::sqrt(std::max(0.0, 1 - std::pow(2 * share - 1, 8)));
    const double radius = ends * (2.9 + 1.2 * parts::smoothNoise({u / 7, 0.5, 0.5}, seed_));
    const Vector3d out = std::cos(angle) * aside(share) + 0.85 * std::sin(angle) * Vector3d::UnitZ();
    const Vector3d plain = centre(share) + radius * out;
    return plain + std::sqrt(ends) * relief(plain) * out.normalized();
  }

private:
  /// Bulges of metres and detail of a few decimetres [m].
  double
  relief(const Vector3d& at) const
  {
    return 0.38 * parts::smoothNoise(at / 2.1, seed_ + 1) + 0.22 * parts::smoothNoise(at / 0.95, seed_ + 2) +
           0.16 * parts::smoothNoise(at / 0.45, seed_ + 3);
  }

  std::uint64_t seed_;
  double length_; // [m]
  double phase_;
  double rise_;
};

void
addCave(SurfaceModel& model, const CaveShape& shape)
{
  const std::uint16_t stone = parts::paint(model, Stuff::Stone);
  TriangleMesh& mesh = model.mesh;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i <= kSections; ++i)
    for (int j = 0; j < kSides; ++j)
      mesh.vertices.emplace_back(shape.wall(static_cast<double>(i) / kSections, 2 * kPi * j / kSides).cast<float>());
  const auto vertex = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * kSides + j % kSides); };
  for (int i = 0; i < kSections; ++i)
    for (int j = 0; j < kSides; ++j) {
      // At the ends a section is a single point.
      if (i > 0) {
        mesh.triangles.push_back({vertex(i, j), vertex(i, j + 1), vertex(i + 1, j)});
        mesh.material.push_back(stone);
      }
      if (i + 1 < kSections) {
        mesh.triangles.push_back({vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)});
        mesh.material.push_back(stone);
      }
    }
}

/// Height of the ground below a point inside the cave.
double
groundBelow(const RayCaster& caster, const Vector3d& at)
{
  constexpr double kDeep = 20;
  const auto hit = caster.cast(at, -Vector3d::UnitZ(), kDeep);
  return hit ? at.z() - hit->distance : at.z();
}

/// The highest ground within a radius.
double
highestGround(const RayCaster& caster, const Vector3d& at, double radius)
{
  double highest = groundBelow(caster, at);
  for (const double share : {0.4, 0.7, 1.0})
    for (int i = 0; i < 12; ++i) {
      const double angle = kPi * i / 6;
      const Vector3d around = at + share * radius * Vector3d(std::cos(angle), std::sin(angle), 0);
      highest = std::max(highest, groundBelow(caster, around));
    }
  return highest;
}

} // namespace

Scene
makeCave(std::uint64_t seed)
{
  SceneBuilder b(seed);
  RandomStream& r = b.random();
  const CaveShape shape(r);
  addCave(b.model(), shape);
  const RayCaster bare(b.model());

  constexpr double kStart = 0.14; // share of the length
  constexpr double kEnd = 0.86;
  constexpr double kRoom = 0.4;  // the path runs over the highest ground within this radius, but for small bumps [m]
  constexpr double kBump = 0.12; // [m]
  std::vector<Vector3d> path;
  const int points = 60;
  for (int i = 0; i <= points; ++i) {
    Vector3d at = shape.centre(kStart + (kEnd - kStart) * i / points);
    at.z() = highestGround(bare, at, kRoom) - kBump;
    path.push_back(at);
  }
  b.setPath(path);

  // Boulders and stalagmites next to the path, stalactites above, all half in the rock.
  for (int i = 0; i < 36; ++i) {
    const double share = b.vary(0.08, 0.92);
    const double side = b.chance(0.5) ? 1 : -1;
    const int kind = r.index(3);
    Vector3d at = shape.centre(share) + side * b.vary(1.35, 1.9) * shape.aside(share);
    const double size = b.vary(0.2, 0.4);
    if (kind == 2) {
      const auto roof = bare.cast(at, Vector3d::UnitZ(), 20);
      if (!roof)
        continue;
      at.z() += roof->distance;
    }
    else
      at.z() = groundBelow(bare, at);
    const Vector3d radii = kind == 0 ? Vector3d(1.5 * size, 1.2 * size, size)
                                     : Vector3d(0.6 * size, 0.6 * size, (kind == 1 ? 3.2 : 2.2) * size);
    parts::addBlob(b.model(), at, radii, 14, 0.1, r.next(), Stuff::Stone);
  }
  // People stand where the ground is about level and nothing lies.
  constexpr std::size_t kAreas = 6;
  constexpr double kHalf = 0.35;
  constexpr double kLevel = 0.4; // heights may differ so much [m]
  const RayCaster full(b.model());
  std::vector<WalkArea>& areas = b.scene().walk_areas;
  for (int i = 0; i < 400 && areas.size() < kAreas; ++i) {
    const double share = b.vary(kStart, kEnd);
    const Vector3d at = shape.centre(share) + (b.chance(0.5) ? 1.2 : -1.2) * shape.aside(share);
    double low = groundBelow(full, at);
    double high = low;
    for (const double dx : {-kHalf, -kHalf / 2, 0.0, kHalf / 2, kHalf})
      for (const double dy : {-kHalf, -kHalf / 2, 0.0, kHalf / 2, kHalf}) {
        const double z = groundBelow(full, at + Vector3d(dx, dy, 0));
        low = std::min(low, z);
        high = std::max(high, z);
      }
    const bool apart = std::all_of(areas.begin(), areas.end(), [&](const WalkArea& area) {
      return ((area.lower + area.upper) / 2 - at).head<2>().norm() > 3 * kHalf;
    });
    const Footprint ground{at.head<2>(), {kHalf, kHalf}, 0, 0, 1};
    const bool off_path = std::all_of(path.begin(), path.end(), [&](const Vector3d& point) {
      return distance(ground, point.head<2>(), point.head<2>()) > 0.55;
    });
    if (high - low > kLevel || !apart || !off_path)
      continue;
    const double z = (low + high) / 2;
    areas.push_back({{at.x() - kHalf, at.y() - kHalf, z}, {at.x() + kHalf, at.y() + kHalf, z}});
  }
  return b.finish("winding cave with chambers, boulders and stalagmites: nothing is flat", 0.8, "livox_mid360");
}

} // namespace pcl_ssfr::simulation
