// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_options.h>

#include <apps/common/usage_error.h>
#include <apps/map/map_clouds.h>

#include <Eigen/Core>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// The command line of ssfr_map.
struct MapArguments {
  bool help = false;
  bool version = false;
  std::vector<std::string> inputs; ///< files and folders
  std::string out;                 ///< folder
  unsigned threads = 0;
  PairRule pairs = PairRule::Auto;        ///< which pairs are linked
  std::optional<Eigen::Vector3d> gravity; ///< up, in the frame of every scan
  std::string poses;                      ///< file; empty: none
  double pose_rotation_deg = 10;          ///< tolerance of these [deg]
  double pose_translation_m = 1;          ///< [m]
  std::vector<std::string> pins;
  std::vector<std::pair<std::string, std::string>> accepted;
  std::vector<std::pair<std::string, std::string>> rejected;
  std::string control; ///< file; empty: none
  CloudOutputs clouds;
  std::string truth; ///< file; empty: none
  bool resume = false;
  std::string json;  ///< file or kStandardOutput; empty: none
  bool tum = false;  ///< write poses.tum besides
  std::string words; ///< the command line as it was given
};

/// \throw UsageError
MapArguments
parseMapArguments(const std::vector<std::string>& arguments);

std::string
mapHelp();

} // namespace apps
} // namespace pcl_ssfr
