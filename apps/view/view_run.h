// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/loaded_cloud.h>
#include <apps/methods/report.h>
#include <apps/pairs/measures.h>
#include <apps/view/view_options.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A run to look at: the scans as the method got them, what it found, and the truth where it is known.
struct ViewRun {
  Report report; ///< poses in file coordinates
  io::LoadedCloud source;
  io::LoadedCloud target;
  std::optional<Eigen::Isometry3d> truth;              ///< T_target_source in file coordinates
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(); ///< point of the source at which errors are taken [m]
  SuccessBound bound{2, 0.3};                          ///< a pose is right within this
  std::vector<std::string> remarks;                    ///< what else people should know about the input
};

/** \brief Read, or run again, what the arguments name.
 * \throw UsageError, io::IoError
 */
ViewRun
loadRun(const ViewArguments& arguments);

} // namespace apps
} // namespace pcl_ssfr
