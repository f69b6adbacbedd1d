// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/gaussian_sphere.h>

#include <vector>

namespace pcl_ssfr {

/// Options of the density filter on the Gaussian sphere (paper, section 3.2; METHOD stages 3 and 4).
struct DensityOptions {
  enum class Kernel {
    Count,   ///< weight of the neighbours within \ref radius (implementation of 2017)
    Gaussian ///< weight times exp(-d^2 / (radius/2)^2) (implementation of 2019)
  };
  double radius = 0.06;                ///< r_d, chord on the unit sphere, (0, 1]
  Kernel kernel = Kernel::Count;       ///< how a neighbour counts
  int max_regions = 6;                 ///< number of densest regions to take, >= 1
  double silence_chord = 0.3;          ///< directions this near to a taken peak are no further peaks, chord (0, 2]
  double min_relative_density = 0;     ///< stop at peaks below this share of the densest one, [0, 1]
  bool reject_elongated = false;       ///< drop regions that curved surfaces leave (implementation of 2019)
  double max_elongation = 3;           ///< ratio of the two largest covariance eigenvalues that counts as elongated
  double max_elongated_chord = 0.1743; ///< spread 2 sqrt(l1) beyond which an elongated region is dropped, chord
  int max_region_points = 3000;        ///< at most so many (evenly strided) directions are kept in a region, >= 1
  int max_queries = 0;                 ///< at most so many (evenly strided) directions may be peaks, >= 0; 0: all
};

/// One of the densest regions: the neighbours of a density peak within r_d.
struct DenseRegion {
  Eigen::Vector3d peak;              ///< the direction of highest density
  double density = 0;                ///< density at the peak
  double weight = 0;                 ///< total weight of the region (before max_region_points)
  std::vector<Eigen::Index> members; ///< columns of the DirectionSet
};

/** \brief Density of the Gaussian image at each of its points: the kernel-weighted sum of neighbour weights within r_d.
 *
 * The point itself counts. Costs O(N log N) plus the neighbours for any N. With max_queries, only so many points are
 * asked, each against all others, and the cost stays linear; the rest get a density of 0. The stride is odd, so that
 * both ways of an unoriented normal have their turn. \p threads only changes the speed.
 * What it gives when \p deadline passes meanwhile is of no use.
 */
Eigen::VectorXd
computeDensity(const DirectionSet& directions,
               const DensityOptions& options,
               unsigned threads = 1,
               const Deadline& deadline = Deadline());

/** \brief The densest regions in descending density: take the densest direction, keep its neighbours within r_d,
 * silence what lies within silence_chord of it, repeat (paper, section 3.2).
 *
 * Ties go to the smaller column. \param[in] density one value a direction, as computeDensity gives it; what has none
 * is no peak.
 * \return at most max_regions regions; empty for an empty set.
 */
std::vector<DenseRegion>
findDensestRegions(const DirectionSet& directions, const Eigen::VectorXd& density, const DensityOptions& options);

} // namespace pcl_ssfr
