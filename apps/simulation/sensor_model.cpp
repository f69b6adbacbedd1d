// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/sensor_model.h>

#include "common/angles.h"

#include <apps/simulation/sensor_fields.h>
#include <apps/simulation/simulation_error.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

constexpr double kTwoPi = 2 * kPi;
constexpr double kFullTurn = kTwoPi - 1e-6;       // a span of this much closes the circle
constexpr double kUnitTolerance = 1e-6;           // of axes
constexpr double kMaxBeams = 4294967295.0;        // beams are numbered in 32 bits
constexpr double kRosetteTurns = 10.618033988749; // azimuth turns a scan, irrational: the next scan starts elsewhere
constexpr double kRosetteRest = 0.3819660112501;  // what the swings of elevation a scan exceed a whole number by

double
fraction(double value)
{
  return value - std::floor(value);
}

/// 0 to 1 and back while \p phase goes from 0 to 1.
double
triangleWave(double phase)
{
  return phase < 0.5 ? 2 * phase : 2 - 2 * phase;
}

bool
closesCircle(double span)
{
  return span >= kFullTurn;
}

/// Value number \p index of \p count from \p low to \p high; \p high is left out when the two meet on a circle.
double
gridAngle(double low, double high, int count, std::size_t index)
{
  const int steps = closesCircle(high - low) ? count : std::max(count - 1, 1);
  return low + (high - low) * (static_cast<double>(index) / steps);
}

Eigen::Vector3d
directionOf(double azimuth, double elevation)
{
  const double c = std::cos(elevation);
  return {c * std::cos(azimuth), c * std::sin(azimuth), std::sin(elevation)};
}

Beam
lineBeam(const BeamPattern& pattern, std::size_t index)
{
  const auto line = static_cast<std::size_t>(pattern.line_count);
  Beam beam;
  beam.ring = static_cast<int>(index % line);
  const double angle = gridAngle(pattern.line_min, pattern.line_max, pattern.line_count, index % line);
  const double turn = gridAngle(pattern.turn_min, pattern.turn_max, pattern.turn_count, index / line);
  const Eigen::Vector3d in_plane(std::cos(angle), std::sin(angle), 0);
  beam.direction =
      (Eigen::AngleAxisd(turn, pattern.turn_axis) * Eigen::Vector3d(pattern.plane_axes * in_plane)).normalized();
  beam.azimuth = std::atan2(beam.direction.y(), beam.direction.x());
  beam.elevation = std::asin(std::clamp(beam.direction.z(), -1.0, 1.0));
  return beam;
}

/** Azimuth turns slowly while elevation swings fast between its limits, by numbers of turns that are not rational: the
 * curve does not close, and scan after scan fills the gaps. The strokes of one scan lie as far apart as the beams on
 * them.
 */
Beam
rosetteBeam(const BeamPattern& pattern, std::size_t index, std::size_t scan)
{
  const double count = pattern.azimuth_count;
  const double azimuth_span = pattern.azimuth_max - pattern.azimuth_min;
  const double elevation_span = pattern.elevation_max - pattern.elevation_min;
  const double swings = std::floor(std::sqrt(count * azimuth_span / elevation_span) / 2) + 1 + kRosetteRest;
  const auto phase = [&](double cycles) {
    return fraction(fraction(static_cast<double>(scan) * fraction(cycles)) +
                    fraction(static_cast<double>(index) * cycles / count));
  };
  const double turns = phase(kRosetteTurns);
  Beam beam;
  beam.azimuth = pattern.azimuth_min + azimuth_span * (closesCircle(azimuth_span) ? turns : triangleWave(turns));
  beam.elevation = pattern.elevation_min + elevation_span * triangleWave(phase(swings));
  beam.direction = directionOf(beam.azimuth, beam.elevation);
  return beam;
}

template <typename Struct>
void
check(const std::string& prefix, const NumberField<Struct>& field, const Struct& data)
{
  const double value = data.*field.member;
  const double shown = field.degrees ? toDegrees(value) : value;
  const std::string name = prefix + field.name;
  const bool finite = std::isfinite(value);
  switch (field.limit) {
  case Limit::Finite:
    if (!finite)
      fail(name, shown, "a finite number");
    break;
  case Limit::NotNegative:
    if (!finite || value < 0)
      fail(name, shown, "a number that is not negative");
    break;
  case Limit::Positive:
    if (!finite || value <= 0)
      fail(name, shown, "a positive number");
    break;
  case Limit::Share:
    if (!(value > 0 && value <= 1))
      fail(name, shown, "a number in (0, 1]");
    break;
  case Limit::LossRate:
    if (!(value >= 0 && value < 1))
      fail(name, shown, "a number in [0, 1)");
    break;
  case Limit::Elevation:
    if (!(std::abs(value) <= kPi / 2 + kUnitTolerance))
      fail(name, shown, "a number in [-90, 90]");
    break;
  case Limit::Turn:
    if (!(std::abs(value) <= 2 * kTwoPi))
      fail(name, shown, "a number in [-720, 720]");
    break;
  }
}

/// \p high must be above \p low, by no more than a full turn.
void
checkSpan(const std::string& name, double low, double high)
{
  if (!(high > low) || high - low > kTwoPi + kUnitTolerance)
    fail("pattern." + name + "_max_deg",
         toDegrees(high),
         "more than pattern." + name + "_min_deg (" + std::to_string(toDegrees(low)) + ") and at most 360 more");
}

void
checkAxes(const BeamPattern& pattern)
{
  const auto text = [](const Eigen::Vector3d& v) {
    std::ostringstream out;
    out << '(' << v.x() << ", " << v.y() << ", " << v.z() << ')';
    return out.str();
  };
  if (!(std::abs(pattern.turn_axis.norm() - 1) <= kUnitTolerance))
    fail("pattern.turn_axis", text(pattern.turn_axis), "length 1");
  const Eigen::Matrix3d& axes = pattern.plane_axes;
  if (!((axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kUnitTolerance) ||
      axes.determinant() < 0)
    fail("pattern.plane_forward, plane_sideways, plane_normal",
         text(axes.col(0)) + ", " + text(axes.col(1)) + ", " + text(axes.col(2)),
         "unit vectors at right angles, right-handed");
}

double
countOf(const BeamPattern& pattern)
{
  switch (pattern.kind) {
  case PatternKind::Rings:
    return static_cast<double>(pattern.ring_elevations.size()) * pattern.azimuth_count;
  case PatternKind::TurningLine:
    return static_cast<double>(pattern.line_count) * pattern.turn_count;
  case PatternKind::Sphere:
    return static_cast<double>(pattern.azimuth_count) * pattern.elevation_count;
  case PatternKind::Rosette:
    return pattern.azimuth_count;
  }
  return 0;
}

/// Scale a grid to about \p beams by the same factor in both directions; at least one row and column stay.
void
scaleGrid(int& columns, int& rows, double beams)
{
  const double factor = std::sqrt(beams / (static_cast<double>(columns) * rows));
  columns = static_cast<int>(std::clamp(std::round(columns * factor), 1.0, beams));
  rows = static_cast<int>(std::max(std::round(beams / columns), 1.0));
}

} // namespace

std::size_t
beamCount(const SensorModel& sensor)
{
  return static_cast<std::size_t>(countOf(sensor.pattern));
}

Beam
beamAt(const SensorModel& sensor, std::size_t index, std::size_t scan)
{
  const BeamPattern& pattern = sensor.pattern;
  Beam beam;
  switch (pattern.kind) {
  case PatternKind::Rings: {
    const std::size_t rings = pattern.ring_elevations.size();
    beam.ring = static_cast<int>(index % rings);
    beam.azimuth = gridAngle(pattern.azimuth_min, pattern.azimuth_max, pattern.azimuth_count, index / rings);
    beam.elevation = pattern.ring_elevations[index % rings];
    beam.direction = directionOf(beam.azimuth, beam.elevation);
    break;
  }
  case PatternKind::TurningLine:
    beam = lineBeam(pattern, index);
    break;
  case PatternKind::Sphere: {
    const auto rows = static_cast<std::size_t>(pattern.elevation_count);
    beam.ring = static_cast<int>(index % rows);
    beam.azimuth = gridAngle(pattern.azimuth_min, pattern.azimuth_max, pattern.azimuth_count, index / rows);
    beam.elevation = gridAngle(pattern.elevation_min, pattern.elevation_max, pattern.elevation_count, index % rows);
    beam.direction = directionOf(beam.azimuth, beam.elevation);
    break;
  }
  case PatternKind::Rosette:
    beam = rosetteBeam(pattern, index, scan);
    break;
  }
  beam.time = sensor.scan_time * (static_cast<double>(index) / countOf(pattern));
  return beam;
}

void
validate(const SensorModel& sensor)
{
  const BeamPattern& pattern = sensor.pattern;
  if (sensor.name.empty())
    fail("name", "empty", "a name");
  for (const auto& field : sensorNumbers())
    check("", field, sensor);
  for (const auto& field : patternNumbers(pattern.kind))
    check("pattern.", field, pattern);
  for (const auto& field : patternCounts(pattern.kind))
    if (pattern.*field.member <= 0)
      fail(std::string("pattern.") + field.name, pattern.*field.member, "a positive whole number");
  if (pattern.kind == PatternKind::TurningLine) {
    checkSpan("line", pattern.line_min, pattern.line_max);
    checkSpan("turn", pattern.turn_min, pattern.turn_max);
    checkAxes(pattern);
  }
  else
    checkSpan("azimuth", pattern.azimuth_min, pattern.azimuth_max);
  if (pattern.kind == PatternKind::Sphere || pattern.kind == PatternKind::Rosette)
    checkSpan("elevation", pattern.elevation_min, pattern.elevation_max);
  if (pattern.kind == PatternKind::Rings) {
    if (pattern.ring_elevations.empty())
      fail("pattern.ring_elevations_deg", "empty", "at least one number");
    for (std::size_t i = 0; i < pattern.ring_elevations.size(); ++i)
      if (!(std::abs(pattern.ring_elevations[i]) <= kPi / 2 + kUnitTolerance))
        fail("pattern.ring_elevations_deg[" + std::to_string(i) + "]",
             toDegrees(pattern.ring_elevations[i]),
             "a number in [-90, 90]");
  }
  if (countOf(pattern) > kMaxBeams)
    fail("number of beams", countOf(pattern), "at most 4294967295");

  for (const auto& field : rangeNumbers())
    check("range.", field, sensor.range);
  if (sensor.range.max_range <= sensor.range.min_range)
    fail("range.max_range_m",
         sensor.range.max_range,
         "more than range.min_range_m (" + std::to_string(sensor.range.min_range) + ")");
  if (sensor.range.beam_divergence >= kPi / 2)
    fail("range.beam_divergence_deg", toDegrees(sensor.range.beam_divergence), "less than 90");
}

SensorModel
withBeamCount(const SensorModel& sensor, std::size_t beams)
{
  validate(sensor);
  constexpr auto kMaxCount = static_cast<double>(std::numeric_limits<int>::max());
  const auto wanted = static_cast<double>(beams);
  if (beams == 0 || wanted > kMaxCount)
    fail("number of beams", beams, "a whole number from 1 to 2147483647");
  SensorModel result = sensor;
  BeamPattern& pattern = result.pattern;
  switch (pattern.kind) {
  case PatternKind::Rings: {
    const auto rings = static_cast<double>(pattern.ring_elevations.size());
    pattern.azimuth_count = static_cast<int>(std::max(std::round(wanted / rings), 1.0));
    break;
  }
  case PatternKind::TurningLine:
    scaleGrid(pattern.turn_count, pattern.line_count, wanted);
    break;
  case PatternKind::Sphere:
    scaleGrid(pattern.azimuth_count, pattern.elevation_count, wanted);
    break;
  case PatternKind::Rosette:
    pattern.azimuth_count = static_cast<int>(beams);
    break;
  }
  return result;
}

} // namespace pcl_ssfr::simulation
