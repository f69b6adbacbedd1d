// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// A sensor that comes with the program, as the text of a sensor file.
struct BuiltInSensor {
  std::string name;
  std::string json;
};

/// All of them, in the order they are listed to users.
std::vector<BuiltInSensor>
builtInSensors();

} // namespace pcl_ssfr::simulation
