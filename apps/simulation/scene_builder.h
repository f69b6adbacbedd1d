// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/random_stream.h>
#include <apps/simulation/footprint.h>
#include <apps/simulation/scene_parts.h>
#include <apps/simulation/scenes.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// A walk and the places on it where a scanner is put up.
class WalkPlan {
public:
  /// Walk on to a point of the floor [m].
  void
  to(const Eigen::Vector3d& point);
  /// Walk on and put up the scanner there.
  void
  stop(const Eigen::Vector3d& point);
  const std::vector<Eigen::Vector3d>&
  points() const;
  /// Of each station, how far along the walk it is [m].
  const std::vector<double>&
  stations() const;

private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> stations_;
  double length_ = 0;
};

/** \brief Move everything of a part of a building to a fine binary grid (1/8192 m), so that copies of it at places on
 * that grid (see onGrid()) repeat it to the last bit. Pipes and spheres move as their ends and centres do.
 */
void
snap(Scene& part);
/// The nearest place on the grid of snap() [m].
double
onGrid(double value);
/** \brief Add a part: surfaces, doors, walk areas and loose things, but not its walk.
 * \param[in] half_turn half a turn about the vertical through the part's origin before it is put on \p foot
 */
void
appendScene(Scene& scene, const Scene& part, const Eigen::Vector3d& foot, bool half_turn = false);

/** \brief Puts a scene together and keeps account of what stands where: nothing stands in the path, in a doorway or in
 * something else.
 *
 * The path must be set before anything is placed.
 */
class SceneBuilder {
public:
  /// Sides of a room that furniture can stand at.
  enum Side { South = 0, East = 1, North = 2, West = 3 };

  explicit SceneBuilder(std::uint64_t seed);

  Scene&
  scene();
  SurfaceModel&
  model();
  RandomStream&
  random();
  /// A number between the bounds.
  double
  vary(double low, double high);
  /// True in this share of calls.
  bool
  chance(double share);

  void
  setPath(std::vector<Eigen::Vector3d> path);
  /// The path with its stations.
  void
  setPath(const WalkPlan& walk);
  /// The wall, with a leaf for every opening that has one; the floor before its doors is kept free.
  void
  addWall(const parts::Wall& wall, double z, double height);
  /// Keep the floor free (or: something already stands there) from \p z to \p z + \p height.
  void
  block(const parts::Rect& area, double z, double height);

  /// Put the part there if it meets nothing. \return whether it stands
  bool
  place(const SurfaceModel& part, const Eigen::Vector3d& foot, double yaw);
  /// Put the part somewhere with its back at a side of the room. \p lift: above the floor [m]
  bool
  placeAtWall(const SurfaceModel& part, const parts::Rect& room, double z, Side side, double lift = 0);
  /// At any side of the room, tried in a random order.
  bool
  placeAtAnyWall(const SurfaceModel& part, const parts::Rect& room, double z, double lift = 0);
  /// Put the part somewhere in the room, at a random yaw.
  bool
  placeInside(const SurfaceModel& part, const parts::Rect& room, double z);
  /// The place of the last part that was put somewhere.
  const Eigen::Vector3d&
  lastFoot() const;
  double
  lastYaw() const;
  /// Something movable at this place; it may move within the widest of the walk areas that touch \p room, or within the
  /// whole of it.
  bool
  placeLoose(const SurfaceModel& part,
             const Eigen::Vector3d& foot,
             double yaw,
             const parts::Rect& room,
             bool whole_room = false);
  /// Something movable somewhere in a room.
  bool
  placeLooseInside(const SurfaceModel& part, const parts::Rect& room, double z);
  /// A car that drives in a lane along the axes: it is somewhere else in it in every scan.
  bool
  placeTraffic(const SurfaceModel& car, const Eigen::Vector3d& foot, double yaw, const parts::Rect& lane);
  /// Keep up to \p count free rectangles of a room for people.
  void
  addWalkAreas(const parts::Rect& room, double z, int count, double smallest = 0.8, double largest = 2.2);

  /// Whether nothing is in the way of an upright box from \p z to \p z + \p height.
  bool
  isFree(const parts::Rect& area, double z, double height) const;

  /// Give every loose item the walk area it may move in; what finds none becomes fixed. finish() does this too.
  void
  settleLooseItems();

  /// The scene, checked. \throw SimulationError when a part of it cannot be used
  Scene
  finish(const std::string& description, double natural_step, const std::string& sensor);

private:
  bool
  isFree(const Footprint& footprint, double path_clearance) const;

  Scene scene_;
  RandomStream random_;
  std::vector<Footprint> taken_;
  std::vector<bool> keeps_area_; ///< of the loose items
  Eigen::Vector3d last_foot_ = Eigen::Vector3d::Zero();
  double last_yaw_ = 0;
};

} // namespace pcl_ssfr::simulation
