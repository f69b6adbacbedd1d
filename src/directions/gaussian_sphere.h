// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/angles.h"
#include "common/types.h"

namespace pcl_ssfr {

/// The Gaussian image of a scan: unit directions with weights (paper, section 3.1).
struct DirectionSet {
  Points3 directions;      ///< unit vectors, 3 x N
  Eigen::VectorXd weights; ///< N, > 0

  Eigen::Index
  size() const
  {
    return directions.cols();
  }
};

/** \brief Map every sample to the point of the unit sphere that its normal points at (paper, section 3.1).
 *
 * Unoriented samples give both n and -n, so that the image is symmetric. Nothing later depends on the sign, unless
 * DensityOptions::max_queries leaves some out.
 * Samples whose normal is not finite or not of unit length (to 1e-3) are left out.
 */
DirectionSet
makeGaussianSphere(const OrientedSamples& samples);

} // namespace pcl_ssfr
