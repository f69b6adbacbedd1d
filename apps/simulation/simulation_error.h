// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::simulation {

/// A scene, sensor, mesh or setting that cannot be used. what() is one line that names the field (and file) and value.
class SimulationError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Throw a SimulationError that names the field, its value and what it needs.
template <typename Value>
[[noreturn]] void
fail(const std::string& field, const Value& value, const std::string& need)
{
  std::ostringstream text;
  text << field << " is " << value << ", needs " << need;
  throw SimulationError(text.str());
}

} // namespace pcl_ssfr::simulation
