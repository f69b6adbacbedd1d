// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/surface_model.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// A door leaf that turns about a vertical hinge.
struct Door {
  Eigen::Vector3d hinge = Eigen::Vector3d::Zero(); ///< foot of the hinge [m]
  double closed_yaw = 0;                           ///< direction of the closed leaf [rad]
  double swing = 1.5;                              ///< signed angle to wide open [rad]
  Eigen::Vector3d size = {0.9, 0.04, 2.0};         ///< width, thickness, height [m]
};

/// An upright box that people and other movable things stand on; free of furniture.
struct WalkArea {
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(); ///< on the floor [m]
  Eigen::Vector3d upper = Eigen::Vector3d::Zero(); ///< same z [m]
};

/// Something that may stand elsewhere in the next scan: a chair, a box, a parked car.
struct LooseItem {
  SurfaceModel surfaces;                           ///< around its foot at the origin
  Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< where it stands when nothing moves [m]
  double yaw = 0;                                  ///< and which way it faces [rad]
  WalkArea area;                                   ///< where else it may stand
  bool drives = false;                             ///< a car of the traffic: elsewhere in every scan
};

/// A place with a known geometry, z up.
struct Scene {
  std::string name;
  std::string description;
  SurfaceModel surfaces;              ///< what does not move
  std::vector<Door> doors;            ///< one state a scan
  std::vector<WalkArea> walk_areas;   ///< where people may stand
  std::vector<LooseItem> loose_items; ///< movable furniture
  std::vector<Eigen::Vector3d> path;  ///< a walk of the sensor through free space: points on the floor, in order [m]
  std::vector<double> stations;       ///< where a scanner is put up, how far along the path; empty: no such places [m]
  double natural_step = 1;            ///< usual distance of two scans along the path [m]
  std::string recommended_sensor;     ///< a name of sensorNames()
};

/// Names of the scenes that come with the program.
std::vector<std::string>
sceneNames();
/// What can be chosen of a scene besides its seed.
struct SceneOptions {
  int storeys = 0;    ///< of tower and car_park_levels, 2 to kMostStoreys; 0: as the scene has them
  bool alike = false; ///< storeys, rooms, wings and bays repeat exactly, furniture included
};
constexpr int kMostStoreys = 20;

/** \brief A scene by name; the same seed and options give the same scene.
 * \throw SimulationError naming an unknown scene, or an option that it does not have
 */
Scene
makeScene(const std::string& name, std::uint64_t seed, const SceneOptions& options = {});
/** \brief A scene from a mesh file of the user: its path leads through the middle of its floor.
 *
 * The floor is the height at which most level area lies in the lower part of the mesh; the path is the longest free
 * level line near the middle, with room on both sides from knee to head. No door, person or furniture moves in it.
 * \throw SimulationError as loadMesh does; also naming the file when there is no free place inside
 */
Scene
makeMeshScene(const std::string& path);

/// What changes between two scans.
struct MovableOptions {
  int people = 0;          ///< standing somewhere else in every scan
  bool doors_move = false; ///< each door gets a random angle in every scan; else all stand wide open
  double shut_doors = 0;   ///< share of the doors that are shut, the same ones in every scan, [0, 1]
  double moved_furniture =
      0; ///< share of loose things (chairs, boxes, parked cars) that stand elsewhere in every scan, [0, 1]
};
/** \brief The surfaces of scan number \p scan: what does not move, the doors, the people.
 *
 * Nothing that moves comes nearer than 0.5 m to one of the \p sensors (points of the scan's path, any height), as
 * nobody stands on a scanner's tripod; things that do not find such a place stay where they are, and doors wide open.
 * Cars of the traffic are elsewhere in every scan, whatever the options.
 * \throw SimulationError naming the setting; also when the scene has no room for so many people
 */
SurfaceModel
surfacesAt(const Scene& scene,
           const MovableOptions& options,
           std::uint64_t seed,
           std::size_t scan,
           const std::vector<Eigen::Vector3d>& sensors = {});

} // namespace pcl_ssfr::simulation
