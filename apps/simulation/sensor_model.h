// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/angles.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// How the beams of a scan are spread and in which order they are fired.
enum class PatternKind {
  Rings,       ///< beams at fixed elevations, spinning about z (HDL-32E, VLP-16)
  TurningLine, ///< a line scanner (2-D) spun or nodded by a unit (UTM-30LX, LMS-200)
  Sphere,      ///< a terrestrial scanner: rows of elevation times columns of azimuth
  Rosette      ///< non-repetitive: elevation swings many times a turn and the next scan goes on elsewhere (Livox)
};

/// The beams of one scan. Angles [rad]; azimuth about z from x, elevation from the xy plane.
struct BeamPattern {
  PatternKind kind = PatternKind::Sphere;
  double azimuth_min = 0;                 ///< Sphere, Rings, Rosette
  double azimuth_max = 6.283185307179586; ///< exclusive when a full turn
  int azimuth_count = 360;                ///< columns a scan, > 0 (Rings: firings a turn; Rosette: beams a scan)
  std::vector<double> ring_elevations;    ///< Rings
  double elevation_min = -1;              ///< Sphere, Rosette
  double elevation_max = 1;               ///< Sphere, Rosette
  int elevation_count = 180;              ///< Sphere
  double line_min = -2;                   ///< TurningLine: in the scan plane, from its forward axis
  double line_max = 2;
  int line_count = 100;
  double turn_min = 0; ///< TurningLine: the unit's angle
  double turn_max = kPi;
  int turn_count = 100;
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ(); ///< of the unit, in the sensor frame, unit
  Eigen::Matrix3d plane_axes =
      Eigen::Matrix3d::Identity(); ///< columns: forward, sideways, normal of the scan plane at turn 0
};

/// What a beam measures, and when it measures nothing. See docs/SIMULATOR.md for the model.
struct RangeModel {
  double min_range = 0.1;             ///< [m]
  double max_range = 30;              ///< [m], on a surface of reference_reflectance met head on
  double reference_reflectance = 0.9; ///< in (0, 1]
  double bias = 0;                    ///< added to every range [m]
  double sigma = 0.01;                ///< 1 sigma of the range at 0 m [m]
  double sigma_per_metre = 0;         ///< growth of sigma with range
  double quantum = 0.001;             ///< ranges are rounded to multiples; 0: not [m]
  double angular_jitter = 0;          ///< 1 sigma of azimuth and elevation [rad]
  double beam_divergence = 0;         ///< full angle [rad]; mixed pixels at edges come of it
  double beam_diameter = 0;           ///< at the sensor [m]
  double pulse_length = 0.5;          ///< surfaces in one beam that lie nearer together than this mix to one range [m]
  double drop_rate = 0;               ///< share of returns lost anywhere, [0, 1)
};

/// A sensor as its maker describes it.
struct SensorModel {
  std::string name;
  std::string description;
  std::vector<std::string> sources; ///< data sheets the figures are from
  BeamPattern pattern;
  RangeModel range;
  double scan_time = 0;      ///< seconds a scan takes, for motion distortion
  double mount_height = 1.2; ///< usual height above the floor [m]
};

/// One beam of a scan.
struct Beam {
  double azimuth = 0;
  double elevation = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX(); ///< unit, sensor frame
  double time = 0;                                      ///< since the start of the scan [s]
  int ring = 0;
};

/// Beams a scan.
std::size_t
beamCount(const SensorModel& sensor);
/// Beam \p index < beamCount(sensor), in the order of firing. \p scan varies non-repetitive patterns.
Beam
beamAt(const SensorModel& sensor, std::size_t index, std::size_t scan);

/// Names of the sensors that come with the program.
std::vector<std::string>
sensorNames();
/// A sensor by name, or from a JSON file when \p name ends in ".json". \throw SimulationError naming file, field, value
SensorModel
makeSensor(const std::string& name);
/// A sensor from JSON text; \p origin names the text in messages. Unknown fields are errors. \throw SimulationError
SensorModel
parseSensor(const std::string& json, const std::string& origin);
/// JSON that parseSensor reads back to the same sensor.
std::string
formatSensor(const SensorModel& sensor);
/// \throw SimulationError naming the field and the value
void
validate(const SensorModel& sensor);
/** \brief The same sensor with about \p beams beams a scan: both grid directions scaled alike, but rings are kept.
 * \throw SimulationError for none or too many
 */
SensorModel
withBeamCount(const SensorModel& sensor, std::size_t beams);

} // namespace pcl_ssfr::simulation
