// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/options.h>

#include <gtest/gtest.h>

#include <omp.h>

#include <functional>
#include <limits>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What validate says; empty when it accepts.
std::string
complaint(const Options& options)
{
  try {
    validate(options);
  }
  catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// An option by name: how to set it, values that must be refused and values at the edge that must be accepted.
template <typename Value>
struct Row {
  std::string name;
  std::function<void(Options&, Value)> set;
  std::vector<Value> bad;
  std::vector<Value> good;
};

template <typename Value>
void
check(const std::vector<Row<Value>>& rows)
{
  const std::regex text("^[a-z_.]+ = .+, must .+$");
  for (const Row<Value>& row : rows) {
    for (const Value value : row.bad) {
      Options options;
      row.set(options, value);
      const std::string message = complaint(options);
      EXPECT_EQ(message.rfind(row.name + " = ", 0), 0U) << row.name << ": " << value << " gave: " << message;
      EXPECT_TRUE(std::regex_match(message, text)) << message;
    }
    for (const Value value : row.good) {
      Options options;
      row.set(options, value);
      EXPECT_EQ(complaint(options), "") << row.name << ": " << value;
    }
  }
}

#define PCL_SSFR_SET(field) [](Options& options, auto value) { options.field = value; }

TEST(Options, DefaultsOfBothProfilesAreValid)
{
  EXPECT_EQ(complaint(makeOptions(Profile::Default)), "");
  EXPECT_EQ(complaint(makeOptions(Profile::Paper2017)), "");
  EXPECT_EQ(makeOptions(Profile::Paper2017).profile, Profile::Paper2017);
}

TEST(Options, PaperProfileHasTheConstantsOf2017)
{
  const Options options = makeOptions(Profile::Paper2017);
  EXPECT_EQ(options.normals.pre_leaf, 0.01);
  EXPECT_FALSE(options.normals.away_from_viewpoint);
  EXPECT_EQ(options.density.kernel, DensityOptions::Kernel::Count);
  EXPECT_EQ(options.density.max_regions, 6);
  EXPECT_EQ(options.density.silence_chord, 0.3);
  EXPECT_FALSE(options.density.reject_elongated);
  EXPECT_EQ(options.mean_shift.bandwidth, 0.1);
  EXPECT_EQ(options.mean_shift.tolerance, 1e-7);
  EXPECT_EQ(options.mean_shift.merge_chord, 0.5);
  EXPECT_EQ(options.rotation.max_abs_cos, 0.9);
  EXPECT_EQ(options.rotation.angle_tolerance, 0.05);
  EXPECT_EQ(options.rotation.merge_angle, 0);
  EXPECT_EQ(options.translation.third_axis, TranslationOptions::ThirdAxis::FirstMode);
  EXPECT_EQ(options.translation.max_abs_cos, 0.9);
  EXPECT_EQ(options.translation.min_triple_product, 0.1);
  EXPECT_EQ(options.translation.histogram.bin_width, 0.015);
  EXPECT_EQ(options.translation.histogram.parallel_cos, 0.99);
  EXPECT_EQ(options.translation.histogram.facing, HistogramOptions::Facing::Either);
  EXPECT_EQ(options.translation.histogram.clip, HistogramOptions::Clip::UniformMean);
  EXPECT_EQ(options.translation.histogram.clip_factor, 3);
  EXPECT_EQ(options.translation.correlation.envelope_half_window, 10);
  EXPECT_EQ(options.translation.correlation.max_peaks, 1);
  EXPECT_FALSE(options.translation.correlation.sub_bin);
  EXPECT_FALSE(options.lcp.kernel_sum);
  EXPECT_EQ(options.lcp.fine_factor, 100);
  EXPECT_EQ(options.lcp.fine_smoothing, 0.01);
  EXPECT_EQ(options.lcp.fine_range_bins, 1.5);
}

TEST(Options, MoreThreadsThanASystemStartsAreRefused)
{
  Options options;
  options.threads = kMaxThreads;
  EXPECT_EQ(complaint(options), "");
  options.threads = kMaxThreads + 1;
  EXPECT_EQ(complaint(options), "threads = 1025, must be at most 1024");
}

TEST(ThreadCount, AllThatThisProcessMayUse)
{
  const int before = omp_get_max_threads();
  EXPECT_GE(threadCount(0), 1U);
  EXPECT_LE(threadCount(0), static_cast<unsigned>(omp_get_num_procs()));
  omp_set_num_threads(1);
  EXPECT_EQ(threadCount(0), 1U);
  EXPECT_EQ(threadCount(3), 3U); // as asked for
  Options options;
  options.threads = 5;
  EXPECT_EQ(threadCount(options), 5U);
  options.threads = 0;
  EXPECT_EQ(threadCount(options), 1U);
  omp_set_num_threads(before);
}

TEST(Options, RealNumbersOutOfRangeAreNamed)
{
  const double tiny = 1e-9;
  check<double>({
      {"normal_radius", PCL_SSFR_SET(normal_radius), {-tiny, kNan, kInfinity}, {0, 0.1}},
      {"density_radius", PCL_SSFR_SET(density_radius), {-tiny, 1.001, kNan}, {0, 1}},
      {"bin_width", PCL_SSFR_SET(bin_width), {-1, kNan, kInfinity}, {0, 0.01}},
      {"leaf", PCL_SSFR_SET(leaf), {-1, kNan, kInfinity}, {0, 0.1}},
      {"overlap_radius", PCL_SSFR_SET(overlap_radius), {-1, kNan, kInfinity}, {0, 1}},
      {"time_limit", PCL_SSFR_SET(time_limit), {-1, kNan, kInfinity}, {0, 0.5}},
      {"min_confidence", PCL_SSFR_SET(min_confidence), {-tiny, 1 + tiny, kNan}, {0, 1}},
      {"patches.thickness", PCL_SSFR_SET(patches.thickness), {-1, kNan}, {0, 0.1}},
      {"patches.range_noise", PCL_SSFR_SET(patches.range_noise), {-1, kNan}, {0, 0.1}},
      {"patches.max_flatness", PCL_SSFR_SET(patches.max_flatness), {0, 1, kNan}, {0.01, 0.99}},
      {"normals.pre_leaf", PCL_SSFR_SET(normals.pre_leaf), {-1, kNan}, {0, 1}},
      {"normals.radius", PCL_SSFR_SET(normals.radius), {-1, kNan}, {0, 1}},
      {"normals.leaf", PCL_SSFR_SET(normals.leaf), {-1, kNan}, {0, 1}},
      {"normals.max_range", PCL_SSFR_SET(normals.max_range), {-1, kNan}, {0, 1}},
      {"density.radius", PCL_SSFR_SET(density.radius), {0, 1.1, kNan}, {0.001, 1}},
      {"density.silence_chord", PCL_SSFR_SET(density.silence_chord), {0, 2.1, kNan}, {0.001, 2}},
      {"density.min_relative_density", PCL_SSFR_SET(density.min_relative_density), {-0.1, 1.1, kNan}, {0, 1}},
      {"density.max_elongation", PCL_SSFR_SET(density.max_elongation), {0, kNan, kInfinity}, {1}},
      {"density.max_elongated_chord", PCL_SSFR_SET(density.max_elongated_chord), {-1, kNan}, {0}},
      {"mean_shift.bandwidth", PCL_SSFR_SET(mean_shift.bandwidth), {0, 2.1, kNan}, {0.001, 2}},
      {"mean_shift.tolerance", PCL_SSFR_SET(mean_shift.tolerance), {0, -1, kNan}, {1e-12}},
      {"mean_shift.merge_chord", PCL_SSFR_SET(mean_shift.merge_chord), {-0.1, 2, kNan}, {0, 1.9}},
      {"rotation.max_abs_cos", PCL_SSFR_SET(rotation.max_abs_cos), {0, 1, kNan}, {0.5}},
      {"rotation.angle_tolerance", PCL_SSFR_SET(rotation.angle_tolerance), {0, 1.58, kNan}, {0.001, 1.57}},
      {"rotation.merge_angle", PCL_SSFR_SET(rotation.merge_angle), {-0.1, 3.2, kNan}, {0, 3.1}},
      {"rotation.refit_angle", PCL_SSFR_SET(rotation.refit_angle), {0, 3.2, kNan}, {0.1}},
      {"translation.max_abs_cos", PCL_SSFR_SET(translation.max_abs_cos), {0, 1, kNan}, {0.5}},
      {"translation.min_triple_product", PCL_SSFR_SET(translation.min_triple_product), {-0.1, 1, kNan}, {0}},
      {"translation.cross_angle", PCL_SSFR_SET(translation.cross_angle), {0, 3.2, kNan}, {1}},
      {"translation.histogram.bin_width", PCL_SSFR_SET(translation.histogram.bin_width), {0, -1, kNan}, {0.1}},
      {"translation.histogram.parallel_cos",
       PCL_SSFR_SET(translation.histogram.parallel_cos),
       {0, 1.1, kNan},
       {0.1, 1}},
      {"translation.histogram.clip_factor", PCL_SSFR_SET(translation.histogram.clip_factor), {0, kNan}, {1}},
      {"translation.correlation.min_separation", PCL_SSFR_SET(translation.correlation.min_separation), {-1, kNan}, {0}},
      {"lcp.leaf", PCL_SSFR_SET(lcp.leaf), {-1, kNan}, {0, 1}},
      {"lcp.fine_smoothing", PCL_SSFR_SET(lcp.fine_smoothing), {-1, kNan}, {0, 1}},
      {"lcp.fine_range_bins", PCL_SSFR_SET(lcp.fine_range_bins), {0, -1, kNan}, {0.5}},
  });
}

TEST(Options, WholeNumbersOutOfRangeAreNamed)
{
  check<int>({
      {"max_refinement_steps", PCL_SSFR_SET(max_refinement_steps), {0, -5}, {1}},
      {"max_candidates", PCL_SSFR_SET(max_candidates), {0, -5}, {1}},
      {"patches.finest_level", PCL_SSFR_SET(patches.finest_level), {-1, 20}, {0}},
      {"patches.coarsest_level", PCL_SSFR_SET(patches.coarsest_level), {2, 20}, {3, 19}}, // finest level is 3
      {"patches.min_points", PCL_SSFR_SET(patches.min_points), {2}, {3}},
      {"density.max_regions", PCL_SSFR_SET(density.max_regions), {0}, {1}},
      {"density.max_queries", PCL_SSFR_SET(density.max_queries), {-1}, {0, 1}},
      {"density.max_region_points", PCL_SSFR_SET(density.max_region_points), {0}, {1}},
      {"mean_shift.max_iterations", PCL_SSFR_SET(mean_shift.max_iterations), {0}, {1}},
      {"translation.histogram.max_bins", PCL_SSFR_SET(translation.histogram.max_bins), {0, -3}, {1}},
      {"translation.correlation.envelope_half_window",
       PCL_SSFR_SET(translation.correlation.envelope_half_window),
       {-1},
       {0}},
      {"translation.correlation.max_peaks", PCL_SSFR_SET(translation.correlation.max_peaks), {0}, {1}},
      {"lcp.fine_factor", PCL_SSFR_SET(lcp.fine_factor), {-1}, {0}},
  });
}

TEST(Options, GravityMustBeUnitVectors)
{
  Options options;
  options.gravity.emplace();
  EXPECT_EQ(complaint(options), "");
  options.gravity->up_source << 0, 0, 2;
  EXPECT_EQ(complaint(options), "gravity.up_source = (0, 0, 2), must be a unit vector");
  options.gravity->up_source << 0, 0, -1;
  options.gravity->up_target << kNan, 0, 0;
  EXPECT_EQ(complaint(options).rfind("gravity.up_target = (", 0), 0U);
  options.gravity->up_target = Eigen::Vector3d::UnitX();
  options.gravity->tolerance = 0;
  EXPECT_EQ(complaint(options), "gravity.tolerance = 0, must be in (0, pi] radians");
  options.gravity.reset();
  options.guess_tolerance = GuessTolerance{0, 1};
  EXPECT_EQ(complaint(options), "guess_tolerance.rotation = 0, must be in (0, pi] radians");
  options.guess_tolerance = GuessTolerance{0.1, kNan};
  EXPECT_EQ(complaint(options).rfind("guess_tolerance.translation = nan", 0), 0U);
  options.guess_tolerance = GuessTolerance{0.1, 0.5};
  EXPECT_EQ(complaint(options), "");
}

} // namespace
} // namespace pcl_ssfr
