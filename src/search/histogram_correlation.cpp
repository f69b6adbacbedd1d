// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/histogram_correlation.h"

#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr {

namespace {

/// Cost of a random access, and of one step of a Fourier transform, in multiplications of dense arrays: they choose the
/// way, never the result beyond rounding.
constexpr double kSparseCost = 3;
constexpr double kFourierCost = 40;
/// Correlations below this share of the largest possible value are rounding of the transform.
constexpr double kFourierNoise = 1e-14;

/// The bins that are not zero.
struct SparseBins {
  std::vector<Eigen::Index> bins;
  std::vector<double> values;
};

SparseBins
findNonZero(const Eigen::VectorXd& counts)
{
  SparseBins sparse;
  for (Eigen::Index i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0)
      continue;
    sparse.bins.push_back(i);
    sparse.values.push_back(counts[i]);
  }
  return sparse;
}

/// values[k] += sum over x of source[x] target[x + first + k], through the pairs of non-zero bins.
void
correlateSparse(const SparseBins& source, const SparseBins& target, Eigen::Index first, Eigen::VectorXd& values)
{
  for (std::size_t i = 0; i < source.bins.size(); ++i) {
    const Eigen::Index lowest = source.bins[i] + first;
    auto j = static_cast<std::size_t>(std::lower_bound(target.bins.begin(), target.bins.end(), lowest) -
                                      target.bins.begin());
    for (; j < target.bins.size() && target.bins[j] - lowest < values.size(); ++j)
      values[target.bins[j] - lowest] += source.values[i] * target.values[j];
  }
}

/// The same, every non-zero bin of the source against the whole target.
void
correlateSourceBins(const SparseBins& source,
                    const Eigen::VectorXd& target,
                    Eigen::Index first,
                    Eigen::VectorXd& values)
{
  for (std::size_t i = 0; i < source.bins.size(); ++i) {
    const Eigen::Index lowest = source.bins[i] + first;
    const Eigen::Index begin = std::max<Eigen::Index>(-lowest, 0);
    const Eigen::Index end = std::min(values.size(), target.size() - lowest);
    if (end > begin)
      values.segment(begin, end - begin) += source.values[i] * target.segment(lowest + begin, end - begin);
  }
}

/// The same through the Fourier transform, over all shifts, from which the range is cut.
void
correlateFourier(const Eigen::VectorXd& source,
                 const Eigen::VectorXd& target,
                 Eigen::Index first,
                 Eigen::VectorXd& values)
{
  Eigen::Index size = 1;
  while (size < source.size() + target.size())
    size *= 2;
  Eigen::FFT<double> transform(Eigen::FFT<double>::impl_type(), Eigen::FFT<double>::HalfSpectrum);
  std::vector<double> padded_source(static_cast<std::size_t>(size), 0), padded_target(padded_source), product;
  // Reversed, so that the convolution is a correlation: shift s falls on s + source.size() - 1.
  std::reverse_copy(source.data(), source.data() + source.size(), padded_source.begin());
  std::copy(target.data(), target.data() + target.size(), padded_target.begin());
  std::vector<std::complex<double>> source_spectrum, target_spectrum;
  transform.fwd(source_spectrum, padded_source);
  transform.fwd(target_spectrum, padded_target);
  for (std::size_t i = 0; i < source_spectrum.size(); ++i)
    source_spectrum[i] *= target_spectrum[i];
  transform.inv(product, source_spectrum, size);
  const double noise = kFourierNoise * source.norm() * target.norm();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double value = product[static_cast<std::size_t>(first + k + source.size() - 1)];
    values[k] = value > noise ? value : 0; // counts are never negative, nor is their correlation
  }
}

} // namespace

Correlation
correlate(const AxisHistogram& source, const AxisHistogram& target, double centre, double half_range)
{
  if (source.bin_width != target.bin_width)
    throw std::invalid_argument("correlate: histograms of different bin width");
  Correlation correlation;
  correlation.bin_width = source.bin_width;
  if (source.counts.size() == 0 || target.counts.size() == 0)
    return correlation;

  // All in bins: shift s lays source bin x on target bin x + s - offset.
  const double width = source.bin_width;
  const double offset = std::round(target.origin / width) - std::round(source.origin / width);
  double first = offset - static_cast<double>(source.counts.size() - 1);
  double last = offset + static_cast<double>(target.counts.size() - 1);
  if (half_range >= 0) {
    first = std::max(first, std::ceil((centre - half_range) / width - 1e-9));
    last = std::min(last, std::floor((centre + half_range) / width + 1e-9));
  }
  if (first > last)
    return correlation;
  correlation.first_shift = first * width;
  correlation.values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(last - first) + 1);

  const auto first_lag = static_cast<Eigen::Index>(first - offset);
  const SparseBins source_bins = findNonZero(source.counts), target_bins = findNonZero(target.counts);
  const double shifts = static_cast<double>(correlation.values.size());
  const double all_shifts = static_cast<double>(source.counts.size() + target.counts.size());
  const double source_size = static_cast<double>(source_bins.bins.size());
  const double target_size = static_cast<double>(target_bins.bins.size());
  const double sparse_cost =
      kSparseCost * (source_size * target_size * std::min(1.0, shifts / all_shifts) + source_size);
  const double source_cost = source_size * shifts;
  const double target_cost = target_size * shifts;
  const double fourier_cost = kFourierCost * all_shifts * std::log2(all_shifts);
  const double cheapest = std::min({sparse_cost, source_cost, target_cost, fourier_cost});
  if (cheapest == sparse_cost) {
    correlateSparse(source_bins, target_bins, first_lag, correlation.values);
  }
  else if (cheapest == source_cost) {
    correlateSourceBins(source_bins, target.counts, first_lag, correlation.values);
  }
  else if (cheapest == target_cost) {
    // c(s) = sum_y target(y) source(y - s): the roles change and the shifts run backwards.
    const Eigen::Index last_lag = first_lag + correlation.values.size() - 1;
    correlateSourceBins(target_bins, source.counts, -last_lag, correlation.values);
    correlation.values.reverseInPlace();
  }
  else {
    correlateFourier(source.counts, target.counts, first_lag, correlation.values);
  }
  return correlation;
}

Correlation
subtractMedianEnvelope(const Correlation& correlation, int half_window)
{
  Correlation result = correlation;
  const Eigen::Index size = correlation.values.size();
  if (half_window <= 0 || size == 0)
    return result;
  const Eigen::Index half = half_window;
  const auto value = [&](Eigen::Index i) { return i >= 0 && i < size ? correlation.values[i] : 0; };
  std::vector<double> window; // sorted values of the shifts i - half .. i + half
  for (Eigen::Index i = -half - 1; i < half; ++i)
    window.push_back(value(i));
  std::sort(window.begin(), window.end());
  for (Eigen::Index i = 0; i < size; ++i) {
    window.erase(std::lower_bound(window.begin(), window.end(), value(i - half - 1)));
    const double entering = value(i + half);
    window.insert(std::upper_bound(window.begin(), window.end(), entering), entering);
    result.values[i] -= window[static_cast<std::size_t>(half)];
  }
  return result;
}

std::vector<ShiftPeak>
findPeaks(const Correlation& correlation, const CorrelationOptions& options)
{
  const Correlation flat = subtractMedianEnvelope(correlation, options.envelope_half_window);
  const Eigen::VectorXd& values = flat.values;
  std::vector<Eigen::Index> maxima;
  double before = -std::numeric_limits<double>::infinity(); // the last value that differs from the one at hand
  for (Eigen::Index i = 0; i < values.size();) {
    Eigen::Index end = i + 1; // of the plateau
    while (end < values.size() && values[end] == values[i])
      ++end;
    if (values[i] > 0 && values[i] > before && (end == values.size() || values[end] < values[i]))
      maxima.push_back(i);
    before = values[i];
    i = end;
  }
  std::stable_sort(maxima.begin(), maxima.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });

  std::vector<ShiftPeak> peaks;
  std::vector<Eigen::Index> taken;
  for (const Eigen::Index i : maxima) {
    if (static_cast<int>(peaks.size()) >= options.max_peaks)
      break;
    const bool near = std::any_of(taken.begin(), taken.end(), [&](Eigen::Index other) {
      return static_cast<double>(std::abs(other - i)) * flat.bin_width < options.min_separation;
    });
    if (near)
      continue;
    taken.push_back(i);
    ShiftPeak peak{flat.shift(i)};
    if (options.sub_bin && i > 0 && i + 1 < values.size()) {
      const double left = values[i - 1], right = values[i + 1];
      const double curvature = 2 * values[i] - left - right;
      if (curvature > 0)
        peak.shift += std::clamp((right - left) / (2 * curvature), -0.5, 0.5) * flat.bin_width;
    }
    peaks.push_back(peak);
  }
  return peaks;
}

} // namespace pcl_ssfr
