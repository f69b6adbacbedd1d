// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/dataset_writer.h>
#include <apps/simulation/progress.h>
#include <apps/simulation/scenes.h>
#include <apps/simulation/sensor_model.h>
#include <apps/simulation/trajectory.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// A pose given by hand: so far along the scene's path, rotated about an axis tilted from the vertical.
struct PathMotion {
  double distance = 0; ///< from the start of the path [m]
  double turn = 0;     ///< about the tilted axis [rad]
  double tilt = 0;     ///< of the axis, towards x [rad]
  double rise = 0;     ///< above the sensor's usual height [m]
};

/// Which pairs of scans a dataset lists. The later scan is the source.
enum class PairRule {
  WithinReach, ///< scans up to DatasetPlan::pair_reach apart
  OntoFirst    ///< every scan onto the first one
};

/// A pair_reach that no dataset exceeds: every pair.
constexpr int kAllPairs = 1 << 30;

/// What a dataset shall hold. The same plan gives the same bytes, whatever the number of threads.
struct DatasetPlan {
  std::string name;           ///< empty: scene and sensor
  std::string note;           ///< empty: a summary of the plan
  std::string scene;          ///< a name of sceneNames(), or a mesh file
  SceneOptions scene_options; ///< of a scene by name
  std::string sensor;     ///< a name of sensorNames() or a .json file, or several with commas: scans take them in turn;
                          ///< empty: what the scene recommends
  std::size_t beams = 0;  ///< a scan; 0: as the sensor has them
  std::size_t points = 0; ///< wanted returns a scan, on average, instead of \ref beams; 0: not used
  int start = 0;          ///< number of the first scan: the scans before it on the same walk are left out
  bool at_stations = false;        ///< one scan at each station of the scene, whatever the trajectory says
  TrajectoryOptions trajectory;    ///< its seed and its random rotation are not used
  double turn_limit = 0;           ///< largest change of heading between scans, whatever the path does; 0: none [rad]
  std::vector<PathMotion> motions; ///< one per scan, instead of the trajectory when there are any
  bool random_rotation = false;    ///< every scan in a randomly rotated frame of its own; it sees the same
  MovableOptions movables;         ///< what changes between scans
  bool noise = true;               ///< false: exact ranges
  double velocity = 0;             ///< forward, during the scan [m/s]
  double turn_rate = 0;            ///< about the sensor's z, during the scan [rad/s]
  PairRule pairs = PairRule::WithinReach;
  int pair_reach = 1; ///< 1: consecutive scans
  std::uint64_t seed = 1;
};

/// What a plan stands for, loaded and laid out.
struct PreparedPlan {
  DatasetPlan plan; ///< names filled in
  Scene scene;
  std::vector<SensorModel> sensors; ///< at least one, with the number of beams that the plan asks for
  std::vector<Eigen::Isometry3d> T_world_sensor;

  /// The sensor of a scan, by its place in T_world_sensor: scans take them in turn.
  const SensorModel&
  sensorOf(std::size_t scan) const
  {
    return sensors[(scan + static_cast<std::size_t>(plan.start)) % sensors.size()];
  }
};

/// What was simulated, for people.
struct DatasetSummary {
  std::size_t scans = 0;
  std::size_t beams = 0; ///< a scan, of the last one
  std::size_t least_points = 0;
  std::size_t most_points = 0;
  double mean_points = 0;
  std::vector<DatasetPair> pairs;
  std::size_t bytes = 0;
};

/// The names in DatasetPlan::sensor; a file whose name has a comma is one.
std::vector<std::string>
sensorsOf(const std::string& names);
/// A sensor by name or from a .json file. \throw io::IoError for a file that cannot be used, SimulationError otherwise
SensorModel
loadSensor(const std::string& name);

/** \brief Load scene and sensor, place the scans, and find the number of beams that gives the wanted points.
 * \throw io::IoError for a mesh or sensor file that cannot be used; SimulationError for settings that cannot be met
 */
PreparedPlan
prepare(const DatasetPlan& plan, unsigned threads);

/** \brief Simulate and write every scan, the truth and the description; the writer is not committed.
 * Memory: one scan.
 * \param[in] threads 0: all
 * \throw io::IoError, SimulationError
 */
DatasetSummary
simulateDataset(const PreparedPlan& prepared, DatasetWriter& writer, Progress& progress, unsigned threads);

} // namespace pcl_ssfr::simulation
