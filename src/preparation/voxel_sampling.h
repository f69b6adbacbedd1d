// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <vector>

namespace pcl_ssfr {

/** \brief One real point per voxel of edge \p leaf [m]: the one nearest to the voxel's centre, ties to the lower
 * column, as pcl::UniformSampling keeps it (METHOD stages 1 and 12). \return columns of \p points in ascending order;
 * all columns when leaf is 0.
 */
std::vector<Eigen::Index>
samplePerVoxel(const Points3& points, double leaf);

} // namespace pcl_ssfr
