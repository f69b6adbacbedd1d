// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/axis_histogram.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace pcl_ssfr::test_axis_histogram {
namespace {

OrientedSamples
makeSamples(Eigen::Index count)
{
  OrientedSamples samples;
  samples.points = Points3::Zero(3, count);
  samples.normals = Points3::Zero(3, count);
  samples.weights = Eigen::VectorXd::Ones(count);
  samples.extents = Eigen::VectorXd::Zero(count);
  return samples;
}

HistogramOptions
plainOptions(double bin_width)
{
  HistogramOptions options;
  options.bin_width = bin_width;
  options.normalise = false;
  options.clip = HistogramOptions::Clip::None;
  return options;
}

TEST(AxisHistogram, ByHand)
{
  OrientedSamples samples = makeSamples(5);
  samples.points.row(0) << -0.05, 0.01, 0.09, 0.25, 9;
  samples.normals.row(0) << 1, 1, -1, 1, 0;
  samples.normals(1, 4) = 1; // faces y: no business on this axis
  samples.weights << 2, 3, 4, 5, 100;
  const AxisHistogram histogram = projectOnAxis(samples, Eigen::Vector3d::UnitX(), plainOptions(0.1));
  EXPECT_NEAR(histogram.origin, -0.1, 1e-15);
  ASSERT_EQ(histogram.counts.size(), 4);
  EXPECT_EQ(histogram.counts, Eigen::Vector4d(2, 7, 0, 5));
}

TEST(AxisHistogram, FacingSelectsTheSign)
{
  OrientedSamples samples = makeSamples(2);
  samples.points.row(2) << 0.05, 0.35;
  samples.normals.row(2) << 1, -1;
  HistogramOptions options = plainOptions(0.1);
  options.facing = HistogramOptions::Facing::Forward;
  EXPECT_NEAR(projectOnAxis(samples, Eigen::Vector3d::UnitZ(), options).origin, 0, 1e-15);
  options.facing = HistogramOptions::Facing::Backward;
  const AxisHistogram backward = projectOnAxis(samples, Eigen::Vector3d::UnitZ(), options);
  EXPECT_NEAR(backward.origin, 0.3, 1e-15);
  EXPECT_EQ(backward.counts.size(), 1);
  options.facing = HistogramOptions::Facing::Either;
  EXPECT_EQ(projectOnAxis(samples, Eigen::Vector3d::UnitZ(), options).counts.sum(), 2);
}

TEST(AxisHistogram, AgreesWithAMapOfBins)
{
  testing::Random random(1);
  OrientedSamples samples = makeSamples(3000);
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    samples.points.col(i) = 5 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    samples.normals.col(i) = testing::randomRotation(random).col(0);
    samples.weights[i] = random.uniform(0.1, 2);
  }
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  HistogramOptions options = plainOptions(0.07);
  options.parallel_cos = 0.8;
  std::map<long, double> expected;
  double total = 0;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    if (std::abs(axis.dot(samples.normals.col(i))) <= 0.8)
      continue;
    expected[std::lround(std::floor(axis.dot(samples.points.col(i)) / 0.07))] += samples.weights[i];
    total += samples.weights[i];
  }
  for (const bool normalise : {false, true}) {
    options.normalise = normalise;
    const AxisHistogram histogram = projectOnAxis(samples, axis, options);
    const long first = std::lround(histogram.origin / 0.07);
    ASSERT_EQ(first, expected.begin()->first);
    ASSERT_EQ(first + histogram.counts.size() - 1, expected.rbegin()->first);
    for (Eigen::Index i = 0; i < histogram.counts.size(); ++i)
      EXPECT_NEAR(histogram.counts[i], expected[first + i] / (normalise ? total : 1), 1e-12);
  }
}

TEST(AxisHistogram, EmptyWhenNothingIsParallel)
{
  OrientedSamples samples = makeSamples(3);
  samples.normals.row(1).setOnes();
  const HistogramOptions options;
  const AxisHistogram histogram = projectOnAxis(samples, Eigen::Vector3d::UnitX(), options);
  EXPECT_EQ(histogram.counts.size(), 0);
  EXPECT_EQ(clipHistogram(histogram, options).counts.size(), 0);
  EXPECT_EQ(smoothHistogram(histogram, 3).counts.size(), 0);
  EXPECT_EQ(projectOnAxis(OrientedSamples(), Eigen::Vector3d::UnitX(), options).counts.size(), 0);
}

TEST(AxisHistogram, BoundsItsMemory)
{
  OrientedSamples samples = makeSamples(2);
  samples.points(0, 1) = 1e30;
  samples.normals.row(0).setOnes();
  EXPECT_THROW(projectOnAxis(samples, Eigen::Vector3d::UnitX(), HistogramOptions()), std::length_error);
  samples.points(0, 1) = std::numeric_limits<double>::quiet_NaN();
  const AxisHistogram of_the_other = projectOnAxis(samples, Eigen::Vector3d::UnitX(), HistogramOptions());
  ASSERT_EQ(of_the_other.counts.size(), 1);
  EXPECT_EQ(of_the_other.counts[0], 1);
}

TEST(AxisHistogram, ClipsHighBins)
{
  AxisHistogram histogram;
  histogram.bin_width = 0.1;
  histogram.counts.resize(5);
  histogram.counts << 1, 0, 20, 2, 2; // mean 5, standard deviation sqrt(56.8)
  HistogramOptions options;
  options.clip = HistogramOptions::Clip::UniformMean;
  options.clip_factor = 3;
  EXPECT_EQ(clipHistogram(histogram, options).counts[2], 15);
  options.clip = HistogramOptions::Clip::MeanSigma;
  options.clip_factor = 1;
  const Eigen::VectorXd clipped = clipHistogram(histogram, options).counts;
  EXPECT_NEAR(clipped[2], 5 + std::sqrt(56.8), 1e-12);
  EXPECT_EQ(clipped[0], 1);
  EXPECT_EQ(clipped[3], 2);
  options.clip = HistogramOptions::Clip::None;
  EXPECT_EQ(clipHistogram(histogram, options).counts, histogram.counts);
}

TEST(AxisHistogram, SmoothsByAMean)
{
  AxisHistogram histogram;
  histogram.origin = 0.2;
  histogram.bin_width = 0.1;
  histogram.counts.resize(3);
  histogram.counts << 5, 0, 10;
  const AxisHistogram smooth = smoothHistogram(histogram, 2);
  EXPECT_NEAR(smooth.origin, 0, 1e-15);
  ASSERT_EQ(smooth.counts.size(), 7);
  Eigen::VectorXd expected(7);
  expected << 1, 1, 3, 3, 3, 2, 2;
  EXPECT_LT((smooth.counts - expected).norm(), 1e-14);
  EXPECT_EQ(smoothHistogram(histogram, 0).counts, histogram.counts);
}

} // namespace
} // namespace pcl_ssfr::test_axis_histogram
