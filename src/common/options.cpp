// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/options.h>

#include "common/rotation_math.h"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {

namespace {

/// A vector is a unit vector when its norm is this near to 1.
constexpr double kUnitTolerance = 1e-3;
/// Finest grid that a Morton code of 21 bits an axis can hold.
constexpr int kMaxLevel = 20;

template <typename Value>
std::string
toText(const Value& value)
{
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string
toText(const Eigen::Vector3d& value)
{
  std::ostringstream text;
  text << '(' << value.x() << ", " << value.y() << ", " << value.z() << ')';
  return text.str();
}

/// Throw "name = value, must ..." unless \p good. Conditions are written so that NaN is not good.
template <typename Value>
void
require(bool good, const char* name, const Value& value, const char* bound)
{
  if (!good)
    throw std::invalid_argument(std::string(name) + " = " + toText(value) + ", must " + bound);
}

void
requirePositive(const char* name, double value)
{
  require(value > 0 && std::isfinite(value), name, value, "be positive and finite");
}

void
requireNotNegative(const char* name, double value)
{
  require(value >= 0 && std::isfinite(value), name, value, "be 0 or positive, and finite");
}

void
requireAtLeast(const char* name, int value, int least)
{
  require(value >= least, name, value, ("be at least " + toText(least)).c_str());
}

void
requireShare(const char* name, double value)
{
  require(value >= 0 && value <= 1, name, value, "be in [0, 1]");
}

void
requireCosine(const char* name, double value)
{
  require(value > 0 && value < 1, name, value, "be in (0, 1)");
}

void
requireAngle(const char* name, double value)
{
  require(value > 0 && value <= kPi, name, value, "be in (0, pi] radians");
}

void
requireChord(const char* name, double value)
{
  require(value > 0 && value <= 2, name, value, "be a chord in (0, 2]");
}

void
requireUnit(const char* name, const Eigen::Vector3d& value)
{
  require(std::abs(value.norm() - 1) <= kUnitTolerance, name, value, "be a unit vector");
}

void
validatePatches(const PatchOptions& options)
{
  requireNotNegative("patches.thickness", options.thickness);
  requireNotNegative("patches.range_noise", options.range_noise);
  requireCosine("patches.max_flatness", options.max_flatness);
  require(options.finest_level >= 0 && options.finest_level < kMaxLevel,
          "patches.finest_level",
          options.finest_level,
          "be in [0, 20)");
  require(options.coarsest_level >= options.finest_level && options.coarsest_level < kMaxLevel,
          "patches.coarsest_level",
          options.coarsest_level,
          "be in [finest_level, 20)");
  requireAtLeast("patches.min_points", options.min_points, 3);
}

void
validateNormals(const NormalOptions& options)
{
  requireNotNegative("normals.pre_leaf", options.pre_leaf);
  requireNotNegative("normals.radius", options.radius);
  requireNotNegative("normals.leaf", options.leaf);
  requireNotNegative("normals.max_range", options.max_range);
}

void
validateDensity(const DensityOptions& options)
{
  require(options.radius > 0 && options.radius <= 1, "density.radius", options.radius, "be a chord in (0, 1]");
  requireAtLeast("density.max_regions", options.max_regions, 1);
  requireAtLeast("density.max_queries", options.max_queries, 0);
  requireChord("density.silence_chord", options.silence_chord);
  requireShare("density.min_relative_density", options.min_relative_density);
  requirePositive("density.max_elongation", options.max_elongation);
  requireNotNegative("density.max_elongated_chord", options.max_elongated_chord);
  requireAtLeast("density.max_region_points", options.max_region_points, 1);
}

void
validateMeanShift(const MeanShiftOptions& options)
{
  requireChord("mean_shift.bandwidth", options.bandwidth);
  requirePositive("mean_shift.tolerance", options.tolerance);
  requireAtLeast("mean_shift.max_iterations", options.max_iterations, 1);
  require(options.merge_chord >= 0 && options.merge_chord < 2,
          "mean_shift.merge_chord",
          options.merge_chord,
          "be a chord in [0, 2)");
}

void
validateRotation(const RotationOptions& options)
{
  requireCosine("rotation.max_abs_cos", options.max_abs_cos);
  require(options.angle_tolerance > 0 && options.angle_tolerance < kPi / 2,
          "rotation.angle_tolerance",
          options.angle_tolerance,
          "be in (0, pi/2) radians");
  require(options.merge_angle >= 0 && options.merge_angle <= kPi,
          "rotation.merge_angle",
          options.merge_angle,
          "be in [0, pi] radians");
  requireAngle("rotation.refit_angle", options.refit_angle);
}

void
validateTranslation(const TranslationOptions& options)
{
  requireCosine("translation.max_abs_cos", options.max_abs_cos);
  require(options.min_triple_product >= 0 && options.min_triple_product < 1,
          "translation.min_triple_product",
          options.min_triple_product,
          "be in [0, 1)");
  requireAngle("translation.cross_angle", options.cross_angle);

  const HistogramOptions& histogram = options.histogram;
  requirePositive("translation.histogram.bin_width", histogram.bin_width);
  require(histogram.parallel_cos > 0 && histogram.parallel_cos <= 1,
          "translation.histogram.parallel_cos",
          histogram.parallel_cos,
          "be in (0, 1]");
  requirePositive("translation.histogram.clip_factor", histogram.clip_factor);
  require(histogram.max_bins >= 1, "translation.histogram.max_bins", histogram.max_bins, "be at least 1");

  const CorrelationOptions& correlation = options.correlation;
  requireAtLeast("translation.correlation.envelope_half_window", correlation.envelope_half_window, 0);
  requireAtLeast("translation.correlation.max_peaks", correlation.max_peaks, 1);
  requireNotNegative("translation.correlation.min_separation", correlation.min_separation);
}

void
validateLcp(const LcpOptions& options)
{
  requireNotNegative("lcp.leaf", options.leaf);
  requireAtLeast("lcp.fine_factor", options.fine_factor, 0);
  requireNotNegative("lcp.fine_smoothing", options.fine_smoothing);
  requirePositive("lcp.fine_range_bins", options.fine_range_bins);
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

void
validate(const Options& options)
{
  requireNotNegative("normal_radius", options.normal_radius);
  require(options.density_radius >= 0 && options.density_radius <= 1,
          "density_radius",
          options.density_radius,
          "be 0 (from the data) or a chord in (0, 1]");
  requireNotNegative("bin_width", options.bin_width);
  requireNotNegative("leaf", options.leaf);
  requireAtLeast("max_refinement_steps", options.max_refinement_steps, 1);
  requireNotNegative("overlap_radius", options.overlap_radius);
  requireNotNegative("time_limit", options.time_limit);
  require(options.threads <= kMaxThreads, "threads", options.threads, ("be at most " + toText(kMaxThreads)).c_str());
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
  validatePatches(options.patches);
  validate(options.patch_profile);
  validateNormals(options.normals);
  validateDensity(options.density);
  validateMeanShift(options.mean_shift);
  validateRotation(options.rotation);
  validateTranslation(options.translation);
  validateLcp(options.lcp);
}

} // namespace pcl_ssfr
