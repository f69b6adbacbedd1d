// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_builder.h>

#include "common/angles.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pcl_ssfr::simulation {

namespace {

using parts::Rect;

constexpr double kPathClearance = 0.5;         // furniture keeps this distance from the path [m]
constexpr double kWalkClearance = 0.55;        // and people this [m]
constexpr double kPathHeight = 2.1;            // above its floor [m]
constexpr double kSkin = 0.02;                 // gap between things, and between things and walls [m]
constexpr double kLeafThickness = 0.04;        // of a door [m]
constexpr double kLeafSwing = 1.55;            // wide open [rad]
constexpr int kTries = 40;                     // places tried for a thing
constexpr int kAreaTries = 200;                // and for a free area
constexpr std::size_t kVerticesAhead = 400000; // of a large scene: parts are appended one by one

constexpr double kGrid = 8192; // steps a metre of snap(); exact in floats below 2 km

template <typename Vector>
Vector
gridPoint(const Vector& point)
{
  using Scalar = typename Vector::Scalar;
  return (point.template cast<double>() * kGrid).array().round().matrix().template cast<Scalar>() /
         static_cast<Scalar>(kGrid);
}

void
snapSurfaces(SurfaceModel& model)
{
  for (Eigen::Vector3f& vertex : model.mesh.vertices)
    vertex = gridPoint(vertex);
  for (Sphere& sphere : model.spheres)
    sphere.centre = gridPoint(sphere.centre);
  for (Tube& tube : model.tubes)
    tube.base = gridPoint(tube.base);
}

/// An upright box along the axes after the motion.
WalkArea
movedArea(const Eigen::Isometry3d& T, const WalkArea& area)
{
  const Eigen::Vector3d a = T * area.lower;
  const Eigen::Vector3d b = T * area.upper;
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

} // namespace

void
WalkPlan::to(const Eigen::Vector3d& point)
{
  if (!points_.empty()) {
    const double step = (point - points_.back()).norm();
    if (step < 1e-9)
      return;
    length_ += step;
  }
  points_.push_back(point);
}

void
WalkPlan::stop(const Eigen::Vector3d& point)
{
  to(point);
  stations_.push_back(length_);
}

const std::vector<Eigen::Vector3d>&
WalkPlan::points() const
{
  return points_;
}

const std::vector<double>&
WalkPlan::stations() const
{
  return stations_;
}

double
onGrid(double value)
{
  return std::round(value * kGrid) / kGrid;
}

void
snap(Scene& part)
{
  snapSurfaces(part.surfaces);
  for (Door& door : part.doors)
    door.hinge = gridPoint(door.hinge);
  for (LooseItem& item : part.loose_items) {
    // As it stands: what is rotated later would differ in the last bits.
    SurfaceModel standing;
    standing.append(item.surfaces, parts::standAt(Eigen::Vector3d::Zero(), item.yaw));
    item.surfaces = standing;
    item.yaw = 0;
    snapSurfaces(item.surfaces);
    item.place = gridPoint(item.place);
  }
}

void
appendScene(Scene& scene, const Scene& part, const Eigen::Vector3d& foot, bool half_turn)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (half_turn)
    T.linear() = Eigen::Vector3d(-1, -1, 1).asDiagonal(); // exact
  T.translation() = foot;
  const double turn = half_turn ? kPi : 0;
  scene.surfaces.append(part.surfaces, T);
  for (Door door : part.doors) {
    door.hinge = T * door.hinge;
    door.closed_yaw += turn;
    scene.doors.push_back(door);
  }
  for (const WalkArea& area : part.walk_areas)
    scene.walk_areas.push_back(movedArea(T, area));
  for (LooseItem item : part.loose_items) {
    item.place = T * item.place;
    item.area = movedArea(T, item.area);
    if (half_turn) {
      SurfaceModel rotated;
      Eigen::Isometry3d R = T;
      R.translation().setZero();
      rotated.append(item.surfaces, R);
      item.surfaces = rotated;
    }
    scene.loose_items.push_back(item);
  }
}

SceneBuilder::SceneBuilder(std::uint64_t seed) : random_(seed)
{
  scene_.surfaces.mesh.vertices.reserve(kVerticesAhead);
  scene_.surfaces.mesh.triangles.reserve(kVerticesAhead);
  scene_.surfaces.mesh.material.reserve(kVerticesAhead);
}

Scene&
SceneBuilder::scene()
{
  return scene_;
}

SurfaceModel&
SceneBuilder::model()
{
  return scene_.surfaces;
}

RandomStream&
SceneBuilder::random()
{
  return random_;
}

double
SceneBuilder::vary(double low, double high)
{
  return random_.uniform(low, high);
}

bool
SceneBuilder::chance(double share)
{
  return random_.uniform() < share;
}

void
SceneBuilder::setPath(std::vector<Eigen::Vector3d> path)
{
  scene_.path = std::move(path);
}

void
SceneBuilder::setPath(const WalkPlan& walk)
{
  scene_.path = walk.points();
  scene_.stations = walk.stations();
}

void
SceneBuilder::addWall(const parts::Wall& wall, double z, double height)
{
  parts::addWall(scene_.surfaces, wall, z, height);
  const Eigen::Vector2d line = wall.to - wall.from;
  const Eigen::Vector2d along = line.normalized();
  const Eigen::Vector2d left(-along.y(), along.x());
  for (const parts::Opening& opening : wall.openings) {
    if (opening.filling == parts::Filling::Window)
      continue;
    // Nothing stands within the width of the opening before and behind it.
    const Eigen::Vector2d centre = wall.from + along * opening.centre;
    const double reach = wall.thickness / 2 + std::min(opening.width, 1.0);
    taken_.push_back({centre,
                      {opening.width / 2 + 0.05, reach},
                      std::atan2(along.y(), along.x()),
                      z + opening.bottom,
                      z + opening.top});
    if (opening.filling != parts::Filling::Door)
      continue;
    const double side = opening.side > 0 ? 1 : -1;
    const double hand = opening.hinge_at_end ? -1 : 1;
    const Eigen::Vector2d foot =
        centre - along * (hand * opening.width / 2) + left * (side * (wall.thickness + kLeafThickness) / 2);
    Door door;
    door.hinge = {foot.x(), foot.y(), z + opening.bottom};
    const Eigen::Vector2d closed = along * hand;
    door.closed_yaw = std::atan2(closed.y(), closed.x());
    door.swing = kLeafSwing * side * hand;
    door.size = {opening.width, kLeafThickness, opening.top - opening.bottom - 0.01};
    scene_.doors.push_back(door);
  }
}

void
SceneBuilder::block(const Rect& area, double z, double height)
{
  taken_.push_back({area.centre(), {area.width() / 2, area.depth() / 2}, 0, z, z + height});
}

bool
SceneBuilder::isFree(const Footprint& footprint, double path_clearance) const
{
  Footprint grown = footprint;
  grown.half.array() += kSkin / 2;
  for (const Footprint& other : taken_)
    if (meet(grown, other))
      return false;
  for (std::size_t i = 0; i + 1 < scene_.path.size(); ++i) {
    const Eigen::Vector3d& a = scene_.path[i];
    const Eigen::Vector3d& b = scene_.path[i + 1];
    if (footprint.high <= std::min(a.z(), b.z()) + kSkin || footprint.low >= std::max(a.z(), b.z()) + kPathHeight)
      continue;
    if (distance(footprint, a.head<2>(), b.head<2>()) < path_clearance)
      return false;
  }
  return true;
}

bool
SceneBuilder::isFree(const Rect& area, double z, double height) const
{
  return isFree({area.centre(), {area.width() / 2, area.depth() / 2}, 0, z, z + height}, kPathClearance);
}

bool
SceneBuilder::place(const SurfaceModel& part, const Eigen::Vector3d& foot, double yaw)
{
  const Footprint footprint = footprintOf(part, foot, yaw);
  if (!isFree(footprint, kPathClearance))
    return false;
  taken_.push_back(footprint);
  scene_.surfaces.append(part, parts::standAt(foot, yaw));
  last_foot_ = foot;
  last_yaw_ = yaw;
  return true;
}

bool
SceneBuilder::placeAtWall(const SurfaceModel& part, const Rect& room, double z, Side side, double lift)
{
  const Eigen::AlignedBox3d box = boundsOf(part);
  // Yaw that turns the part's front (+y) into the room, and the wall as a line.
  const double yaw = static_cast<int>(side) * kPi / 2;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  const double length = side == South || side == North ? room.width() : room.depth();
  const double across = side == South || side == North ? room.depth() : room.width();
  if (box.sizes().x() + 2 * kSkin > length || box.sizes().y() + 2 * kSkin > across)
    return false;
  for (int i = 0; i < kTries; ++i) {
    const double low = -length / 2 + kSkin - box.min().x();
    const double high = length / 2 - kSkin - box.max().x();
    const double along = random_.uniform(low, high);
    const Eigen::Vector2d foot = room.centre() + turn * Eigen::Vector2d(along, -across / 2 + kSkin - box.min().y());
    if (place(part, {foot.x(), foot.y(), z + lift}, yaw))
      return true;
  }
  return false;
}

bool
SceneBuilder::placeAtAnyWall(const SurfaceModel& part, const Rect& room, double z, double lift)
{
  const int first = random_.index(4);
  const int step = random_.index(2) == 0 ? 1 : 3;
  for (int i = 0; i < 4; ++i)
    if (placeAtWall(part, room, z, static_cast<Side>((first + i * step) % 4), lift))
      return true;
  return false;
}

bool
SceneBuilder::placeInside(const SurfaceModel& part, const Rect& room, double z)
{
  const double radius = reachOf(part);
  if (room.width() < 2 * radius || room.depth() < 2 * radius)
    return false;
  for (int i = 0; i < kTries; ++i) {
    const double x = random_.uniform(room.x0 + radius, room.x1 - radius);
    const double y = random_.uniform(room.y0 + radius, room.y1 - radius);
    if (place(part, {x, y, z}, random_.uniform(-kPi, kPi)))
      return true;
  }
  return false;
}

const Eigen::Vector3d&
SceneBuilder::lastFoot() const
{
  return last_foot_;
}

double
SceneBuilder::lastYaw() const
{
  return last_yaw_;
}

bool
SceneBuilder::placeLoose(
    const SurfaceModel& part, const Eigen::Vector3d& foot, double yaw, const Rect& room, bool whole_room)
{
  const Footprint footprint = footprintOf(part, foot, yaw);
  const Eigen::Vector2d reach = Eigen::Rotation2Dd(yaw).toRotationMatrix().cwiseAbs() * footprint.half;
  const Eigen::Vector2d low = footprint.centre - reach;
  const Eigen::Vector2d high = footprint.centre + reach;
  const bool inside = low.x() > room.x0 && low.y() > room.y0 && high.x() < room.x1 && high.y() < room.y1;
  if (!inside || !isFree(footprint, kPathClearance))
    return false;
  taken_.push_back(footprint);
  // Unless the whole room may be used, settleLooseItems() looks for a walk area in it.
  keeps_area_.push_back(whole_room);
  scene_.loose_items.push_back({part, foot, yaw, {{room.x0, room.y0, foot.z()}, {room.x1, room.y1, foot.z()}}});
  last_foot_ = foot;
  last_yaw_ = yaw;
  return true;
}

bool
SceneBuilder::placeTraffic(const SurfaceModel& car, const Eigen::Vector3d& foot, double yaw, const Rect& lane)
{
  if (!placeLoose(car, foot, yaw, lane, true))
    return false;
  scene_.loose_items.back().drives = true;
  return true;
}

bool
SceneBuilder::placeLooseInside(const SurfaceModel& part, const Rect& room, double z)
{
  const double radius = reachOf(part);
  if (room.width() < 2 * radius || room.depth() < 2 * radius)
    return false;
  for (int i = 0; i < kTries; ++i) {
    const double x = random_.uniform(room.x0 + radius, room.x1 - radius);
    const double y = random_.uniform(room.y0 + radius, room.y1 - radius);
    if (placeLoose(part, {x, y, z}, random_.uniform(-kPi, kPi), room))
      return true;
  }
  return false;
}

void
SceneBuilder::addWalkAreas(const Rect& room, double z, int count, double smallest, double largest)
{
  constexpr double kHeadroom = 2;
  for (int i = 0; i < count; ++i) {
    Footprint best{{0, 0}, {0, 0}, 0, z, z + kHeadroom};
    for (int j = 0; j < kAreaTries; ++j) {
      const Eigen::Vector2d half(random_.uniform(smallest, largest) / 2, random_.uniform(smallest, largest) / 2);
      const Eigen::Vector2d share(random_.uniform(), random_.uniform());
      const Eigen::Vector2d low(room.x0 + half.x(), room.y0 + half.y());
      const Eigen::Vector2d high(room.x1 - half.x(), room.y1 - half.y());
      if ((low.array() > high.array()).any())
        continue;
      const Footprint found{low + (high - low).cwiseProduct(share), half, 0, z, z + kHeadroom};
      if (found.half.prod() > best.half.prod() && isFree(found, kWalkClearance))
        best = found;
    }
    if (best.half.prod() <= 0)
      return;
    taken_.push_back(best);
    const Eigen::Vector2d lower = best.centre - best.half;
    const Eigen::Vector2d upper = best.centre + best.half;
    scene_.walk_areas.push_back({{lower.x(), lower.y(), z}, {upper.x(), upper.y(), z}});
  }
}

void
SceneBuilder::settleLooseItems()
{
  std::vector<LooseItem> loose;
  for (std::size_t i = 0; i < scene_.loose_items.size(); ++i) {
    LooseItem& item = scene_.loose_items[i];
    if (keeps_area_.at(i)) {
      loose.push_back(std::move(item));
      continue;
    }
    const double width = 2 * reachOf(item.surfaces);
    const WalkArea room = item.area;
    double widest = 0;
    for (const WalkArea& area : scene_.walk_areas) {
      const Eigen::Vector3d size = area.upper - area.lower;
      const bool in_room = area.lower.x() < room.upper.x() && area.upper.x() > room.lower.x() &&
                           area.lower.y() < room.upper.y() && area.upper.y() > room.lower.y() &&
                           area.lower.z() == room.lower.z();
      if (in_room && std::min(size.x(), size.y()) > width && size.x() * size.y() > widest) {
        widest = size.x() * size.y();
        item.area = area;
      }
    }
    if (widest > 0)
      loose.push_back(std::move(item));
    else
      scene_.surfaces.append(item.surfaces, parts::standAt(item.place, item.yaw));
  }
  scene_.loose_items = std::move(loose);
  keeps_area_.assign(scene_.loose_items.size(), true);
}

Scene
SceneBuilder::finish(const std::string& description, double natural_step, const std::string& sensor)
{
  keeps_area_.resize(scene_.loose_items.size(), true);
  settleLooseItems();
  scene_.description = description;
  scene_.natural_step = natural_step;
  scene_.recommended_sensor = sensor;
  scene_.surfaces.mesh.vertices.shrink_to_fit();
  scene_.surfaces.mesh.triangles.shrink_to_fit();
  scene_.surfaces.mesh.material.shrink_to_fit();
  validate(scene_.surfaces);
  return std::move(scene_);
}

} // namespace pcl_ssfr::simulation
