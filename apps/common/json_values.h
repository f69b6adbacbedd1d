// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

namespace pcl_ssfr {
namespace apps {

/// A number, or null where JSON has none for it (NaN, infinity).
nlohmann::ordered_json
numberOrNull(double value);

/// A place or a direction as three numbers.
nlohmann::ordered_json
vectorJson(const Eigen::Vector3d& v);

/// A pose as four rows of four numbers.
nlohmann::ordered_json
matrixJson(const Eigen::Isometry3d& T);

} // namespace apps
} // namespace pcl_ssfr
