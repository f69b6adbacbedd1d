// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/axis_histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace pcl_ssfr {

namespace {

bool
faces(double cosine, const HistogramOptions& options)
{
  switch (options.facing) {
  case HistogramOptions::Facing::Either:
    return std::abs(cosine) > options.parallel_cos;
  case HistogramOptions::Facing::Forward:
    return cosine > options.parallel_cos;
  case HistogramOptions::Facing::Backward:
    return cosine < -options.parallel_cos;
  }
  return false;
}

/// Largest distance of a sample from the origin [m].
double
reachOf(const OrientedSamples& samples)
{
  return samples.size() > 0 ? samples.points.colwise().norm().maxCoeff() : 0;
}

} // namespace

double
boundBinWidth(double bin_width, const OrientedSamples& source, const OrientedSamples& target, Eigen::Index max_bins)
{
  // From end to end, and a bin for what is left over at each of them.
  const double bins = static_cast<double>(std::max<Eigen::Index>(max_bins - 2, 1));
  return std::max(bin_width, 2 * std::max(reachOf(source), reachOf(target)) / bins);
}

AxisHistogram
projectOnAxis(const OrientedSamples& samples, const Eigen::Vector3d& axis, const HistogramOptions& options)
{
  AxisHistogram histogram;
  histogram.bin_width = options.bin_width;
  std::vector<std::pair<double, double>> projected; // bin number (integral, double to be safe of overflow), weight
  double first = std::numeric_limits<double>::infinity(), last = -first, total = 0;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    if (!faces(axis.dot(samples.normals.col(i)), options))
      continue;
    const double bin = std::floor(axis.dot(samples.points.col(i)) / options.bin_width);
    if (!std::isfinite(bin))
      continue;
    first = std::min(first, bin);
    last = std::max(last, bin);
    total += samples.weights[i];
    projected.emplace_back(bin, samples.weights[i]);
  }
  if (projected.empty())
    return histogram;
  if (last - first >= static_cast<double>(options.max_bins))
    throw std::length_error("histogram along an axis: more than max_bins bins");
  histogram.origin = first * options.bin_width;
  histogram.counts = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(last - first) + 1);
  for (const auto& [bin, weight] : projected)
    histogram.counts[static_cast<Eigen::Index>(bin - first)] += weight;
  if (options.normalise && total > 0)
    histogram.counts /= total;
  return histogram;
}

AxisHistogram
clipHistogram(AxisHistogram histogram, const HistogramOptions& options)
{
  if (histogram.counts.size() == 0 || options.clip == HistogramOptions::Clip::None)
    return histogram;
  const double mean = histogram.counts.mean();
  double limit = options.clip_factor * mean;
  if (options.clip == HistogramOptions::Clip::MeanSigma)
    limit = mean + options.clip_factor * std::sqrt((histogram.counts.array() - mean).square().mean());
  histogram.counts = histogram.counts.cwiseMin(limit);
  return histogram;
}

AxisHistogram
smoothHistogram(const AxisHistogram& histogram, int half_window)
{
  if (half_window <= 0 || histogram.counts.size() == 0)
    return histogram;
  const Eigen::Index half = half_window, size = histogram.counts.size();
  AxisHistogram smooth = histogram;
  smooth.origin = (std::round(histogram.origin / histogram.bin_width) - half_window) * histogram.bin_width;
  smooth.counts.resize(size + 2 * half);
  // Differences of prefix sums: the cost does not depend on the window.
  Eigen::VectorXd prefix(size + 1);
  prefix[0] = 0;
  for (Eigen::Index i = 0; i < size; ++i)
    prefix[i + 1] = prefix[i] + histogram.counts[i];
  for (Eigen::Index i = 0; i < smooth.counts.size(); ++i) {
    const Eigen::Index begin = std::max<Eigen::Index>(i - 2 * half, 0), end = std::min(i + 1, size);
    smooth.counts[i] = (prefix[end] - prefix[begin]) / static_cast<double>(2 * half + 1);
  }
  return smooth;
}

} // namespace pcl_ssfr
