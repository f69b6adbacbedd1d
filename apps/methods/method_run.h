// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>

#include <apps/io/loaded_cloud.h>
#include <apps/methods/method_parameters.h>
#include <apps/methods/method_registry.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What a method found, in the coordinates of the files.
struct MethodRun {
  Result result;
  double seconds = 0; ///< the registration alone: thinning and normals included, loading not [s]
  bool judged = true; ///< false: the method knows no confidence, its "converged" only means that it stopped
};

/// How a method is run beyond its options.
struct MethodSettings {
  ParameterRule rule;     ///< of every method but ssfr
  std::uint64_t seed = 1; ///< of the methods that draw lots
};

/** \brief Run a method on two clouds. The poses of the result map source file coordinates to target file coordinates,
 * computed in double whatever the offsets of the clouds.
 * \param[in] options of ssfr. leaf, normal_radius, overlap_radius, time_limit and threads, where they are set, go
 * before the rule for the other methods too.
 * \param[in] guess in file coordinates; the refiners of PCL start there (or at the identity), ssfr judges it as one
 * more candidate, the other global methods do not read it
 * \throw std::invalid_argument for a name that methods() does not list or options that are out of range,
 * std::runtime_error as comparisonMethods()
 */
MethodRun
runMethod(const std::string& name,
          const io::LoadedCloud& source,
          const io::LoadedCloud& target,
          const Options& options,
          const std::optional<Eigen::Isometry3d>& guess,
          const MethodSettings& settings = {});

/// Where distances between poses of a source are measured, in its file coordinates [m]: at its sensor, where the result
/// knows that, else in the middle of its points. At the origin of a map, a small rotation would be kilometres.
Eigen::Vector3d
referencePoint(const io::LoadedCloud& source, const Result& result);

/// Sensors that a run found in the points of its scans, in their file coordinates [m]; nothing where it looked for
/// none.
struct FoundSensors {
  explicit FoundSensors(const Result& result);

  std::optional<Eigen::Vector3d> source;
  std::optional<Eigen::Vector3d> target;
};

} // namespace apps
} // namespace pcl_ssfr
