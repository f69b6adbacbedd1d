// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ssfr::testing {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;
constexpr double kMinDistance = 1e-9; ///< a surface nearer than this to a ray's origin is not hit [m]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Keep the nearer hit.
void
keepNearest(std::optional<Hit>& nearest, double distance, const Vector3d& normal)
{
  if (distance > kMinDistance && (!nearest || distance < nearest->distance))
    nearest = Hit{distance, normal};
}

/// Slab method: the ray is inside the box between the last entry into and the first exit from its three slabs.
void
castOnBox(const Box& box, const Vector3d& origin, const Vector3d& direction, std::optional<Hit>& nearest)
{
  const Vector3d to_centre = box.centre - origin;
  const double along = to_centre.dot(direction);
  if (to_centre.squaredNorm() - along * along > box.half_size.squaredNorm())
    return; // passes the bounding sphere

  const Vector3d o = -(box.axes.transpose() * to_centre);
  const Vector3d d = box.axes.transpose() * direction;
  double entry = -kInfinity;
  double exit = kInfinity;
  int entry_axis = 0;
  int exit_axis = 0;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (std::abs(o[k]) > box.half_size[k])
        return;
      continue;
    }
    const double t0 = (-std::copysign(box.half_size[k], d[k]) - o[k]) / d[k];
    const double t1 = (std::copysign(box.half_size[k], d[k]) - o[k]) / d[k];
    if (t0 > entry) {
      entry = t0;
      entry_axis = k;
    }
    if (t1 < exit) {
      exit = t1;
      exit_axis = k;
    }
  }
  if (entry > exit)
    return;
  const bool take_exit = box.inward || entry <= kMinDistance;
  const int axis = take_exit ? exit_axis : entry_axis;
  keepNearest(nearest, take_exit ? exit : entry, -std::copysign(1.0, d[axis]) * box.axes.col(axis));
}

void
castOnSphere(const Sphere& sphere, const Vector3d& origin, const Vector3d& direction, std::optional<Hit>& nearest)
{
  const Vector3d to_centre = sphere.centre - origin;
  const double along = to_centre.dot(direction);
  const double discriminant = sphere.radius * sphere.radius - (to_centre.squaredNorm() - along * along);
  if (discriminant < 0)
    return;
  const double root = std::sqrt(discriminant);
  const double distance = along - root > kMinDistance ? along - root : along + root;
  const Vector3d outward = (distance * direction - to_centre) / sphere.radius;
  keepNearest(nearest, distance, outward.dot(direction) > 0 ? Vector3d(-outward) : outward);
}

void
castOnCylinder(const Cylinder& cylinder, const Vector3d& origin, const Vector3d& direction, std::optional<Hit>& nearest)
{
  const Vector3d from_centre = origin - cylinder.centre;
  const double bound = cylinder.radius * cylinder.radius + cylinder.half_height * cylinder.half_height;
  const double along = from_centre.dot(direction);
  if (from_centre.squaredNorm() - along * along > bound)
    return; // passes the bounding sphere

  const double height = from_centre.dot(cylinder.axis);
  const double climb = direction.dot(cylinder.axis);
  const Vector3d o = from_centre - height * cylinder.axis;
  const Vector3d d = direction - climb * cylinder.axis;
  const auto face = [&direction](const Vector3d& normal) {
    return normal.dot(direction) > 0 ? Vector3d(-normal) : normal;
  };
  const double a = d.squaredNorm();
  const double b = o.dot(d);
  const double discriminant = b * b - a * (o.squaredNorm() - cylinder.radius * cylinder.radius);
  if (a > 0 && discriminant >= 0) {
    for (const double sign : {-1.0, 1.0}) {
      const double t = (-b + sign * std::sqrt(discriminant)) / a;
      if (std::abs(height + t * climb) <= cylinder.half_height)
        keepNearest(nearest, t, face((o + t * d) / cylinder.radius));
    }
  }
  if (climb != 0) {
    for (const double cap : {-cylinder.half_height, cylinder.half_height}) {
      const double t = (cap - height) / climb;
      if ((o + t * d).squaredNorm() <= cylinder.radius * cylinder.radius)
        keepNearest(nearest, t, face(cylinder.axis));
    }
  }
}

Matrix3d
yawRotation(double yaw)
{
  return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
}

/// A room: floor at z = 0, centred on the z axis.
Box
makeShell(double length, double width, double height)
{
  Box shell;
  shell.centre = Vector3d(0, 0, height / 2);
  shell.half_size = Vector3d(length, width, height) / 2;
  shell.inward = true;
  return shell;
}

/// The ground: a thick slab whose upper face is z = 0.
void
addGround(Scene& scene, double size)
{
  scene.addBlock(Vector3d(0, 0, -1), Vector3d(size, size, 1));
}

/// Horizontal distance from the nearest station to the rectangle centre +- half size (yaw ignored: use its circle).
double
clearance(const Scene& scene, const Vector3d& base, const Vector3d& size)
{
  double nearest = kInfinity;
  for (const Vector3d& station : scene.stations) {
    const double distance = (station - base).head<2>().norm() - size.head<2>().norm() / 2;
    nearest = std::min(nearest, distance);
  }
  return nearest;
}

/// A wall along y at x, from y0 to y1, with a door of 0.9 m x 2.05 m centred at door_y.
void
addWallAlongY(Scene& scene, double x, double y0, double y1, double door_y, double height)
{
  constexpr double kThickness = 0.12;
  constexpr double kDoorWidth = 0.9;
  constexpr double kDoorHeight = 2.05;
  const auto part = [&](double from, double to, double z, double tall) {
    scene.addBlock(Vector3d(x, (from + to) / 2, z), Vector3d(kThickness, to - from, tall));
  };
  part(y0, door_y - kDoorWidth / 2, 0, height);
  part(door_y + kDoorWidth / 2, y1, 0, height);
  part(door_y - kDoorWidth / 2, door_y + kDoorWidth / 2, kDoorHeight, height - kDoorHeight);
}

/// A wall along x at y, from x0 to x1, with a door centred at door_x.
void
addWallAlongX(Scene& scene, double y, double x0, double x1, double door_x, double height)
{
  const std::size_t first = scene.boxes.size();
  addWallAlongY(scene, y, x0, x1, door_x, height);
  for (std::size_t i = first; i < scene.boxes.size(); ++i) { // swap x and y
    std::swap(scene.boxes[i].centre.x(), scene.boxes[i].centre.y());
    std::swap(scene.boxes[i].half_size.x(), scene.boxes[i].half_size.y());
  }
}

/// A table: a top and four round legs.
void
addTable(Scene& scene, const Vector3d& base, const Vector3d& size, double yaw)
{
  constexpr double kTop = 0.04;
  constexpr double kLeg = 0.03;
  scene.addBlock(base + Vector3d(0, 0, size.z() - kTop), Vector3d(size.x(), size.y(), kTop), yaw);
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const Vector3d corner(sx * (size.x() / 2 - 2 * kLeg), sy * (size.y() / 2 - 2 * kLeg), 0);
      scene.addColumn(base + yawRotation(yaw) * corner, kLeg, size.z() - kTop);
    }
  }
}

/// Cupboards, shelves and radiators along the walls of the rectangle [x0, x1] x [y0, y1], where stations leave room.
void
furnishWalls(Scene& scene, Random& random, double x0, double x1, double y0, double y1, double height, int count)
{
  constexpr double kFree = 0.45; // kept clear around every station [m]
  for (int i = 0; i < count; ++i) {
    const double depth = random.uniform(0.25, 0.65);
    const double length = random.uniform(0.5, 1.7);
    const double tall = random.uniform(0.4, 0.85 * height);
    const double along = random.uniform(0, 1);
    const int side = random.index(4);
    Vector3d base = Vector3d::Zero();
    Vector3d size(depth, length, tall);
    if (side < 2) {
      base.x() = side == 0 ? x0 + depth / 2 : x1 - depth / 2;
      base.y() = y0 + length / 2 + along * (y1 - y0 - length);
    }
    else {
      size = Vector3d(length, depth, tall);
      base.x() = x0 + length / 2 + along * (x1 - x0 - length);
      base.y() = side == 2 ? y0 + depth / 2 : y1 - depth / 2;
    }
    if (random.uniform(0, 1) < 0.2)
      base.z() = std::max(0.0, 0.95 * height - tall); // hung on the wall
    if (clearance(scene, base, size) > kFree)
      scene.boxes.push_back(Box{base + Vector3d(0, 0, tall / 2), size / 2, Matrix3d::Identity(), false});
  }
}

/// Tables and boxes that stand about at any angle.
void
furnishFloor(Scene& scene, Random& random, double x0, double x1, double y0, double y1, int count)
{
  constexpr double kFree = 0.35;
  for (int i = 0; i < count; ++i) {
    const Vector3d base(random.uniform(x0 + 0.8, x1 - 0.8), random.uniform(y0 + 0.8, y1 - 0.8), 0);
    const Vector3d size(random.uniform(0.4, 1.6), random.uniform(0.4, 0.9), random.uniform(0.4, 0.8));
    const double yaw = random.uniform(-kPi, kPi);
    if (clearance(scene, base, size) < kFree)
      continue;
    if (random.uniform(0, 1) < 0.5)
      addTable(scene, base, size, yaw);
    else
      scene.addBlock(base, size, yaw);
  }
}

/// Three rooms in a rectangle: one takes the left part, two share the right one.
Scene
makeApartment(Random& random, double length, double width, double height)
{
  Scene scene;
  scene.boxes.push_back(makeShell(length, width, height));
  const double x0 = -length / 2;
  const double x1 = length / 2;
  const double y0 = -width / 2;
  const double y1 = width / 2;
  const double wall_x = x0 + random.uniform(0.5, 0.6) * length;
  const double wall_y = y0 + random.uniform(0.5, 0.62) * width;
  const double door_y = wall_y - random.uniform(0.8, 1.2);
  const double door_x = wall_x + random.uniform(0.9, 1.4);
  // In the large room, in front of the door, behind the door.
  scene.stations = {Vector3d((x0 + wall_x) / 2 - 0.6, door_y + 0.5, 1.3),
                    Vector3d(wall_x - 1.1, door_y - 0.1, 1.2),
                    Vector3d(wall_x + 1.0, door_y, 1.4)};
  addWallAlongY(scene, wall_x, y0, y1, door_y, height);
  addWallAlongX(scene, wall_y, wall_x, x1, door_x, height);
  furnishWalls(scene, random, x0, wall_x - 0.06, y0, y1, height, 12);
  furnishWalls(scene, random, wall_x + 0.06, x1, y0, wall_y - 0.06, height, 6);
  furnishWalls(scene, random, wall_x + 0.06, x1, wall_y + 0.06, y1, height, 5);
  furnishFloor(scene, random, x0, wall_x, y0, y1, 6);
  furnishFloor(scene, random, wall_x, x1, y0, wall_y, 3);
  scene.addColumn(Vector3d(x0 + 0.9, y1 - 0.7, 0), 0.15, height); // a pipe shaft
  for (int i = 0; i < 3; ++i) {                                   // lamps
    const Vector3d centre(
        random.uniform(x0 + 1, wall_x - 1), random.uniform(y0 + 1, y1 - 1), height - random.uniform(0.2, 0.5));
    scene.spheres.push_back(Sphere{centre, random.uniform(0.12, 0.2)});
  }
  // A lowered ceiling on one side and a beam under the ceiling: the third axis is not two planes only.
  scene.boxes.push_back(Box{Vector3d((wall_x + x1) / 2, (wall_y + y1) / 2, height - 0.15),
                            Vector3d((x1 - wall_x) / 2, (y1 - wall_y) / 2, 0.15),
                            Matrix3d::Identity(),
                            false});
  const double beam_x = x0 + random.uniform(0.25, 0.4) * (wall_x - x0);
  scene.boxes.push_back(
      Box{Vector3d(beam_x, 0, height - 0.12), Vector3d(0.12, width / 2, 0.12), Matrix3d::Identity(), false});
  return scene;
}

/// A parked car: body and cabin.
void
addCar(Scene& scene, const Vector3d& base, double yaw, double length)
{
  scene.addBlock(base + Vector3d(0, 0, 0.25), Vector3d(length, 1.75, 0.6), yaw);
  scene.addBlock(base + yawRotation(yaw) * Vector3d(-0.3, 0, 0.85), Vector3d(0.55 * length, 1.55, 0.55), yaw);
}

/// One side of the street: houses in a row from x0 to x1, fronts near \p front, facing the road at y = 0.
void
addFacades(Scene& scene, Random& random, double x0, double x1, double front)
{
  const double side = front > 0 ? 1 : -1;
  double x = x0;
  while (x < x1) {
    const double length = random.uniform(7, 15);
    const double depth = random.uniform(8, 12);
    const double height = random.uniform(5, 14);
    const double set_back = random.uniform(0, 2.5);
    const double y = front + side * set_back;
    scene.addBlock(Vector3d(x + length / 2, y + side * depth / 2, 0), Vector3d(length, depth, height));
    for (double bay = x + random.uniform(1, 2); bay < x + length - 1.5; bay += random.uniform(2.5, 5)) {
      // Bays, balconies, porches: boxes that stand out from the front.
      const double out = random.uniform(0.3, 1.1);
      const double wide = random.uniform(0.8, 2.2);
      const double low = random.uniform(0, 1) < 0.4 ? 0 : random.uniform(2.4, 3.2);
      scene.addBlock(Vector3d(bay, y - side * out / 2, low), Vector3d(wide, out, random.uniform(0.9, 2.6)));
    }
    x += length + (random.uniform(0, 1) < 0.5 ? 0 : random.uniform(1.5, 5)); // a gap between houses
  }
}

} // namespace

double
Random::uniform(double low, double high)
{
  constexpr double kScale = 1.0 / 9007199254740992.0; // 2^-53
  return low + (high - low) * (static_cast<double>(engine_() >> 11U) * kScale);
}

double
Random::gaussian()
{
  const double u = 1 - uniform(0, 1); // (0, 1]
  const double v = uniform(0, 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * kPi * v);
}

int
Random::index(int count)
{
  return static_cast<int>(engine_() % static_cast<std::uint64_t>(count));
}

void
Scene::addBlock(const Vector3d& base, const Vector3d& size, double yaw)
{
  boxes.push_back(Box{base + Vector3d(0, 0, size.z() / 2), size / 2, yawRotation(yaw), false});
}

void
Scene::addColumn(const Vector3d& base, double radius, double height)
{
  cylinders.push_back(Cylinder{base + Vector3d(0, 0, height / 2), Vector3d::UnitZ(), radius, height / 2});
}

std::optional<Hit>
castRay(const Scene& scene, const Vector3d& origin, const Vector3d& direction)
{
  std::optional<Hit> nearest;
  for (const Box& box : scene.boxes)
    castOnBox(box, origin, direction, nearest);
  for (const Cylinder& cylinder : scene.cylinders)
    castOnCylinder(cylinder, origin, direction, nearest);
  for (const Sphere& sphere : scene.spheres)
    castOnSphere(sphere, origin, direction, nearest);
  return nearest;
}

SensorPattern
roomScanner(double step)
{
  SensorPattern pattern;
  pattern.azimuth_step = step;
  pattern.elevation_step = step;
  pattern.elevation_min = -1.05;
  pattern.elevation_max = 1.55;
  pattern.max_range = 30;
  pattern.range_noise = 0.01;
  return pattern;
}

SensorPattern
vehicleScanner(int rings)
{
  SensorPattern pattern;
  pattern.azimuth_step = 0.00698;
  pattern.elevation_min = -0.4363;
  pattern.elevation_max = 0.2618;
  pattern.elevation_step = (pattern.elevation_max - pattern.elevation_min) / std::max(rings - 1, 1);
  pattern.min_range = 0.9;
  pattern.max_range = 100;
  pattern.range_noise = 0.02;
  return pattern;
}

SensorPattern
terrestrialScanner(double step)
{
  SensorPattern pattern;
  pattern.azimuth_step = step;
  pattern.elevation_step = step;
  pattern.elevation_min = -1.05;
  pattern.elevation_max = 1.55;
  pattern.min_range = 0.4;
  pattern.max_range = 120;
  pattern.range_noise = 0.003;
  return pattern;
}

ScanWithNormals
castScanWithNormals(const Scene& scene,
                    const Eigen::Isometry3d& T_world_sensor,
                    const SensorPattern& pattern,
                    std::uint64_t seed)
{
  constexpr double kRounding = 1e-9; // so that the last ring or column does not hang on a rounding error
  const auto columns = static_cast<Eigen::Index>(std::ceil(2 * kPi / pattern.azimuth_step - kRounding));
  const auto rings = static_cast<Eigen::Index>(
      std::floor((pattern.elevation_max - pattern.elevation_min) / pattern.elevation_step + kRounding) + 1);
  ScanWithNormals scan{Eigen::Matrix3Xf(3, columns * rings), Eigen::Matrix3Xf(3, columns * rings)};
  const Matrix3d R_world_sensor = T_world_sensor.linear();
  Random random(seed);
  Eigen::Index count = 0;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const double azimuth = static_cast<double>(column) * pattern.azimuth_step;
    for (Eigen::Index ring = 0; ring < rings; ++ring) {
      const double elevation = pattern.elevation_min + static_cast<double>(ring) * pattern.elevation_step;
      // Every ray takes its random numbers, hit or not: a change of the scene leaves the other rays' noise alone.
      const double noise = pattern.range_noise * random.gaussian();
      const bool dropped = random.uniform(0, 1) < pattern.drop_rate;
      const Vector3d direction(
          std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const auto hit = castRay(scene, T_world_sensor.translation(), R_world_sensor * direction);
      if (!hit || dropped || hit->distance < pattern.min_range || hit->distance > pattern.max_range)
        continue;
      scan.points.col(count) = ((hit->distance + noise) * direction).cast<float>();
      scan.normals.col(count) = (R_world_sensor.transpose() * hit->normal).cast<float>();
      ++count;
    }
  }
  scan.points.conservativeResize(3, count);
  scan.normals.conservativeResize(3, count);
  return scan;
}

Eigen::Matrix3Xf
castScan(const Scene& scene, const Eigen::Isometry3d& T_world_sensor, const SensorPattern& pattern, std::uint64_t seed)
{
  return castScanWithNormals(scene, T_world_sensor, pattern, seed).points;
}

Eigen::Isometry3d
sensorPose(const Vector3d& position, double yaw, double tilt)
{
  Eigen::Isometry3d T_world_sensor = Eigen::Isometry3d::Identity();
  T_world_sensor.translation() = position;
  T_world_sensor.linear() = yawRotation(yaw) * Eigen::AngleAxisd(tilt, Vector3d::UnitX()).toRotationMatrix();
  return T_world_sensor;
}

Matrix3d
randomRotation(Random& random)
{
  // A normalised Gaussian 4-vector is a uniform unit quaternion.
  const double w = random.gaussian();
  const double x = random.gaussian();
  const double y = random.gaussian();
  const double z = random.gaussian();
  return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
}

Eigen::Isometry3d
randomMotion(Random& random, double max_translation)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = randomRotation(random);
  for (int k = 0; k < 3; ++k)
    T.translation()[k] = random.uniform(-max_translation, max_translation);
  return T;
}

Eigen::Isometry3d
relativePose(const Eigen::Isometry3d& T_world_target, const Eigen::Isometry3d& T_world_source)
{
  return T_world_target.inverse() * T_world_source;
}

Eigen::Matrix3Xf
transformed(const Eigen::Isometry3d& T, const Eigen::Matrix3Xf& points)
{
  return ((T.linear() * points.cast<double>()).colwise() + T.translation()).cast<float>();
}

Scene
makeFurnishedRoom(std::uint64_t seed)
{
  Random random(seed);
  const double length = random.uniform(9.5, 11.5);
  const double width = random.uniform(7.2, 8.6);
  const double height = random.uniform(2.5, 2.9);
  return makeApartment(random, length, width, height);
}

Scene
makeSymmetricRoom()
{
  Scene scene;
  scene.boxes.push_back(makeShell(8, 5, 2.6));
  // Every piece, and the same piece half a turn about the z axis further.
  for (const double s : {1.0, -1.0}) {
    scene.boxes.push_back(Box{s * Vector3d(3.6, 1.5, 0) + Vector3d(0, 0, 0.9), Vector3d(0.4, 0.7, 0.9)});
    scene.boxes.push_back(Box{s * Vector3d(1.5, -2.25, 0) + Vector3d(0, 0, 0.4), Vector3d(0.8, 0.25, 0.4)});
    scene.boxes.push_back(Box{s * Vector3d(-2.0, -1.2, 0) + Vector3d(0, 0, 0.35), Vector3d(0.5, 0.3, 0.35)});
    scene.boxes.push_back(Box{s * Vector3d(0.3, 2.4, 0) + Vector3d(0, 0, 1.7), Vector3d(0.6, 0.1, 0.5)});
  }
  scene.stations = {Vector3d(0.9, 0.4, 1.3), Vector3d(-0.6, 0.8, 1.3)};
  return scene;
}

Scene
makeEndlessCorridor()
{
  Scene scene;
  scene.boxes.push_back(makeShell(4000, 2.4, 2.6));
  scene.stations = {Vector3d(0, 0.1, 1.3), Vector3d(3, -0.2, 1.2), Vector3d(6, 0.0, 1.3)};
  return scene;
}

Scene
makeSinglePlane()
{
  Scene scene;
  addGround(scene, 4000);
  scene.stations = {Vector3d(0, 0, 1.5), Vector3d(2, 1, 1.4)};
  return scene;
}

Scene
makeSphereInside()
{
  Scene scene;
  scene.spheres.push_back(Sphere{Vector3d::Zero(), 6});
  scene.stations = {Vector3d(0, 0, 0), Vector3d(1, -0.5, 0.3)};
  return scene;
}

Scene
makeHall(std::uint64_t seed)
{
  constexpr double kLength = 40;
  constexpr double kWidth = 24;
  constexpr double kHeight = 8;
  constexpr double kColumnSpacing = 6.5;
  Random random(seed);
  Scene scene;
  scene.boxes.push_back(makeShell(kLength, kWidth, kHeight));
  scene.stations = {Vector3d(-9, -1, 1.6), Vector3d(-4, 2, 1.7), Vector3d(1.5, -2, 1.6), Vector3d(7, 1, 1.8)};
  for (int i = 0; i < 6; ++i) {
    const double x = (i - 2.5) * kColumnSpacing;
    scene.addBlock(Vector3d(x, -6, 0), Vector3d(0.5, 0.5, kHeight)); // square columns on one side
    scene.addColumn(Vector3d(x, 6, 0), 0.3, kHeight);                // round ones on the other
    scene.boxes.push_back(Box{Vector3d(x, 0, kHeight - 0.35), Vector3d(0.15, kWidth / 2, 0.35)}); // roof beams
  }
  // A gallery along part of one wall, offices in a corner, a gate recess as a frame on a short wall.
  scene.boxes.push_back(Box{Vector3d(-6, 10.5, 3.6), Vector3d(random.uniform(8, 12), 1.5, 0.15)});
  scene.addBlock(Vector3d(kLength / 2 - 3, -kWidth / 2 + 2.5, 0), Vector3d(6, 5, random.uniform(2.8, 3.6)));
  scene.addBlock(Vector3d(-kLength / 2 + 0.2, random.uniform(-4, 4), 0), Vector3d(0.4, 4.5, 4.8));
  furnishWalls(scene, random, -kLength / 2, kLength / 2, -kWidth / 2, kWidth / 2, 3.5, 14);
  constexpr double kFree = 1.0;
  for (int i = 0; i < 22; ++i) { // machines, crates, shelves
    const Vector3d base(random.uniform(-18, 18), random.uniform(-10, 9), 0);
    const Vector3d size(random.uniform(0.8, 3.5), random.uniform(0.8, 2), random.uniform(0.7, 2.6));
    const double yaw = random.uniform(0, 1) < 0.6 ? 0 : random.uniform(-kPi, kPi);
    if (clearance(scene, base, size) > kFree)
      scene.addBlock(base, size, yaw);
  }
  return scene;
}

Scene
makeStreet(std::uint64_t seed)
{
  constexpr double kLength = 120;
  Random random(seed);
  Scene scene;
  addGround(scene, 4000);
  scene.stations = {Vector3d(-9, -0.8, 1.9), Vector3d(-3, 0.2, 1.9), Vector3d(3, 0.7, 1.9), Vector3d(9, -0.3, 1.9)};
  addFacades(scene, random, -kLength / 2, kLength / 2, 8);
  addFacades(scene, random, -kLength / 2, kLength / 2, -9);
  for (const double y : {5.5, -6.5}) { // pavements with a kerb
    const double side = y > 0 ? 1 : -1;
    scene.addBlock(Vector3d(0, y + side * 1.2, 0), Vector3d(kLength, 2.4, 0.14));
  }
  for (double x = -50; x < 50; x += random.uniform(5.5, 12)) {
    const double y = random.uniform(0, 1) < 0.5 ? 4.2 : -5.1;
    addCar(scene, Vector3d(x, y, 0), random.uniform(-0.06, 0.06), random.uniform(3.8, 4.8));
  }
  for (double x = -48; x < 50; x += random.uniform(9, 19))
    scene.addColumn(Vector3d(x, 5.9, 0), 0.09, 6);
  for (double x = -45; x < 50; x += random.uniform(8, 18)) { // trees
    const double height = random.uniform(2.2, 3.2);
    const double crown = random.uniform(1.0, 1.7);
    scene.addColumn(Vector3d(x, -7.2, 0), random.uniform(0.12, 0.2), height);
    scene.spheres.push_back(Sphere{Vector3d(x, -7.2, height + 0.8 * crown), crown});
  }
  return scene;
}

std::pair<Scene, Scene>
makeUnrelatedRooms(std::uint64_t seed)
{
  Random random(seed ^ 0x9e3779b97f4a7c15ULL);
  const double length = random.uniform(14, 16);
  const double width = random.uniform(5, 5.8);
  const double height = random.uniform(3.2, 3.6);
  return {makeFurnishedRoom(seed), makeApartment(random, length, width, height)};
}

} // namespace pcl_ssfr::testing
