// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/sensor_model.h>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// What a number may be.
enum class Limit {
  Finite,
  NotNegative,
  Positive,
  Share,     ///< (0, 1]
  LossRate,  ///< [0, 1)
  Elevation, ///< [-90, 90] degrees
  Turn       ///< [-720, 720] degrees
};

/// A number of a struct as sensor files and messages name it.
template <typename Struct>
struct NumberField {
  const char* name;
  double Struct::*member;
  bool degrees; ///< in the file; radians in the struct
  Limit limit;
  bool required;
};

/// A count of a struct as sensor files and messages name it; every count is > 0 and required.
template <typename Struct>
struct CountField {
  const char* name;
  int Struct::*member;
};

/// The name of a pattern in files ("rings", ...).
std::string
patternName(PatternKind kind);
/// All patterns.
std::vector<PatternKind>
patternKinds();

/// The fields that sensors of this pattern have.
std::vector<NumberField<BeamPattern>>
patternNumbers(PatternKind kind);
std::vector<CountField<BeamPattern>>
patternCounts(PatternKind kind);
std::vector<NumberField<RangeModel>>
rangeNumbers();
std::vector<NumberField<SensorModel>>
sensorNumbers();

/// Radians of degrees.
double
toRadians(double degrees);
/// Degrees that toRadians turns back into \p radians, the shortest such number when there is a short one.
double
toDegrees(double radians);

} // namespace pcl_ssfr::simulation
