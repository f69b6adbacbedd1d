// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/paper_options.h>
#include <pcl_ssfr/patch_config.h>

#include <Eigen/Core>

#include <optional>

namespace pcl_ssfr {

/// Which method runs through the pipeline.
enum class Profile {
  Default,  ///< planar patches, visibility scoring, polish
  Paper2017 ///< the method as published, in the constants of the implementation of July 2017
};

/// Whether the sensor of a scan is taken to be at the viewpoint that was given, or else at the origin. Where it is not,
/// Profile::Default estimates its position from the points, and Profile::Paper2017 does without.
enum class ViewpointMode {
  Auto,         ///< decided by the points: seen from its sensor, a scan has one return per direction
  SensorOrigin, ///< it is there
  Unknown,      ///< it is not there: only a position estimated from the points is used, if there is one
  Unused        ///< no position at all: unsigned normals, no free-space reasoning
};

/// Prior knowledge of the vertical in both scans.
struct GravityPrior {
  Eigen::Vector3d up_source = Eigen::Vector3d::UnitZ(); ///< unit, source frame
  Eigen::Vector3d up_target = Eigen::Vector3d::UnitZ(); ///< unit, target frame
  /// Rotations must map one onto the other within this angle [rad], (0, pi]: three standard deviations of the prior.
  double tolerance = 0.0873;
};

/// How accurate the caller's guess is: only poses within these bounds are considered.
struct GuessTolerance {
  double rotation = 0.1;  ///< angle between the rotations [rad], (0, pi]
  double translation = 1; ///< distance between where the poses put the source's sensor [m], > 0
};

/// The options that affect the preparation of a scan. A prepared scan stays valid when only SearchOptions change.
struct PreparationOptions {
  Profile profile = Profile::Default;                 ///< the method
  ViewpointMode viewpoint_mode = ViewpointMode::Auto; ///< whether the sensors are where the viewpoints say
  double normal_radius = 0;                           ///< r of the paper [m], 0 or > 0; 0: from the data
  double density_radius = 0; ///< r_d of the paper, chord on the unit sphere, (0, 1]; 0: the profile's
  double leaf = 0;           ///< spacing that the clouds are thinned to [m], 0 or > 0; 0: from the data
};

/// The options of the search for the pose, and of the decision whether to accept it.
struct SearchOptions {
  double bin_width = 0; ///< of the histograms of translations, the third parameter of the paper [m]; 0: from the data
  /// Only poses that agree with it are considered; noise may take a pose 0.01 rad beyond the tolerance.
  std::optional<GravityPrior> gravity;
  /// Tolerance of the guess, if there is one: only poses within it are considered (rotations up to 0.01 rad beyond).
  /// Without a tolerance the guess is one candidate among all. Not read by Paper2017.
  std::optional<GuessTolerance> guess_tolerance;
  double time_limit = 0;         ///< of registerScans() without a deadline, or of the PCL class' align() [s]; 0: none
  bool refine = true;            ///< polish the answer by robust point-to-plane steps; not read by Paper2017
  int max_refinement_steps = 30; ///< bound on the steps of the final polish, >= 1; not read by Paper2017
  double overlap_radius = 0;   ///< surfaces match nearer than this [m], at most twice the usual; 0: from the data; not
                               ///< read by Paper2017
  int max_candidates = 10;     ///< distinct poses listed in the result, >= 1
  double min_confidence = 0.7; ///< accept an answer from this confidence on, [0, 1]; not read by Paper2017
};

/** \brief Everything that can be set. The defaults need no change: a length of 0 is chosen from the data.
 *
 * Build one by makeOptions(profile); change fields; the registration validates them. The two groups are bases, so that
 * a field is set by its name alone (`options.leaf = 0.1`), and it is seen from the group whether a scan has to be
 * prepared anew.
 */
struct Options : PreparationOptions, SearchOptions {
  unsigned threads = 1;             ///< 0: all processors, at most kMaxThreads; the result never depends on it
  PatchProfileConfig patch_profile; ///< tuned numbers of Profile::Default
  PaperOptions paper; ///< stages of Profile::Paper2017; the lengths above, where set, take precedence over its own
};

/// Whether scans prepared with \p a can be registered with \p b: all options that affect preparation are equal.
PCL_SSFR_EXPORT bool
haveSamePreparation(const Options& a, const Options& b);

/// More threads than this are an error: a system that refuses to start them would end the process.
constexpr unsigned kMaxThreads = 1024;

/// The number of threads, >= 1, that \p requested stands for. 0: as many as OMP_NUM_THREADS allows (or
/// omp_set_num_threads()), at most one per processor that this process may use.
PCL_SSFR_EXPORT unsigned
threadCount(unsigned requested);

/// The same for Options::threads.
PCL_SSFR_EXPORT unsigned
threadCount(const Options& options);

/// The options of a profile.
PCL_SSFR_EXPORT Options
makeOptions(Profile profile);

/// Profile::Paper2017 with the constants of the implementation of 2019, where the two differ.
PCL_SSFR_EXPORT Options
makePaper2019Options();

/** \brief Check every option.
 * \throw std::invalid_argument with the text "name = value, must ..." for the first that is out of range.
 */
PCL_SSFR_EXPORT void
validate(const Options& options);

} // namespace pcl_ssfr
