// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/options.h>

#include <pcl/types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// Parts of the registration classes that do not depend on the point type; not for users.
namespace pcl_ssfr::detail {

/// True when validate() accepts \p candidate; otherwise a PCL_ERROR that names the \p setter and quotes the reason.
PCL_SSFR_EXPORT bool
acceptOptions(const std::string& class_name, const char* setter, const Options& candidate);

/// Print a PCL_ERROR "[pcl_ssfr::class::setter] text".
PCL_SSFR_EXPORT void
reportError(const std::string& class_name, const char* setter, const std::string& text);

/// Print a PCL_WARN "[pcl_ssfr::class::where] text".
PCL_SSFR_EXPORT void
reportWarning(const std::string& class_name, const char* where, const std::string& text);

/// Default of pcl::Registration::setMaxCorrespondenceDistance(): "not set" (it is not even finite as a float).
inline const double kUnsetCorrespondenceDistance = std::sqrt(std::numeric_limits<double>::max());

/// The prior with unit vectors; nothing unless both directions are finite and not 0, and \p tolerance is in (0, pi].
PCL_SSFR_EXPORT std::optional<GravityPrior>
gravityPrior(const Eigen::Vector3d& up_source, const Eigen::Vector3d& up_target, double tolerance);

/// The rigid motion nearest to \p guess; nothing when it is not finite or far from rigid (scale, shear, mirror).
PCL_SSFR_EXPORT std::optional<Eigen::Isometry3d>
rigidGuess(const Eigen::Matrix4d& guess);

/// The matrix of \p T with its rotation made orthonormal in double and last row 0 0 0 1.
PCL_SSFR_EXPORT Eigen::Matrix4d
rigidMatrix(const Eigen::Isometry3d& T);

/// Drop the indices outside [0, size); the number dropped.
PCL_SSFR_EXPORT std::size_t
dropOutOfRange(pcl::Indices& indices, std::size_t size);

/// 0, 1, ..., size - 1.
PCL_SSFR_EXPORT pcl::Indices
everyIndex(std::size_t size);

/// True when \p indices is 0, 1, ..., size - 1.
PCL_SSFR_EXPORT bool
isEveryPointInOrder(const pcl::Indices& indices, std::size_t size);

/// Median of \p values (the upper one of an even number); 0 when empty.
PCL_SSFR_EXPORT float
median(std::vector<float> values);

} // namespace pcl_ssfr::detail
