// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "search/histogram_correlation.h"
#include "search/rotation_candidates.h"

#include <pcl_ssfr/paper_options.h>

#include <array>
#include <optional>
#include <vector>

namespace pcl_ssfr {

/// A translation composed of one shift an axis.
struct Translation {
  Eigen::Vector3d t_target_source = Eigen::Vector3d::Zero(); ///< [m], target frame
  Eigen::Vector3d shifts = Eigen::Vector3d::Zero();          ///< along each axis [m]
  std::array<bool, 3> observed{{false, false, false}};       ///< false: no plane of both scans along this axis, shift 0
};

/** \brief Three independent axes in the target frame along which a candidate is shifted (METHOD stage 9), one unit axis
 * a column; nothing when the rule drops the candidate.
 */
std::optional<Eigen::Matrix3d>
chooseAxes(const RotationCandidate& candidate,
           const std::vector<MainNormal>& source,
           const std::vector<MainNormal>& target,
           const TranslationOptions& options);

/** \brief Solve [a b c]^T t = shifts (METHOD stage 11). Exact for any independent axes.
 * \throw std::invalid_argument when the axes are linearly dependent.
 */
Eigen::Vector3d
composeShifts(const Eigen::Matrix3d& axes, const Eigen::Vector3d& shifts);

/** \brief Translation of the already rotated source by the highest correlation peak along each axis.
 *
 * \param[in] rotated_source the source samples in the orientation of the target
 * \param[in] target the target samples
 * \param[in] axes chooseAxes()
 * \param[in] coarse when given, shifts are only searched within \p half_range [m] of its shifts (METHOD stage 13)
 * \param[in] smooth_half_window bins of the mean filter on both histograms, 0: none (METHOD stage 13)
 */
Translation
estimateTranslation(const OrientedSamples& rotated_source,
                    const OrientedSamples& target,
                    const Eigen::Matrix3d& axes,
                    const TranslationOptions& options,
                    const Translation* coarse = nullptr,
                    double half_range = -1,
                    int smooth_half_window = 0);

/// The samples moved by \p T: points and normals, weights and extents kept.
OrientedSamples
transformSamples(const OrientedSamples& samples, const Eigen::Isometry3d& T);

} // namespace pcl_ssfr
