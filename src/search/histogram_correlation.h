// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "search/axis_histogram.h"

#include <pcl_ssfr/paper_options.h>

#include <vector>

namespace pcl_ssfr {

/// Cross-correlation of two histograms over all shifts: value(i) belongs to shift(i).
struct Correlation {
  double first_shift = 0; ///< [m], an integer multiple of bin_width
  double bin_width = 0;   ///< [m]
  Eigen::VectorXd values; ///< empty when either histogram is

  double
  shift(Eigen::Index i) const
  {
    return first_shift + static_cast<double>(i) * bin_width;
  }
};

/// A maximum of the correlation: moving the source by \ref shift along the axis lays its planes on the target's.
struct ShiftPeak {
  double shift = 0; ///< [m]
};

/** \brief Cross-correlation c(s) = sum_x target(x) source(x - s) for every shift s at which they can meet.
 * Both histograms must have the same bin width (std::invalid_argument otherwise).
 * \param[in] centre, half_range restrict the shifts to [centre - half_range, centre + half_range] [m]; a negative
 * half_range means all.
 */
Correlation
correlate(const AxisHistogram& source, const AxisHistogram& target, double centre = 0, double half_range = -1);

/** \brief Subtract the running median over 2 half_window + 1 shifts (implementation of 2017). Shifts beyond the ends
 * count as 0, for no bins meet there: the single peak of two thin planes stays.
 */
Correlation
subtractMedianEnvelope(const Correlation& correlation, int half_window);

/** \brief The highest peaks in descending value; local maxima only, ties to the smaller shift. Empty correlation: none.
 */
std::vector<ShiftPeak>
findPeaks(const Correlation& correlation, const CorrelationOptions& options);

} // namespace pcl_ssfr
