// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "directions/density_filter.h"

#include <pcl_ssfr/paper_options.h>

#include <vector>

namespace pcl_ssfr {

/// A main normal: a direction in which much of the scene's surface faces.
struct MainNormal {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(); ///< unit
  double support = 0;                                   ///< weight of the region it was found in
};

/** \brief The mode of each region by mean shift with the Epanechnikov kernel, normalised (paper, section 3.3).
 *
 * Each region starts at its peak and shifts over its own members. Modes that meet are merged.
 * \return main normals in descending support, at most one a region.
 */
std::vector<MainNormal>
findMainNormals(const DirectionSet& directions,
                const std::vector<DenseRegion>& regions,
                const MeanShiftOptions& options);

} // namespace pcl_ssfr
