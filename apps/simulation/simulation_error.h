// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <stdexcept>

namespace pcl_ssfr::simulation {

/// A scene, sensor, mesh or setting that cannot be used. what() is one line that names the field (and file) and value.
class SimulationError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

} // namespace pcl_ssfr::simulation
