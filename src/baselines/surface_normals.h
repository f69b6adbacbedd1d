// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Core>

namespace pcl_ssfr::baselines {

/** \brief Normals of \p points (3 x N, finite [m]) by PCL, from all points within \p radius [m], > 0, oriented towards
 * \p viewpoint. Unit, 3 x N; zero where a point has too few neighbours. Independent of \p threads.
 */
Points3
estimateSurfaceNormals(const Points3& points, const Eigen::Vector3d& viewpoint, double radius, unsigned threads);

} // namespace pcl_ssfr::baselines
