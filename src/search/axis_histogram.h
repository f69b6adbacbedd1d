// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/paper_options.h>

namespace pcl_ssfr {

/// A 1-D histogram along an axis: bin i covers [origin + i bin_width, origin + (i+1) bin_width).
struct AxisHistogram {
  double origin = 0;      ///< [m], an integer multiple of bin_width, so that histograms of one width align
  double bin_width = 0;   ///< [m]
  Eigen::VectorXd counts; ///< weight a bin; empty when no sample is parallel to the axis
};

/// \p bin_width [m], or the least width with which no histogram of these samples has more than \p max_bins bins.
double
boundBinWidth(double bin_width, const OrientedSamples& source, const OrientedSamples& target, Eigen::Index max_bins);

/** \brief Project the samples whose normal is parallel to \p axis on it and bin them by weight (METHOD stage 10).
 * \param[in] samples points and normals in one frame
 * \param[in] axis unit vector in that frame
 */
AxisHistogram
projectOnAxis(const OrientedSamples& samples, const Eigen::Vector3d& axis, const HistogramOptions& options);

/// Clip high bins so that one huge wall does not decide alone (METHOD stage 10).
AxisHistogram
clipHistogram(AxisHistogram histogram, const HistogramOptions& options);

/// Mean filter over 2 half_window + 1 bins (METHOD stage 13); the histogram grows by half_window bins at both ends.
AxisHistogram
smoothHistogram(const AxisHistogram& histogram, int half_window);

} // namespace pcl_ssfr
