// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/options.h>

#include "common/angles.h"
#include "common/config_numbers.h"
#include "common/option_checks.h"
#include "common/types.h"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <tuple>

namespace pcl_ssfr {

namespace {

void
requirePositive(const char* name, double value)
{
  requireOption(value > 0 && std::isfinite(value), name, value, "be positive and finite");
}

void
requireNotNegative(const char* name, double value)
{
  requireOption(value >= 0 && std::isfinite(value), name, value, "be 0 or positive, and finite");
}

void
requireAtLeast(const char* name, int value, int least)
{
  requireOption(value >= least, name, value, "be at least " + std::to_string(least));
}

void
requireShare(const char* name, double value)
{
  requireOption(value >= 0 && value <= 1, name, value, "be in [0, 1]");
}

void
requireCosine(const char* name, double value)
{
  requireOption(value > 0 && value < 1, name, value, "be in (0, 1)");
}

void
requireAngle(const char* name, double value)
{
  requireOption(value > 0 && value <= kPi, name, value, "be in (0, pi] radians");
}

void
requireChord(const char* name, double value)
{
  requireOption(value > 0 && value <= 2, name, value, "be a chord in (0, 2]");
}

void
requireUnit(const char* name, const Eigen::Vector3d& value)
{
  std::ostringstream text;
  text << '(' << value.x() << ", " << value.y() << ", " << value.z() << ')';
  requireOption(std::abs(value.norm() - 1) <= kUnitTolerance, name, text.str(), "be a unit vector");
}

void
validateNormals(const NormalOptions& options)
{
  requireNotNegative("paper.normals.pre_leaf", options.pre_leaf);
  requireNotNegative("paper.normals.radius", options.radius);
  requireNotNegative("paper.normals.leaf", options.leaf);
  requireNotNegative("paper.normals.max_range", options.max_range);
}

void
validateDensity(const DensityOptions& options)
{
  requireOption(
      options.radius > 0 && options.radius <= 1, "paper.density.radius", options.radius, "be a chord in (0, 1]");
  requireAtLeast("paper.density.max_regions", options.max_regions, 1);
  requireAtLeast("paper.density.max_queries", options.max_queries, 0);
  requireChord("paper.density.silence_chord", options.silence_chord);
  requireShare("paper.density.min_relative_density", options.min_relative_density);
  requirePositive("paper.density.max_elongation", options.max_elongation);
  requireNotNegative("paper.density.max_elongated_chord", options.max_elongated_chord);
  requireAtLeast("paper.density.max_region_points", options.max_region_points, 1);
}

void
validateMeanShift(const MeanShiftOptions& options)
{
  requireChord("paper.mean_shift.bandwidth", options.bandwidth);
  requirePositive("paper.mean_shift.tolerance", options.tolerance);
  requireAtLeast("paper.mean_shift.max_iterations", options.max_iterations, 1);
  requireOption(options.merge_chord >= 0 && options.merge_chord < 2,
                "paper.mean_shift.merge_chord",
                options.merge_chord,
                "be a chord in [0, 2)");
}

void
validateRotation(const RotationOptions& options)
{
  requireCosine("paper.rotation.max_abs_cos", options.max_abs_cos);
  requireOption(options.angle_tolerance > 0 && options.angle_tolerance < kPi / 2,
                "paper.rotation.angle_tolerance",
                options.angle_tolerance,
                "be in (0, pi/2) radians");
  requireOption(options.merge_angle >= 0 && options.merge_angle <= kPi,
                "paper.rotation.merge_angle",
                options.merge_angle,
                "be in [0, pi] radians");
  requireAngle("paper.rotation.refit_angle", options.refit_angle);
}

void
validateTranslation(const TranslationOptions& options)
{
  requireCosine("paper.translation.max_abs_cos", options.max_abs_cos);
  requireOption(options.min_triple_product >= 0 && options.min_triple_product < 1,
                "paper.translation.min_triple_product",
                options.min_triple_product,
                "be in [0, 1)");
  requireAngle("paper.translation.cross_angle", options.cross_angle);

  const HistogramOptions& histogram = options.histogram;
  requirePositive("paper.translation.histogram.bin_width", histogram.bin_width);
  requireOption(histogram.parallel_cos > 0 && histogram.parallel_cos <= 1,
                "paper.translation.histogram.parallel_cos",
                histogram.parallel_cos,
                "be in (0, 1]");
  requirePositive("paper.translation.histogram.clip_factor", histogram.clip_factor);
  requireOption(histogram.max_bins >= 1, "paper.translation.histogram.max_bins", histogram.max_bins, "be at least 1");

  const CorrelationOptions& correlation = options.correlation;
  requireAtLeast("paper.translation.correlation.envelope_half_window", correlation.envelope_half_window, 0);
  requireAtLeast("paper.translation.correlation.max_peaks", correlation.max_peaks, 1);
  requireNotNegative("paper.translation.correlation.min_separation", correlation.min_separation);
}

void
validateLcp(const LcpOptions& options)
{
  requireNotNegative("paper.lcp.leaf", options.leaf);
  requireAtLeast("paper.lcp.fine_factor", options.fine_factor, 0);
  requireNotNegative("paper.lcp.fine_smoothing", options.fine_smoothing);
  requirePositive("paper.lcp.fine_range_bins", options.fine_range_bins);
}

// Structured bindings name every field: an option that is added does not compile here until it is compared.

bool
isEqual(const PreparationOptions& a, const PreparationOptions& b)
{
  const auto& [profile, viewpoint_mode, normal_radius, density_radius, leaf] = a;
  return std::tie(profile, viewpoint_mode, normal_radius, density_radius, leaf) ==
         std::tie(b.profile, b.viewpoint_mode, b.normal_radius, b.density_radius, b.leaf);
}

bool
isEqual(const NormalOptions& a, const NormalOptions& b)
{
  const auto& [pre_leaf, radius, leaf, max_range, away_from_viewpoint, use_given_normals] = a;
  return std::tie(pre_leaf, radius, leaf, max_range, away_from_viewpoint, use_given_normals) ==
         std::tie(b.pre_leaf, b.radius, b.leaf, b.max_range, b.away_from_viewpoint, b.use_given_normals);
}

bool
isEqual(const DensityOptions& a, const DensityOptions& b)
{
  const auto& [radius,
               kernel,
               max_regions,
               silence_chord,
               min_relative_density,
               reject_elongated,
               max_elongation,
               max_elongated_chord,
               max_region_points,
               max_queries] = a;
  return std::tie(radius, kernel, max_regions, silence_chord, min_relative_density) ==
             std::tie(b.radius, b.kernel, b.max_regions, b.silence_chord, b.min_relative_density) &&
         std::tie(reject_elongated, max_elongation, max_elongated_chord, max_region_points, max_queries) ==
             std::tie(b.reject_elongated, b.max_elongation, b.max_elongated_chord, b.max_region_points, b.max_queries);
}

bool
isEqual(const MeanShiftOptions& a, const MeanShiftOptions& b)
{
  const auto& [bandwidth, tolerance, max_iterations, merge_chord] = a;
  return std::tie(bandwidth, tolerance, max_iterations, merge_chord) ==
         std::tie(b.bandwidth, b.tolerance, b.max_iterations, b.merge_chord);
}

/// Of the paper's selection, the preparation reads the leaf.
bool
isSamePreparation(const PaperOptions& a, const PaperOptions& b)
{
  return isEqual(a.normals, b.normals) && isEqual(a.density, b.density) && isEqual(a.mean_shift, b.mean_shift) &&
         std::tie(a.lcp.leaf) == std::tie(b.lcp.leaf);
}

} // namespace

unsigned
threadCount(unsigned requested)
{
  return requested > 0 ? requested
                       : static_cast<unsigned>(std::max(1, std::min(omp_get_max_threads(), omp_get_num_procs())));
}

unsigned
threadCount(const Options& options)
{
  return threadCount(options.threads);
}

Options
makeOptions(Profile profile)
{
  Options options;
  options.profile = profile;
  return options;
}

Options
makePaper2019Options()
{
  const double density_radius = 0.02; // chord
  Options options = makeOptions(Profile::Paper2017);
  PaperOptions& paper = options.paper;
  paper.normals.pre_leaf = 0.005;
  paper.normals.away_from_viewpoint = true;
  paper.density.kernel = DensityOptions::Kernel::Gaussian;
  paper.density.radius = density_radius;
  paper.density.max_regions = 8;
  paper.density.silence_chord = chordFromAngle(15 * kDegree);
  paper.density.reject_elongated = true;
  paper.mean_shift.bandwidth = 2 * density_radius;
  paper.mean_shift.merge_chord = 0;
  paper.rotation.angle_tolerance = 3 * kDegree;
  paper.translation.third_axis = TranslationOptions::ThirdAxis::CrossProduct;
  paper.translation.histogram.bin_width = 0.01;
  paper.translation.histogram.clip = HistogramOptions::Clip::MeanSigma;
  paper.translation.histogram.clip_factor = 2;
  paper.translation.correlation.envelope_half_window = 0;
  paper.lcp.leaf = 0.06;
  paper.lcp.kernel_sum = true;
  return options;
}

bool
haveSamePreparation(const Options& a, const Options& b)
{
  return isEqual(a, b) && (a.profile == Profile::Paper2017 ? isSamePreparation(a.paper, b.paper)
                                                           : isSamePreparation(a.patch_profile, b.patch_profile));
}

void
validate(const Options& options)
{
  requireNotNegative("normal_radius", options.normal_radius);
  requireOption(options.density_radius >= 0 && options.density_radius <= 1,
                "density_radius",
                options.density_radius,
                "be 0 (from the data) or a chord in (0, 1]");
  requireNotNegative("bin_width", options.bin_width);
  requireNotNegative("leaf", options.leaf);
  requireAtLeast("max_refinement_steps", options.max_refinement_steps, 1);
  requireNotNegative("overlap_radius", options.overlap_radius);
  requireNotNegative("time_limit", options.time_limit);
  requireOption(
      options.threads <= kMaxThreads, "threads", options.threads, "be at most " + std::to_string(kMaxThreads));
  if (options.gravity) {
    requireUnit("gravity.up_source", options.gravity->up_source);
    requireUnit("gravity.up_target", options.gravity->up_target);
    requireAngle("gravity.tolerance", options.gravity->tolerance);
  }
  if (options.guess_tolerance) {
    requireAngle("guess_tolerance.rotation", options.guess_tolerance->rotation);
    requirePositive("guess_tolerance.translation", options.guess_tolerance->translation);
  }
  requireAtLeast("max_candidates", options.max_candidates, 1);
  requireShare("min_confidence", options.min_confidence);
  validate(options.patch_profile);
  validateNormals(options.paper.normals);
  validateDensity(options.paper.density);
  validateMeanShift(options.paper.mean_shift);
  validateRotation(options.paper.rotation);
  validateTranslation(options.paper.translation);
  validateLcp(options.paper.lcp);
}

} // namespace pcl_ssfr
