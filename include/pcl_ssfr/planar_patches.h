// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/thinning.h>
#include <pcl_ssfr/types.h>

#include <vector>

namespace pcl_ssfr {

/// Options of the planar patches (METHOD point 12). Lengths of 0 follow from the data.
struct PatchOptions {
  double thickness = 0;       ///< largest standard deviation across the plane [m]; 0: from the scale of the scene
  double range_noise = 0.001; ///< growth of the thickness with range [m/m], >= 0
  double max_flatness = 0.3;  ///< thickness over the second extent (both standard deviations), (0, 1)
  int finest_level = 3;       ///< finest cells have an edge of leaf * 2^finest_level, [0, 20)
  int coarsest_level = 6;     ///< coarsest cells have an edge of leaf * 2^coarsest_level, [finest_level, 20)
  int min_points = 5;         ///< fewest thinned points of a patch, >= 3
};

constexpr double kHalfWidth = 1.7320508075688772; ///< of an evenly covered interval, in standard deviations

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
 * \param[in] thickness bound at range zero [m], > 0 (PatchOptions::thickness is not read here)
 */
PlanarPatches
extractPatches(const ThinnedCloud& cloud,
               const Eigen::Vector3d* viewpoint,
               double thickness,
               const PatchOptions& options);

/// The same from the \p cells of the cloud at level options.finest_level, for who extracts patches more than once.
PlanarPatches
extractPatches(const ThinnedCloud& cloud,
               const std::vector<FineCell>& cells,
               const Eigen::Vector3d* viewpoint,
               double thickness,
               const PatchOptions& options);

/// Some of the patches, in the order of \p indices. \throw std::out_of_range an index that is none of the patches
PlanarPatches
selectPatches(const PlanarPatches& patches, const std::vector<Eigen::Index>& indices);

} // namespace pcl_ssfr
