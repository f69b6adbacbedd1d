// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "processor_time.h"
#include "search/histogram_correlation.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pcl_ssfr::test_histogram_correlation {
namespace {

AxisHistogram
makeHistogram(double origin, double bin_width, const Eigen::VectorXd& counts)
{
  AxisHistogram histogram;
  histogram.origin = origin;
  histogram.bin_width = bin_width;
  histogram.counts = counts;
  return histogram;
}

/// Random counts of which a \p fill share is not zero.
AxisHistogram
makeRandom(Eigen::Index size, double fill, long first_bin, double bin_width, std::uint64_t seed)
{
  testing::Random random(seed);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(size);
  for (double& count : counts)
    if (random.uniform(0, 1) < fill)
      count = random.uniform(0, 1);
  return makeHistogram(static_cast<double>(first_bin) * bin_width, bin_width, counts);
}

/// c(s) by its definition, every bin against every bin, s in bins.
double
bruteForce(const AxisHistogram& source, const AxisHistogram& target, long shift)
{
  const long offset = std::lround(target.origin / target.bin_width) - std::lround(source.origin / source.bin_width);
  double sum = 0;
  for (Eigen::Index i = 0; i < source.counts.size(); ++i) {
    const Eigen::Index j = i + shift - offset;
    if (j >= 0 && j < target.counts.size())
      sum += source.counts[i] * target.counts[j];
  }
  return sum;
}

void
expectBruteForce(const AxisHistogram& source, const AxisHistogram& target, const Correlation& correlation)
{
  const double scale = source.counts.norm() * target.counts.norm();
  for (Eigen::Index i = 0; i < correlation.values.size(); ++i) {
    const long shift = std::lround(correlation.shift(i) / correlation.bin_width);
    ASSERT_NEAR(correlation.values[i], bruteForce(source, target, shift), 1e-12 * scale) << shift;
  }
}

TEST(HistogramCorrelation, ByHand)
{
  // Planes at 0 and 0.3 in the source lie at 0.5 and 0.8 in the target: shift 0.5.
  const AxisHistogram source = makeHistogram(0, 0.1, Eigen::Vector4d(2, 0, 0, 1));
  const AxisHistogram target = makeHistogram(0.5, 0.1, Eigen::Vector4d(2, 0, 0, 1));
  const Correlation correlation = correlate(source, target);
  EXPECT_EQ(correlation.values.size(), 7);
  EXPECT_NEAR(correlation.first_shift, 0.2, 1e-12);
  CorrelationOptions options;
  options.envelope_half_window = 0;
  const std::vector<ShiftPeak> peaks = findPeaks(correlation, options);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_NEAR(peaks[0].shift, 0.5, 1e-12);
  EXPECT_NEAR(correlation.values.maxCoeff(), 5, 1e-12);
}

TEST(HistogramCorrelation, EveryWayAgreesWithTheDefinition)
{
  // Sparse and dense, short and long: the sizes reach every way of computing, the Fourier transform included.
  struct Case {
    Eigen::Index source, target;
    double source_fill, target_fill;
  };
  for (const Case& c : {Case{1, 1, 1, 1},
                        Case{40, 7, 1, 1},
                        Case{500, 300, 0.02, 0.9},
                        Case{500, 300, 0.9, 0.02},
                        Case{400, 400, 0.05, 0.05},
                        Case{2500, 1700, 0.9, 0.9}}) {
    const AxisHistogram source = makeRandom(c.source, c.source_fill, -37, 0.01, 1);
    const AxisHistogram target = makeRandom(c.target, c.target_fill, 112, 0.01, 2);
    const Correlation correlation = correlate(source, target);
    EXPECT_EQ(correlation.values.size(), c.source + c.target - 1);
    expectBruteForce(source, target, correlation);
    EXPECT_GE(correlation.values.minCoeff(), 0);
  }
}

TEST(HistogramCorrelation, RestrictedRangeIsACutOfTheWhole)
{
  for (const double fill : {0.03, 1.0}) {
    const AxisHistogram source = makeRandom(900, fill, 20, 0.01, 3);
    const AxisHistogram target = makeRandom(1100, 1, -300, 0.01, 4);
    for (const double centre : {-3.2, -1.0, 0.7, 6.0}) {
      const Correlation part = correlate(source, target, centre, 0.155);
      ASSERT_EQ(part.values.size(), 31) << centre;
      EXPECT_NEAR(part.first_shift, centre - 0.15, 1e-9);
      expectBruteForce(source, target, part);
      expectBruteForce(target, source, correlate(target, source, -centre, 0.155));
    }
    EXPECT_EQ(correlate(source, target, 1e6, 0.1).values.size(), 0); // out of reach
  }
}

TEST(HistogramCorrelation, SwappingReversesTheShifts)
{
  const AxisHistogram a = makeRandom(300, 0.3, 5, 0.02, 5), b = makeRandom(200, 0.5, -40, 0.02, 6);
  const Correlation ab = correlate(a, b), ba = correlate(b, a);
  ASSERT_EQ(ab.values.size(), ba.values.size());
  EXPECT_NEAR(ab.first_shift, -ba.shift(ba.values.size() - 1), 1e-12);
  EXPECT_LT((ab.values - ba.values.reverse()).norm(), 1e-12 * ab.values.norm());
}

TEST(HistogramCorrelation, FineBinsOfANarrowRangeAreFast)
{
  // The fine pass: 200,000 bins of 0.15 mm, shifts within 300 bins.
  const AxisHistogram source = makeRandom(200000, 0.9, 0, 0.00015, 7), target = makeRandom(200000, 0.9, 0, 0.00015, 8);
  const AxisHistogram less = makeRandom(3125, 0.9, 0, 0.00015, 7), fewer = makeRandom(3125, 0.9, 0, 0.00015, 8);
  Correlation narrow, whole;
  const double seconds = testing::processorSeconds([&] {
    narrow = correlate(source, target, 0.0015, 0.0225);
    whole = correlate(source, target);
  });
  const double of_small = testing::processorSeconds([&] {
    correlate(less, fewer, 0.0015, 0.0225);
    correlate(less, fewer);
  });
  EXPECT_EQ(narrow.values.size(), 301);
  EXPECT_NEAR(narrow.values[10], bruteForce(source, target, std::lround(narrow.shift(10) / 0.00015)), 1e-6);
  EXPECT_EQ(whole.values.size(), 399999);
  EXPECT_LT(seconds, 1500 * of_small); // 64 times the bins: 4096 when every bin meets every bin
}

TEST(HistogramCorrelation, RefusesDifferentBins)
{
  const AxisHistogram a = makeRandom(3, 1, 0, 0.1, 9), b = makeRandom(3, 1, 0, 0.2, 10);
  EXPECT_THROW(correlate(a, b), std::invalid_argument);
}

TEST(HistogramCorrelation, EmptyIn)
{
  const AxisHistogram empty = makeHistogram(0, 0.1, Eigen::VectorXd());
  const AxisHistogram full = makeRandom(5, 1, 0, 0.1, 11);
  for (const Correlation& correlation : {correlate(empty, full), correlate(full, empty), correlate(empty, empty)}) {
    EXPECT_EQ(correlation.values.size(), 0);
    EXPECT_TRUE(findPeaks(correlation, CorrelationOptions()).empty());
    EXPECT_EQ(subtractMedianEnvelope(correlation, 5).values.size(), 0);
  }
  // Histograms that are all zero meet nowhere: no peak.
  const AxisHistogram zero = makeHistogram(0, 0.1, Eigen::VectorXd::Zero(5));
  EXPECT_TRUE(findPeaks(correlate(zero, full), CorrelationOptions()).empty());
}

TEST(MedianEnvelope, AgreesWithSortingEveryWindow)
{
  testing::Random random(12);
  for (const Eigen::Index size : {1, 2, 9, 20, 21, 200}) {
    Correlation correlation;
    correlation.bin_width = 0.1;
    correlation.values.resize(size);
    for (double& value : correlation.values)
      value = std::floor(random.uniform(0, 20)); // with ties
    for (const int half : {1, 4, 10}) {
      const Correlation flat = subtractMedianEnvelope(correlation, half);
      for (Eigen::Index i = 0; i < size; ++i) {
        std::vector<double> window;
        for (Eigen::Index k = i - half; k <= i + half; ++k)
          window.push_back(k >= 0 && k < size ? correlation.values[k] : 0);
        std::sort(window.begin(), window.end());
        const double median = window[static_cast<std::size_t>(half)];
        ASSERT_EQ(flat.values[i], correlation.values[i] - median) << size << ' ' << half << ' ' << i;
      }
    }
  }
}

TEST(MedianEnvelope, KeepsTheOnlyPeakOfTwoThinPlanes)
{
  const AxisHistogram floor = makeHistogram(-1.5, 0.01, Eigen::VectorXd::Ones(1));
  const AxisHistogram moved = makeHistogram(-1.2, 0.01, Eigen::VectorXd::Ones(1));
  const std::vector<ShiftPeak> peaks = findPeaks(correlate(floor, moved), CorrelationOptions());
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_NEAR(peaks[0].shift, 0.3, 1e-12);
}

TEST(MedianEnvelope, BringsOutASharpPeakOnABroadHill)
{
  Correlation correlation;
  correlation.bin_width = 0.01;
  correlation.values.resize(400);
  for (Eigen::Index i = 0; i < 400; ++i)
    correlation.values[i] = 100 * std::exp(-std::pow(static_cast<double>(i - 250) / 80, 2));
  correlation.values[120] += 30;
  CorrelationOptions options;
  options.envelope_half_window = 0;
  EXPECT_NEAR(findPeaks(correlation, options).at(0).shift, 2.5, 1e-9);
  options.envelope_half_window = 10;
  EXPECT_NEAR(findPeaks(correlation, options).at(0).shift, 1.2, 1e-9);
}

TEST(CorrelationPeaks, InOrderApartAndTiesToTheSmallerShift)
{
  Correlation correlation;
  correlation.first_shift = -1;
  correlation.bin_width = 0.1;
  correlation.values.resize(11);
  correlation.values << 3, 1, 5, 5, 0, 2, 1.5, 5, 4, 4.5, 0;
  CorrelationOptions options;
  options.envelope_half_window = 0;
  options.max_peaks = 10;
  std::vector<ShiftPeak> peaks = findPeaks(correlation, options);
  ASSERT_EQ(peaks.size(), 5U); // bins 2 (plateau), 7, 9, 0, 5
  EXPECT_NEAR(peaks[0].shift, -0.8, 1e-12);
  EXPECT_NEAR(peaks[1].shift, -0.3, 1e-12);
  EXPECT_NEAR(peaks[2].shift, -0.1, 1e-12);
  EXPECT_NEAR(peaks[3].shift, -1.0, 1e-12);
  EXPECT_NEAR(peaks[4].shift, -0.5, 1e-12);
  options.min_separation = 0.25;
  peaks = findPeaks(correlation, options);
  ASSERT_EQ(peaks.size(), 2U); // 9 and 5 lie next to 7, 0 next to 2
  options.max_peaks = 1;
  EXPECT_EQ(findPeaks(correlation, options).size(), 1U);
}

TEST(CorrelationPeaks, ParabolaFindsTheTopBetweenBins)
{
  Correlation correlation;
  correlation.bin_width = 0.1;
  correlation.values.resize(9);
  const double top = 4.3; // in bins
  for (Eigen::Index i = 0; i < 9; ++i)
    correlation.values[i] = 50 - std::pow(static_cast<double>(i) - top, 2);
  CorrelationOptions options;
  options.envelope_half_window = 0;
  EXPECT_NEAR(findPeaks(correlation, options).at(0).shift, 0.4, 1e-12);
  options.sub_bin = true;
  EXPECT_NEAR(findPeaks(correlation, options).at(0).shift, 0.43, 1e-9);
}

} // namespace
} // namespace pcl_ssfr::test_histogram_correlation
