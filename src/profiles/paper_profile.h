// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "directions/mean_shift.h"
#include "preparation/paper_normals.h"

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/detail/neighbor_index.h>
#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>
#include <pcl_ssfr/scan_view.h>

#include <string>
#include <vector>

namespace pcl_ssfr {

/** \brief One scan made ready for the method as published (Algorithm 1; METHOD stages 1 to 5).
 *
 * Scales of 0 follow from the data by these rules, which pass through the settings that the authors ran:
 * normal radius r = 10 times the mean distance of nearest neighbours, more where 10 % of the points have their
 * neighbours on one line up to there (rings of a spinning sensor), within 0.1 to 0.9 m; leaf r/2, within 0.04 to 0.1 m;
 * LCP leaf 0.2 m at r = 0.1 m rising linearly to 0.5 m at r = 0.6 m; r_d and binWidth as in DensityOptions::radius and
 * HistogramOptions::bin_width (the authors kept those of 2017 at every scale).
 */
struct PaperScan {
  NormalEstimationResult normals;       ///< samples relative to normals.origin, sign (oriented or not), finite points
  std::vector<MainNormal> main_normals; ///< at most DensityOptions::max_regions, in descending support
  double lcp_leaf = 0;                  ///< spacing of \ref lcp_points [m]
  Points3 lcp_points;                   ///< samples thinned for the score, relative to normals.origin, 3 x M [m]
  NeighborIndex lcp_index;              ///< over \ref lcp_points
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero(); ///< that the normals face [m]; zero where they have no sign
  std::vector<StageReport> stages;                     ///< counts and seconds of each stage
  std::string unfinished; ///< stage in which the time ran out: nothing here may be used then; empty when complete
};

/// Options::paper with the scales that the user set in Options: what the stages read.
PaperOptions
paperStages(const Options& options);

/** \brief Stages 1 to 5 and the thinning of stage 12 for one scan. Total on data: an empty scan gives an empty value.
 *
 * Normals have no sign when the viewpoint mode is Unknown or Unused: the paper takes the sensor to be at the origin.
 * \param[in] deadline when it passes meanwhile: see PaperScan::unfinished
 * \throw std::invalid_argument when \p options are out of range.
 */
PaperScan
preparePaperScan(const ScanView& scan, const Options& options, const Deadline& deadline = Deadline());

/** \brief The method as published: Algorithm 2, METHOD stages 6 to 13, without any of the improvements.
 *
 * Ends with Status::TooFewPoints, TooFewDirections, NoCandidate, TimeLimit or Converged; the paper knows no rejection,
 * so min_confidence, refine and contradictions play no part. Result::rmse is over point-to-point distances of the
 * thinned scans. Result::confidence stays 0: the paper estimates none.
 * \param[in] guess scored as one more candidate by the same LCP; wins only when it is strictly better
 * \param[in] deadline in place of Options::time_limit, which is not read here
 * \throw std::invalid_argument when \p options are out of range.
 */
Result
registerPaperScans(const PaperScan& source,
                   const PaperScan& target,
                   const Options& options,
                   const Eigen::Isometry3d* guess = nullptr,
                   const Deadline& deadline = Deadline());

/// The score of a pose between the scans' own frames, as registerPaperScans() rates it; nothing in a scan without
/// points.
Candidate
scorePaperPose(const PaperScan& source,
               const PaperScan& target,
               const Options& options,
               const Eigen::Isometry3d& T_target_source);

} // namespace pcl_ssfr
