// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/json_values.h>
#include <apps/methods/cloud_view.h>

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

#include <cstdint>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// How the source of a pair is moved before it is registered.
enum class Perturbation {
  None,
  Rotation, ///< a uniformly random rotation about the origin of its frame
  Se3       ///< the same, and a shift of up to the radius of the scan in a random direction
};

/// What is done to a pair before it is registered; ground truth follows. Zero: left as it is.
struct Variation {
  double resolution_m = 0; ///< both scans are thinned to one averaged point a voxel of this edge [m]
  double noise_m = 0;      ///< standard deviation of the Gaussian noise added to each coordinate of the source [m]
  double outliers = 0;     ///< share of the source that becomes uniform noise in its bounding box, [0, 1)
  double overlap = 0;      ///< the target is cut by a plane until so much of the source has a counterpart, [0, 1)
  Perturbation perturbation = Perturbation::None;
};

/// A pair of scans on its way to a method: everything that decides the input.
struct PairRequest {
  std::string source;                                                ///< path
  std::string target;                                                ///< path
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< ground truth of the files
  bool sensor_at_origin = true;                                      ///< false: nobody knows where the sensors were
  Variation variation;
  std::uint64_t seed = 1; ///< of this pair
};

/// Two scans as the methods get them.
struct PairInput {
  io::LoadedCloud source; ///< without its table
  io::LoadedCloud target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< ground truth, in file coordinates
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(); ///< where the source's sensor is, or the middle of a map [m]
};

const char*
toString(Perturbation perturbation);

/// none, rotation or se3. \throw std::invalid_argument
Perturbation
parsePerturbation(const std::string& text);

/// A seed for a pair that depends on nothing but its names and the seed of the run.
std::uint64_t
pairSeed(std::uint64_t seed, const std::string& dataset, const std::string& source, const std::string& target);

/// Load a pair and vary it: thinning, noise, outliers, cut, motion, in this order. \throw io::IoError
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
