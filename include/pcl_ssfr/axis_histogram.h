// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/types.h>

namespace pcl_ssfr {

/// Options of the histograms along an axis (paper, section 3.5; METHOD stage 10).
struct HistogramOptions {
  enum class Facing {
    Either,  ///< |cos| > parallel_cos: both signs of the normal fall into one histogram (the paper)
    Forward, ///< cos > parallel_cos: only surfaces that face along the axis
    Backward ///< cos < -parallel_cos
  };
  enum class Clip {
    None,
    UniformMean, ///< bins above clip_factor times the mean over all bins (2017: 3)
    MeanSigma    ///< bins above the mean + clip_factor standard deviations of the bins (2019: 2)
  };
  double bin_width = 0.015;   ///< [m], > 0
  double parallel_cos = 0.99; ///< a sample counts when its normal is parallel to the axis, (0, 1]
  Facing facing = Facing::Either;
  Clip clip = Clip::UniformMean;
  double clip_factor = 3;          ///< > 0
  bool normalise = true;           ///< divide by the total weight before clipping
  Eigen::Index max_bins = 4000000; ///< bound on the memory of one histogram; wider data throw std::length_error
};

/// A 1-D histogram along an axis: bin i covers [origin + i bin_width, origin + (i+1) bin_width).
struct AxisHistogram {
  double origin = 0;        ///< [m], an integer multiple of bin_width, so that histograms of one width align
  double bin_width = 0;     ///< [m]
  Eigen::VectorXd counts;   ///< weight a bin; empty when no sample is parallel to the axis
  Eigen::Index samples = 0; ///< how many samples fell in
};

/// \p bin_width [m], or the least width with which no histogram of these samples has more than \p max_bins bins.
double
boundBinWidth(double bin_width, const OrientedSamples& source, const OrientedSamples& target, Eigen::Index max_bins);

/** \brief Project the samples whose normal is parallel to \p axis on it and bin them by weight (METHOD stage 10).
 * \param[in] samples points and normals in one frame \param[in] axis unit vector in that frame
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
