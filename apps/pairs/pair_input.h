// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/json_values.h>
#include <apps/methods/cloud_view.h>
#include <apps/pairs/variation.h>

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// A scan and where it lies in another.
struct PosedScan {
  std::string path;
  Eigen::Isometry3d T_target_scan = Eigen::Isometry3d::Identity(); ///< of the files
};

/// A pair of scans on its way to a method: everything that decides the input.
struct PairRequest {
  std::string source;                               ///< path
  std::string target;                               ///< path
  std::optional<Eigen::Isometry3d> T_target_source; ///< ground truth of the files; none: not known, or no pose is right
  std::optional<PosedScan> merged;                  ///< laid into the target
  bool sensor_at_origin = true;                     ///< false: nobody knows where the sensors were
  Variation variation;
  std::uint64_t seed = 1; ///< of this pair
};

/// Two scans as the methods get them.
struct PairInput {
  io::LoadedCloud source; ///< without its table
  io::LoadedCloud target;
  std::optional<Eigen::Isometry3d> T_target_source;    ///< ground truth, in file coordinates; none: no pose is right
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(); ///< where the source's sensor is, or the middle of a map [m]
};

/// A seed for a pair that depends on nothing but its names and the seed of the run.
std::uint64_t
pairSeed(std::uint64_t seed, const std::string& dataset, const std::string& source, const std::string& target);

/** \brief Load a pair and vary it, in this order: another scan into the target, degradation, thinning, noise, outliers,
 * cut, mirroring, motion of the source, origins. \throw io::IoError; std::invalid_argument when the target is to be cut
 * and the truth is not known
 */
PairInput
loadPair(const PairRequest& request);

nlohmann::ordered_json
toJson(const PairRequest& request);

/// \throw nlohmann::json::exception, std::invalid_argument
PairRequest
pairRequestFromJson(const nlohmann::ordered_json& json);

/** \brief A rigid motion from four rows of four numbers, or from 16 numbers, row major.
 * \throw std::invalid_argument saying what is wrong
 */
Eigen::Isometry3d
poseFromJson(const nlohmann::ordered_json& json);

} // namespace apps
} // namespace pcl_ssfr
