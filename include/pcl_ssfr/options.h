// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/density_filter.h>
#include <pcl_ssfr/mean_shift.h>
#include <pcl_ssfr/normal_estimation.h>
#include <pcl_ssfr/planar_patches.h>
#include <pcl_ssfr/rotation_candidates.h>
#include <pcl_ssfr/translation.h>

#include <Eigen/Core>

#include <optional>

namespace pcl_ssfr {

/// Which method runs through the pipeline.
enum class Profile {
  Default,  ///< planar patches, visibility scoring, polish
  Paper2017 ///< the method as published, in the constants of the implementation of July 2017
};

/// Whether the origin (or the viewpoint given) of a scan is believed to be the place of its sensor. The default profile
/// looks for the place in the points where it is not believed, the paper's does without.
enum class ViewpointMode {
  Auto,         ///< decided from the points: a scan seen from its sensor has one return a direction
  SensorOrigin, ///< always believed
  Unknown,      ///< never believed: only a place found in the points is used, if there is one (see findViewpoint())
  Unused        ///< no place at all: unsigned normals, no free-space reasoning
};

/// Prior knowledge of the vertical in both scans.
struct GravityPrior {
  Eigen::Vector3d up_source = Eigen::Vector3d::UnitZ(); ///< unit, source frame
  Eigen::Vector3d up_target = Eigen::Vector3d::UnitZ(); ///< unit, target frame
  /// Rotations must map one onto the other within this [rad], (0, pi]: three standard deviations of what is given.
  double tolerance = 0.0873;
};

/// Options of the paper's selection and fine pass (METHOD stages 12 and 13).
struct LcpOptions {
  double leaf = 0;              ///< both scans are thinned to this, and it is the inlier radius [m]; 0: from the data
  bool kernel_sum = false;      ///< score by sum of exp(-d/t) (2019) instead of the count (2017)
  int fine_factor = 100;        ///< the fine pass uses bin_width / fine_factor; 0: no fine pass
  double fine_smoothing = 0.01; ///< width of the mean filter of the fine pass [m]
  double fine_range_bins = 1.5; ///< shifts are searched within so many coarse bins
};

/// How good the caller's guess is: only poses within it are considered.
struct GuessTolerance {
  double rotation = 0.1;  ///< angle between the rotations [rad], (0, pi]
  double translation = 1; ///< distance between where the poses put the source's sensor [m], > 0
};

/** \brief Everything that can be set. The defaults need no change: a scale of 0 follows from the data.
 *
 * Build one by makeOptions(profile); change fields; the registration validates them.
 */
struct Options {
  Profile profile = Profile::Default;
  ViewpointMode viewpoint_mode = ViewpointMode::Auto;

  // The three parameters of the paper; 0: from the data.
  double normal_radius = 0;  ///< r [m], 0 or > 0
  double density_radius = 0; ///< r_d, chord on the unit sphere, 0 or (0, 1]
  double bin_width = 0;      ///< [m], 0 or > 0
  double leaf = 0;           ///< spacing that the clouds are thinned to [m], 0: from the data

  bool refine = true;            ///< polish the answer by robust point-to-plane steps; not read by Paper2017
  int max_refinement_steps = 30; ///< bound on the steps of the final polish, >= 1; not read by Paper2017
  double overlap_radius = 0; ///< surfaces match nearer than this [m], at most twice the usual; 0: from the data; not
                             ///< read by Paper2017
  double time_limit = 0;     ///< of registerScans() without a deadline, or of the PCL class' align() [s]; 0: none
  unsigned threads = 1;      ///< 0: all processors, at most kMaxThreads; the result never depends on it
  /// Only poses that keep it are considered; the noise of scans may take a pose 0.01 rad beyond its tolerance.
  std::optional<GravityPrior> gravity;
  /// Of the guess, when there is one: only poses within it are considered, turns up to 0.01 rad beyond it. None: the
  /// guess is one candidate among all. Not read by Paper2017.
  std::optional<GuessTolerance> guess_tolerance;
  int max_candidates = 10;     ///< distinct poses listed in the result, >= 1
  double min_confidence = 0.7; ///< accept an answer from this confidence on, [0, 1]; not read by Paper2017

  // Stages. Profile::Default reads only patches, and has the other stages' constants of its own; Profile::Paper2017
  // reads all but patches. The scales above, when they are set, go before the stages' own.
  PatchOptions patches;
  NormalOptions normals;
  DensityOptions density;
  MeanShiftOptions mean_shift;
  RotationOptions rotation;
  TranslationOptions translation;
  LcpOptions lcp;
};

/// More threads than this are an error: a system that refuses to start them would end the process.
constexpr unsigned kMaxThreads = 1024;

/// The number of threads, >= 1, that \p requested stands for. 0: as many as OMP_NUM_THREADS allows (or
/// omp_set_num_threads()), at most one a processor that this process may use.
unsigned
threadCount(unsigned requested);

/// The same for Options::threads.
unsigned
threadCount(const Options& options);

/// The options of a profile.
Options
makeOptions(Profile profile);

/** \brief Check every option.
 * \throw std::invalid_argument with the text "name = value, must ..." for the first that is out of range.
 */
void
validate(const Options& options);

} // namespace pcl_ssfr
