// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_map.h>

#include <apps/map/map_truth.h>

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How a control point fits.
struct ControlResidual {
  std::string label;        ///< as ControlPoint::label()
  Eigen::Vector3d residual; ///< where the map has it, less where it is in the site [m]
};

/// What is written of a map.
struct MapOutput {
  const MultiwayMap& map;
  std::optional<MapErrors> errors;
  std::vector<ControlResidual> control;
  std::string command;
  double seconds = 0;      ///< of the whole run [s]
  double peak_rss_mib = 0; ///< [MiB]
};

/// poses.csv
std::string
posesCsv(const MultiwayMap& map);
/// links.csv
std::string
linksCsv(const MultiwayMap& map);
/// poses.tum: the number of the scan as its time.
std::string
posesTum(const MultiwayMap& map);
/// map.json
nlohmann::ordered_json
mapJson(const MapOutput& output);
/// What the program prints.
std::string
mapText(const MapOutput& output);

/// Scans outside of the largest component, with reasons: what the program and its report call unplaced.
std::vector<std::size_t>
outsideOfLargest(const MultiwayMap& map);

} // namespace apps
} // namespace pcl_ssfr
