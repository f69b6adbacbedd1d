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
  EXPECT_EQ(options.paper.normals.pre_leaf, 0.01);
  EXPECT_FALSE(options.paper.normals.away_from_viewpoint);
  EXPECT_EQ(options.paper.density.kernel, DensityOptions::Kernel::Count);
  EXPECT_EQ(options.paper.density.max_regions, 6);
  EXPECT_EQ(options.paper.density.silence_chord, 0.3);
  EXPECT_FALSE(options.paper.density.reject_elongated);
  EXPECT_EQ(options.paper.mean_shift.bandwidth, 0.1);
  EXPECT_EQ(options.paper.mean_shift.tolerance, 1e-7);
  EXPECT_EQ(options.paper.mean_shift.merge_chord, 0.5);
  EXPECT_EQ(options.paper.rotation.max_abs_cos, 0.9);
  EXPECT_EQ(options.paper.rotation.angle_tolerance, 0.05);
  EXPECT_EQ(options.paper.rotation.merge_angle, 0);
  EXPECT_EQ(options.paper.translation.third_axis, TranslationOptions::ThirdAxis::FirstMode);
  EXPECT_EQ(options.paper.translation.max_abs_cos, 0.9);
  EXPECT_EQ(options.paper.translation.min_triple_product, 0.1);
  EXPECT_EQ(options.paper.translation.histogram.bin_width, 0.015);
  EXPECT_EQ(options.paper.translation.histogram.parallel_cos, 0.99);
  EXPECT_EQ(options.paper.translation.histogram.facing, HistogramOptions::Facing::Either);
  EXPECT_EQ(options.paper.translation.histogram.clip, HistogramOptions::Clip::UniformMean);
  EXPECT_EQ(options.paper.translation.histogram.clip_factor, 3);
  EXPECT_EQ(options.paper.translation.correlation.envelope_half_window, 10);
  EXPECT_EQ(options.paper.translation.correlation.max_peaks, 1);
  EXPECT_FALSE(options.paper.translation.correlation.sub_bin);
  EXPECT_FALSE(options.paper.lcp.kernel_sum);
  EXPECT_EQ(options.paper.lcp.fine_factor, 100);
  EXPECT_EQ(options.paper.lcp.fine_smoothing, 0.01);
  EXPECT_EQ(options.paper.lcp.fine_range_bins, 1.5);
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
      {"preparation.patches.range_noise",
       PCL_SSFR_SET(patch_profile.preparation.patches.range_noise),
       {-1, kNan},
       {0, 0.1}},
      {"preparation.patches.max_flatness",
       PCL_SSFR_SET(patch_profile.preparation.patches.max_flatness),
       {0, 1, kNan},
       {0.01, 0.99}},
      {"paper.normals.pre_leaf", PCL_SSFR_SET(paper.normals.pre_leaf), {-1, kNan}, {0, 1}},
      {"paper.normals.radius", PCL_SSFR_SET(paper.normals.radius), {-1, kNan}, {0, 1}},
      {"paper.normals.leaf", PCL_SSFR_SET(paper.normals.leaf), {-1, kNan}, {0, 1}},
      {"paper.normals.max_range", PCL_SSFR_SET(paper.normals.max_range), {-1, kNan}, {0, 1}},
      {"paper.density.radius", PCL_SSFR_SET(paper.density.radius), {0, 1.1, kNan}, {0.001, 1}},
      {"paper.density.silence_chord", PCL_SSFR_SET(paper.density.silence_chord), {0, 2.1, kNan}, {0.001, 2}},
      {"paper.density.min_relative_density",
       PCL_SSFR_SET(paper.density.min_relative_density),
       {-0.1, 1.1, kNan},
       {0, 1}},
      {"paper.density.max_elongation", PCL_SSFR_SET(paper.density.max_elongation), {0, kNan, kInfinity}, {1}},
      {"paper.density.max_elongated_chord", PCL_SSFR_SET(paper.density.max_elongated_chord), {-1, kNan}, {0}},
      {"paper.mean_shift.bandwidth", PCL_SSFR_SET(paper.mean_shift.bandwidth), {0, 2.1, kNan}, {0.001, 2}},
      {"paper.mean_shift.tolerance", PCL_SSFR_SET(paper.mean_shift.tolerance), {0, -1, kNan}, {1e-12}},
      {"paper.mean_shift.merge_chord", PCL_SSFR_SET(paper.mean_shift.merge_chord), {-0.1, 2, kNan}, {0, 1.9}},
      {"paper.rotation.max_abs_cos", PCL_SSFR_SET(paper.rotation.max_abs_cos), {0, 1, kNan}, {0.5}},
      {"paper.rotation.angle_tolerance", PCL_SSFR_SET(paper.rotation.angle_tolerance), {0, 1.58, kNan}, {0.001, 1.57}},
      {"paper.rotation.merge_angle", PCL_SSFR_SET(paper.rotation.merge_angle), {-0.1, 3.2, kNan}, {0, 3.1}},
      {"paper.rotation.refit_angle", PCL_SSFR_SET(paper.rotation.refit_angle), {0, 3.2, kNan}, {0.1}},
      {"paper.translation.max_abs_cos", PCL_SSFR_SET(paper.translation.max_abs_cos), {0, 1, kNan}, {0.5}},
      {"paper.translation.min_triple_product",
       PCL_SSFR_SET(paper.translation.min_triple_product),
       {-0.1, 1, kNan},
       {0}},
      {"paper.translation.cross_angle", PCL_SSFR_SET(paper.translation.cross_angle), {0, 3.2, kNan}, {1}},
      {"paper.translation.histogram.bin_width",
       PCL_SSFR_SET(paper.translation.histogram.bin_width),
       {0, -1, kNan},
       {0.1}},
      {"paper.translation.histogram.parallel_cos",
       PCL_SSFR_SET(paper.translation.histogram.parallel_cos),
       {0, 1.1, kNan},
       {0.1, 1}},
      {"paper.translation.histogram.clip_factor",
       PCL_SSFR_SET(paper.translation.histogram.clip_factor),
       {0, kNan},
       {1}},
      {"paper.translation.correlation.min_separation",
       PCL_SSFR_SET(paper.translation.correlation.min_separation),
       {-1, kNan},
       {0}},
      {"paper.lcp.leaf", PCL_SSFR_SET(paper.lcp.leaf), {-1, kNan}, {0, 1}},
      {"paper.lcp.fine_smoothing", PCL_SSFR_SET(paper.lcp.fine_smoothing), {-1, kNan}, {0, 1}},
      {"paper.lcp.fine_range_bins", PCL_SSFR_SET(paper.lcp.fine_range_bins), {0, -1, kNan}, {0.5}},
  });
}

TEST(Options, WholeNumbersOutOfRangeAreNamed)
{
  check<int>({
      {"max_refinement_steps", PCL_SSFR_SET(max_refinement_steps), {0, -5}, {1}},
      {"max_candidates", PCL_SSFR_SET(max_candidates), {0, -5}, {1}},
      {"preparation.patches.finest_level", PCL_SSFR_SET(patch_profile.preparation.patches.finest_level), {-1, 20}, {0}},
      {"preparation.patches.coarsest_level",
       PCL_SSFR_SET(patch_profile.preparation.patches.coarsest_level),
       {2, 20},
       {3, 19}}, // finest level is 3
      {"preparation.patches.min_points", PCL_SSFR_SET(patch_profile.preparation.patches.min_points), {2}, {3}},
      {"paper.density.max_regions", PCL_SSFR_SET(paper.density.max_regions), {0}, {1}},
      {"paper.density.max_queries", PCL_SSFR_SET(paper.density.max_queries), {-1}, {0, 1}},
      {"paper.density.max_region_points", PCL_SSFR_SET(paper.density.max_region_points), {0}, {1}},
      {"paper.mean_shift.max_iterations", PCL_SSFR_SET(paper.mean_shift.max_iterations), {0}, {1}},
      {"paper.translation.histogram.max_bins", PCL_SSFR_SET(paper.translation.histogram.max_bins), {0, -3}, {1}},
      {"paper.translation.correlation.envelope_half_window",
       PCL_SSFR_SET(paper.translation.correlation.envelope_half_window),
       {-1},
       {0}},
      {"paper.translation.correlation.max_peaks", PCL_SSFR_SET(paper.translation.correlation.max_peaks), {0}, {1}},
      {"paper.lcp.fine_factor", PCL_SSFR_SET(paper.lcp.fine_factor), {-1}, {0}},
  });
}

/// A change of one option, by name.
struct Change {
  const char* name;
  std::function<void(Options&)> make;
};

#define PCL_SSFR_CHANGE(field, value)                                                                                  \
  {                                                                                                                    \
#field, [](Options & options) { options.field = value; }                                                           \
  }

TEST(SamePreparation, EveryOptionThatThePreparationReadsCounts)
{
  const std::vector<Change> both = {
      PCL_SSFR_CHANGE(viewpoint_mode, ViewpointMode::Unknown),
      PCL_SSFR_CHANGE(normal_radius, 0.2),
      PCL_SSFR_CHANGE(density_radius, 0.05),
      PCL_SSFR_CHANGE(leaf, 0.1),
  };
  const std::vector<Change> patches = {
      PCL_SSFR_CHANGE(patch_profile.preparation.thickness, 0.02),
      PCL_SSFR_CHANGE(patch_profile.preparation.patches.range_noise, 0.002),
      PCL_SSFR_CHANGE(patch_profile.preparation.patches.max_flatness, 0.2),
      PCL_SSFR_CHANGE(patch_profile.preparation.patches.finest_level, 2),
      PCL_SSFR_CHANGE(patch_profile.preparation.patches.coarsest_level, 5),
      PCL_SSFR_CHANGE(patch_profile.preparation.patches.min_points, 6),
  };
  const std::vector<Change> paper = {
      PCL_SSFR_CHANGE(paper.normals.pre_leaf, 0.02),
      PCL_SSFR_CHANGE(paper.normals.radius, 0.2),
      PCL_SSFR_CHANGE(paper.normals.leaf, 0.05),
      PCL_SSFR_CHANGE(paper.normals.max_range, 30),
      PCL_SSFR_CHANGE(paper.normals.away_from_viewpoint, true),
      PCL_SSFR_CHANGE(paper.normals.use_given_normals, false),
      PCL_SSFR_CHANGE(paper.density.radius, 0.05),
      PCL_SSFR_CHANGE(paper.density.kernel, DensityOptions::Kernel::Gaussian),
      PCL_SSFR_CHANGE(paper.density.max_regions, 5),
      PCL_SSFR_CHANGE(paper.density.silence_chord, 0.2),
      PCL_SSFR_CHANGE(paper.density.min_relative_density, 0.1),
      PCL_SSFR_CHANGE(paper.density.reject_elongated, true),
      PCL_SSFR_CHANGE(paper.density.max_elongation, 2),
      PCL_SSFR_CHANGE(paper.density.max_elongated_chord, 0.2),
      PCL_SSFR_CHANGE(paper.density.max_region_points, 2000),
      PCL_SSFR_CHANGE(paper.density.max_queries, 100),
      PCL_SSFR_CHANGE(paper.mean_shift.bandwidth, 0.2),
      PCL_SSFR_CHANGE(paper.mean_shift.tolerance, 1e-6),
      PCL_SSFR_CHANGE(paper.mean_shift.max_iterations, 100),
      PCL_SSFR_CHANGE(paper.mean_shift.merge_chord, 0.4),
      PCL_SSFR_CHANGE(paper.lcp.leaf, 0.3),
  };
  const std::vector<Change> search = {
      PCL_SSFR_CHANGE(threads, 4),
      PCL_SSFR_CHANGE(bin_width, 0.1),
      PCL_SSFR_CHANGE(gravity, GravityPrior()),
      PCL_SSFR_CHANGE(guess_tolerance, GuessTolerance()),
      PCL_SSFR_CHANGE(time_limit, 3),
      PCL_SSFR_CHANGE(refine, false),
      PCL_SSFR_CHANGE(max_refinement_steps, 3),
      PCL_SSFR_CHANGE(overlap_radius, 0.3),
      PCL_SSFR_CHANGE(max_candidates, 3),
      PCL_SSFR_CHANGE(min_confidence, 0.3),
      PCL_SSFR_CHANGE(paper.rotation.angle_tolerance, 0.1),
      PCL_SSFR_CHANGE(paper.translation.histogram.bin_width, 0.1),
      PCL_SSFR_CHANGE(paper.lcp.kernel_sum, true),
  };
  EXPECT_FALSE(haveSamePreparation(makeOptions(Profile::Default), makeOptions(Profile::Paper2017)));
  for (const Profile profile : {Profile::Default, Profile::Paper2017}) {
    const Options options = makeOptions(profile);
    EXPECT_TRUE(haveSamePreparation(options, options));
    const auto check_all = [&](const std::vector<Change>& changes, bool same) {
      for (const Change& change : changes) {
        Options changed = options;
        change.make(changed);
        EXPECT_EQ(haveSamePreparation(options, changed), same) << change.name;
        EXPECT_EQ(haveSamePreparation(changed, options), same) << change.name;
        EXPECT_TRUE(haveSamePreparation(changed, changed)) << change.name;
      }
    };
    check_all(both, false);
    check_all(patches, profile == Profile::Paper2017);
    check_all(paper, profile == Profile::Default);
    check_all(search, true);
  }
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
