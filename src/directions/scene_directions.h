// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "directions/mean_shift.h"

#include <pcl_ssfr/patch_config.h>

#include <Eigen/Core>

#include <vector>

namespace pcl_ssfr {

// Which directions of a scan determine its rotation, besides and beyond its main normals.

/// Cosine of the angle up to which surface faces along an axis: both may err by SearchConfig::direction_error.
double
parallelCos(const SearchConfig& config = {});

/// Main normals with a known vertical, unit: a direction of the scene even where no surface faces it. As many when one
/// of them lies within what main normals are good to.
std::vector<MainNormal>
withVertical(std::vector<MainNormal> main_normals, const Eigen::Vector3d& up, const SearchConfig& config = {});

/// Whether surface faces all ways around \p axis, unit: then the main normals across it are arbitrary. False for no
/// samples.
bool
isRoundAbout(const OrientedSamples& samples, const Eigen::Vector3d& axis, const SearchConfig& config = {});

/// Directions about which the rotation is to be swept, the best main normals, SearchConfig::sweep_axes at most: such
/// that surface faces all ways around, or \p all_of_them, where main normals give one direction only.
std::vector<Eigen::Vector3d>
sweepAxes(const std::vector<MainNormal>& main_normals,
          const OrientedSamples& samples,
          bool all_of_them,
          const SearchConfig& config = {});

} // namespace pcl_ssfr
