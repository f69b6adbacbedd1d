// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "preparation/thinning.h"

#include <pcl_ssfr/patch_config.h>

#include <cmath>
#include <vector>

namespace pcl_ssfr {

inline const double kHalfWidth = std::sqrt(3.0); ///< of an evenly covered interval, in standard deviations

/// A scan as planar patches, and what fits no plane.
struct PlanarPatches {
  OrientedSamples samples;           ///< centroid, normal, area and half width of each patch
  Points3 majors;                    ///< unit direction of the largest extent, 3 x N
  Eigen::VectorXd half_minors;       ///< half width across majors within the plane, N [m]
  Eigen::VectorXd thickness;         ///< standard deviation across the plane, N [m]
  std::vector<std::uint32_t> counts; ///< thinned points of the patch, N
  std::vector<std::uint32_t>
      first_point;                    ///< its points are [first_point, first_point + counts) of the thinned cloud, N
  std::vector<std::uint32_t> clutter; ///< thinned points that are in no patch

  Eigen::Index
  size() const
  {
    return samples.size();
  }
};

/// Sums over the points of a cell, from which mean and covariance follow; additive over sub-cells.
struct CellMoments {
  double n = 0;                                    ///< points
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero(); ///< sum of p p^T [m^2]
};

/// A finest cell of a thinned scan: what extractPatches() starts from.
struct FineCell {
  std::uint64_t code;  ///< Morton code at its level
  std::uint32_t first; ///< its first thinned point
  CellMoments moments;
};

/// The occupied cells of edge leaf * 2^level, ascending by code.
std::vector<FineCell>
accumulateFineCells(const ThinnedCloud& cloud, int level);

/** \brief Divide the scan into the largest octree cells that a plane fits.
 *
 * A cell is a patch when its thickness is within bounds and well under its second extent, else it is split into eight;
 * what fits in no finest cell is clutter. The normal faces the viewpoint; where that is unknown, the side that the
 * normals of the cloud agree on; without either the sign is arbitrary and samples.oriented is false.
 * \param[in] viewpoint sensor position relative to the origin of \p cloud [m], or null when it is unknown
 * \param[in] thickness bound at range zero [m], > 0
 */
PlanarPatches
extractPatches(const ThinnedCloud& cloud,
               const Eigen::Vector3d* viewpoint,
               double thickness,
               const PatchConfig& config);

/// The same from the \p cells of the cloud at level config.finest_level, for who extracts patches more than once.
PlanarPatches
extractPatches(const ThinnedCloud& cloud,
               const std::vector<FineCell>& cells,
               const Eigen::Vector3d* viewpoint,
               double thickness,
               const PatchConfig& config);

/// Some of the patches, in the order of \p indices. \throw std::out_of_range an index that is none of the patches
PlanarPatches
selectPatches(const PlanarPatches& patches, const std::vector<Eigen::Index>& indices);

} // namespace pcl_ssfr
