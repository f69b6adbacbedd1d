// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "fast_global_pose.h"

#include <Eigen/Core>

#include <vector>

// PCL's FPFH descriptors, and matches by them.
namespace pcl_ssfr::baselines {

/// Descriptors of those points that have one.
struct FpfhFeatures {
  std::vector<Eigen::Index> columns;             ///< of the points described, ascending, M
  Eigen::Matrix<float, 33, Eigen::Dynamic> bins; ///< three histograms of 11 bins, each with sum 100, 33 x M
};

/** \brief FPFH of all \p points (3 x N, finite [m]) that have a normal and a neighbour.
 * \param[in] viewpoint the normals are oriented towards it
 * \param[in] normal_radius,feature_radius neighbourhoods of the normals and of the descriptors [m], > 0
 */
FpfhFeatures
computeFpfh(const Points3& points,
            const Eigen::Vector3d& viewpoint,
            double normal_radius,
            double feature_radius,
            unsigned threads);

/** \brief Pairs of points of which each has the other's descriptor as its nearest (K_II of Fast Global Registration),
 * in ascending order of the source. Ties go as the search tree has them; independent of \p threads.
 */
std::vector<PointMatch>
matchReciprocally(const FpfhFeatures& source, const FpfhFeatures& target, unsigned threads);

} // namespace pcl_ssfr::baselines
