// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

// Scenes with a known geometry and scans of them with a known pose, for tests and for the clouds in data/.
// Everything is metres and radians; the same arguments always give the same numbers.
namespace pcl_ssfr::testing {

/// Seeded random numbers that do not depend on the standard library's distributions.
class Random {
public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in [low, high).
  double
  uniform(double low, double high);
  /// Normal with mean 0 and standard deviation 1 (Box-Muller; two uniform numbers a call).
  double
  gaussian();
  /// Uniform in [0, count), count > 0.
  int
  index(int count);

private:
  std::mt19937_64 engine_;
};

/// An oriented box. Solid by default; \ref inward makes it a room of which only the inner faces exist.
struct Box {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones(); ///< along its own axes, > 0 [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: the box's axes in the world, a rotation
  bool inward = false;
};

/// A finite cylinder with caps around \ref axis.
struct Cylinder {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< middle of the axis [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double radius = 1;                                ///< > 0 [m]
  double half_height = 1;                           ///< > 0 [m]
};

/// A sphere; seen from inside it is a round room.
struct Sphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< [m]
  double radius = 1;                                ///< > 0 [m]
};

/// Where a ray meets the scene.
struct Hit {
  double distance = 0;                              ///< along the ray, > 0 [m]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(); ///< unit, of the surface, towards the ray's origin
};

/// A set of bodies; z is up and the floor, where there is one, lies at z = 0.
struct Scene {
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;
  std::vector<Sphere> spheres;
  /// Places for a sensor: free space around them, and neighbours in this list see much of the same surface.
  std::vector<Eigen::Vector3d> stations;

  /// Add an upright box that stands on \p base (centre of its lower face), of full size \p size, rotated by \p yaw.
  void
  addBlock(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw = 0);
  /// Add an upright cylinder that stands on \p base.
  void
  addColumn(const Eigen::Vector3d& base, double radius, double height);
};

/// First surface along origin + t direction, t > 0; \p direction is a unit vector. Nothing: no surface.
std::optional<Hit>
castRay(const Scene& scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

/// A scanner that turns about its z axis; elevations are measured from its xy plane.
struct SensorPattern {
  double azimuth_step = 0.01745;   ///< [rad], > 0; a full turn is scanned
  double elevation_min = -0.7854;  ///< [rad], >= -pi/2
  double elevation_max = 0.7854;   ///< [rad], <= pi/2
  double elevation_step = 0.01745; ///< [rad], > 0
  double min_range = 0.1;          ///< nearer returns are lost [m]
  double max_range = 30;           ///< farther returns are lost [m]
  double range_noise = 0.005;      ///< standard deviation of the range [m], >= 0
  double drop_rate = 0;            ///< share of the returns that are lost, [0, 1)
};

/// A room scanner: a line scanner (Hokuyo kind) rotated about its axis, all directions but a cone below, 30 m.
SensorPattern
roomScanner(double step = 0.01745);
/// A spinning multi-ring LiDAR for vehicles: \p rings between -25 and 15 degrees, 0.4 degrees in azimuth, 100 m.
SensorPattern
vehicleScanner(int rings = 32);
/// A terrestrial scanner: all directions but a cone below, 120 m, low noise.
SensorPattern
terrestrialScanner(double step = 0.0087);

/// Points in the sensor frame and the true normals of the surfaces they lie on, 3 x N each.
struct ScanWithNormals {
  Eigen::Matrix3Xf points;  ///< [m], sensor frame
  Eigen::Matrix3Xf normals; ///< unit, sensor frame, towards the sensor
};

/// Scan the scene from \p T_world_sensor. \p seed feeds the range noise and the drop-outs only.
ScanWithNormals
castScanWithNormals(const Scene& scene,
                    const Eigen::Isometry3d& T_world_sensor,
                    const SensorPattern& pattern,
                    std::uint64_t seed);
/// The points of castScanWithNormals, 3 x N in the sensor frame [m].
Eigen::Matrix3Xf
castScan(const Scene& scene, const Eigen::Isometry3d& T_world_sensor, const SensorPattern& pattern, std::uint64_t seed);

/// Sensor pose: at \p position, rotated by \p yaw about the vertical after a tilt of \p tilt about the sensor's x axis.
Eigen::Isometry3d
sensorPose(const Eigen::Vector3d& position, double yaw, double tilt = 0);
/// Uniformly random rotation.
Eigen::Matrix3d
randomRotation(Random& random);
/// Uniformly random rotation and a translation of at most \p max_translation [m] in each coordinate.
Eigen::Isometry3d
randomMotion(Random& random, double max_translation);
/// Ground truth of a pair of scans: maps the source's points into the target's frame.
Eigen::Isometry3d
relativePose(const Eigen::Isometry3d& T_world_target, const Eigen::Isometry3d& T_world_source);
/// Points moved by T, 3 x N.
Eigen::Matrix3Xf
transformed(const Eigen::Isometry3d& T, const Eigen::Matrix3Xf& points);

/// An apartment of about 10 m: three rooms joined by doors, furniture, no symmetry. Three stations.
Scene
makeFurnishedRoom(std::uint64_t seed);
/// A room that a half turn about the z axis maps exactly onto itself, furniture included. Two stations.
Scene
makeSymmetricRoom();
/// A smooth corridor along x whose ends are out of every sensor's range. Stations 3 m apart.
Scene
makeEndlessCorridor();
/// One horizontal plane without an edge in range.
Scene
makeSinglePlane();
/// A round room: the sensor is inside a sphere of 6 m radius.
Scene
makeSphereInside();
/// A hall of 40 m with rows of columns, machines and beams, no exact symmetry. Four stations.
Scene
makeHall(std::uint64_t seed);
/// A street of 120 m: facades with bays and gaps, cars, poles, trees. Four stations 6 m apart.
Scene
makeStreet(std::uint64_t seed);
/// Two furnished places of different size that have nothing to do with each other.
std::pair<Scene, Scene>
makeUnrelatedRooms(std::uint64_t seed);

} // namespace pcl_ssfr::testing
