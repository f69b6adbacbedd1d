// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "directions/gaussian_sphere.h"

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/paper_options.h>

#include <vector>

namespace pcl_ssfr {

/// One of the densest regions: the neighbours of a density peak within r_d.
struct DenseRegion {
  Eigen::Vector3d peak;              ///< the direction of highest density
  double weight = 0;                 ///< total weight of the region (before max_region_points)
  std::vector<Eigen::Index> members; ///< columns of the DirectionSet
};

/** \brief Density of the Gaussian image at each of its points: the kernel-weighted sum of neighbour weights within r_d.
 *
 * The point itself counts. Costs O(N log N) plus the neighbours for any N. With max_queries, only so many points are
 * asked, each against all others, and the cost stays linear; the rest get a density of 0. The stride is odd, so that
 * both ways of an unoriented normal have their turn. \p threads only changes the speed.
 * What it gives when \p deadline passes meanwhile is unspecified.
 */
Eigen::VectorXd
computeDensity(const DirectionSet& directions,
               const DensityOptions& options,
               unsigned threads = 1,
               const Deadline& deadline = Deadline());

/** \brief The densest regions in descending density: take the densest direction, keep its neighbours within r_d,
 * silence what lies within silence_chord of it, repeat (paper, section 3.2).
 *
 * Ties go to the smaller column.
 * \param[in] density one value a direction, as computeDensity gives it; what has none is no peak.
 * \return at most max_regions regions; empty for an empty set.
 */
std::vector<DenseRegion>
findDensestRegions(const DirectionSet& directions, const Eigen::VectorXd& density, const DensityOptions& options);

} // namespace pcl_ssfr
