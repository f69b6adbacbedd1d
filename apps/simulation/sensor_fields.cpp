// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/sensor_fields.h>

#include "common/angles.h"

#include <cmath>

namespace pcl_ssfr::simulation {

namespace {

constexpr double kShortDegrees = 1e-10; // a number of degrees with so many decimals is tried first

} // namespace

std::string
patternName(PatternKind kind)
{
  switch (kind) {
  case PatternKind::Rings:
    return "rings";
  case PatternKind::TurningLine:
    return "turning_line";
  case PatternKind::Sphere:
    return "sphere";
  case PatternKind::Rosette:
    return "rosette";
  }
  return "";
}

std::vector<PatternKind>
patternKinds()
{
  return {PatternKind::Rings, PatternKind::TurningLine, PatternKind::Sphere, PatternKind::Rosette};
}

std::vector<NumberField<BeamPattern>>
patternNumbers(PatternKind kind)
{
  if (kind == PatternKind::TurningLine)
    return {{"line_min_deg", &BeamPattern::line_min, true, Limit::Turn, true},
            {"line_max_deg", &BeamPattern::line_max, true, Limit::Turn, true},
            {"turn_min_deg", &BeamPattern::turn_min, true, Limit::Turn, true},
            {"turn_max_deg", &BeamPattern::turn_max, true, Limit::Turn, true}};
  std::vector<NumberField<BeamPattern>> fields = {
      {"azimuth_min_deg", &BeamPattern::azimuth_min, true, Limit::Turn, true},
      {"azimuth_max_deg", &BeamPattern::azimuth_max, true, Limit::Turn, true}};
  if (kind != PatternKind::Rings) {
    fields.push_back({"elevation_min_deg", &BeamPattern::elevation_min, true, Limit::Elevation, true});
    fields.push_back({"elevation_max_deg", &BeamPattern::elevation_max, true, Limit::Elevation, true});
  }
  return fields;
}

std::vector<CountField<BeamPattern>>
patternCounts(PatternKind kind)
{
  switch (kind) {
  case PatternKind::Rings:
    return {{"azimuth_count", &BeamPattern::azimuth_count}};
  case PatternKind::TurningLine:
    return {{"line_count", &BeamPattern::line_count}, {"turn_count", &BeamPattern::turn_count}};
  case PatternKind::Sphere:
    return {{"azimuth_count", &BeamPattern::azimuth_count}, {"elevation_count", &BeamPattern::elevation_count}};
  case PatternKind::Rosette:
    return {{"beam_count", &BeamPattern::azimuth_count}};
  }
  return {};
}

std::vector<NumberField<RangeModel>>
rangeNumbers()
{
  return {{"min_range_m", &RangeModel::min_range, false, Limit::NotNegative, true},
          {"max_range_m", &RangeModel::max_range, false, Limit::Positive, true},
          {"reference_reflectance", &RangeModel::reference_reflectance, false, Limit::Share, true},
          {"bias_m", &RangeModel::bias, false, Limit::Finite, false},
          {"sigma_m", &RangeModel::sigma, false, Limit::NotNegative, true},
          {"sigma_per_metre", &RangeModel::sigma_per_metre, false, Limit::NotNegative, false},
          {"quantum_m", &RangeModel::quantum, false, Limit::NotNegative, false},
          {"angular_jitter_deg", &RangeModel::angular_jitter, true, Limit::NotNegative, false},
          {"beam_divergence_deg", &RangeModel::beam_divergence, true, Limit::NotNegative, false},
          {"beam_diameter_m", &RangeModel::beam_diameter, false, Limit::NotNegative, false},
          {"pulse_length_m", &RangeModel::pulse_length, false, Limit::NotNegative, false},
          {"drop_rate", &RangeModel::drop_rate, false, Limit::LossRate, false}};
}

std::vector<NumberField<SensorModel>>
sensorNumbers()
{
  return {{"scan_time_s", &SensorModel::scan_time, false, Limit::NotNegative, false},
          {"mount_height_m", &SensorModel::mount_height, false, Limit::NotNegative, false}};
}

double
toRadians(double degrees)
{
  return degrees * kDegree;
}

double
toDegrees(double radians)
{
  const double degrees = radians * (180 / kPi);
  // The decimal number itself, not its product with an inexact 1e-10.
  const double decimal = std::round(degrees / kShortDegrees) / (1 / kShortDegrees);
  for (const double candidate :
       {decimal, degrees, std::nextafter(degrees, -INFINITY), std::nextafter(degrees, INFINITY)})
    if (toRadians(candidate) == radians)
      return candidate;
  return degrees;
}

} // namespace pcl_ssfr::simulation
