// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/types.h>

#include <vector>

namespace pcl_ssfr {

/// Options of the planar patches. Lengths of 0 follow from the data.
struct PatchOptions {
  double cell = 0;            ///< edge of the coarsest cells [m]; 0: from the data
  double thickness = 0;       ///< largest standard deviation across the plane [m]; 0: from the data
  double range_noise = 0.001; ///< growth of the thickness with range [m/m], >= 0
  int levels = 4;             ///< cells are halved at most levels - 1 times, >= 1
  int min_points = 5;         ///< fewest thinned points of a patch, >= 3
};

} // namespace pcl_ssfr
