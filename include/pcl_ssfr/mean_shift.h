// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/density_filter.h>

#include <vector>

namespace pcl_ssfr {

/// Options of the mean shift on the Gaussian sphere (paper, section 3.3; METHOD stage 5).
struct MeanShiftOptions {
  double bandwidth = 0.1;   ///< chord on the unit sphere, (0, 2]
  double tolerance = 1e-7;  ///< stop when the shift is shorter, chord, > 0
  int max_iterations = 200; ///< per region, >= 1
  double merge_chord = 0.5; ///< modes closer than this are one (the heavier stays), chord [0, 2)
};

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
