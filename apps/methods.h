// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/loaded_cloud.h>

#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A registration method that the programs can run, by the name that the command line and result files use.
struct Method {
  std::string name;
  std::string description; ///< half a line for the help
};

/// What a method found, in the coordinates of the files.
struct MethodRun {
  Result result;
  double seconds = 0; ///< the registration alone: thinning and normals included, loading not [s]
  bool judged = true; ///< false: the method knows no confidence, its "converged" only means that it stopped
};

/// All methods, in the order of the help.
const std::vector<Method>&
methods();

/// The method of this name, null when there is none.
const Method*
findMethod(const std::string& name);

/** \brief Run a method on two clouds. The poses of the result map source file coordinates to target file coordinates,
 * computed in double whatever the offsets of the clouds. \param[in] guess in file coordinates; the refiners of PCL
 * start there (or at the identity), ssfr judges it as one more candidate \throw std::invalid_argument for a name that
 * methods() does not list or options that are out of range
 */
MethodRun
runMethod(const std::string& name,
          const io::LoadedCloud& source,
          const io::LoadedCloud& target,
          const Options& options,
          const std::optional<Eigen::Isometry3d>& guess);

} // namespace apps
} // namespace pcl_ssfr
