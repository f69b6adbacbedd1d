// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/visibility_score.h"
#include "search/rotation_candidates.h"
#include "search/translation.h"

#include <pcl_ssfr/deadline.h>

#include <optional>
#include <vector>

namespace pcl_ssfr {

/// Translations that are looked at, where there is a prior.
struct ShiftWindow {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< target frame [m]
  double radius = 0;                                ///< along each axis of the search [m]
};

/// Options of the search for translations under a given rotation.
struct PoseSearchOptions {
  SearchConfig config; ///< numbers, with the lengths of the pair
  SearchPass pass = SearchConfig{}.much_overlap;
  double bin_width = PreparationConfig{}.match;                  ///< of the histograms along an axis [m]
  double step = RefinementConfig{}.coarse_reach / 2;             ///< of the exhaustive search along the third axis [m]
  double peak_separation = RefinementConfig{}.distinct_distance; ///< [m]
  int rival_votes = 0; ///< for a pose that is known: where less than a share of as many is promised, none are counted
  double least_score = 0; ///< with SearchPass::little_overlap: poses that score less are left out, [0, 1]
  VisibilityOptions visibility;
  Deadline deadline;                 ///< when it has passed no further line of shifts is looked at
  std::optional<ShiftWindow> window; ///< none: every translation
};

// With SearchPass::little_overlap poses are sought under which the scans share little. Where they share much, the most
// votes decide; where they do not, poses that lay one scan over the other have more votes than the truth, and only
// votes against them distinguish them from it. Then those go on which have the most votes for each one against them:
// how many there are of both depends on what the scans share, and on what has moved between them.

/// A pose that deserves a closer look.
struct PoseHypothesis {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double score = 0; ///< share of votes for, less the weighted share against; with SearchPass::little_overlap the share
                    ///< of votes for, over the number against and one
  int votes = 0;    ///< for it
};

/** \brief Places of a scan that vote on poses: drawn systematically from its patches so that every main direction is
 * represented, with equal weights.
 */
struct VotingSamples {
  Eigen::Matrix3Xf points;  ///< 3 x N [m]
  Eigen::Matrix3Xf normals; ///< unit, 3 x N
};

/** \brief Draw about \p count samples that stand for all of a scan, systematically, so that every main direction is
 * represented. A sample is drawn with the square root of its area, at most once; a direction gets a share that grows
 * with the square root of the sum of these. \return indices of the samples, grouped by main direction
 */
std::vector<Eigen::Index>
drawRepresentatives(const OrientedSamples& samples,
                    const std::vector<MainNormal>& main_normals,
                    int count,
                    double same_facing = PreparationConfig{}.same_facing);

/// Representatives as voting samples.
VotingSamples
drawVotingSamples(const OrientedSamples& samples,
                  const std::vector<MainNormal>& main_normals,
                  int count,
                  double same_facing = PreparationConfig{}.same_facing);

/** \brief The axes that searchTranslations() looks along, in the target frame: two along which the scans share most
 * surface, and the direction across both.
 * \param[in] min_cos a sample faces an axis when its normal is that parallel
 */
Eigen::Matrix3d
chooseSearchAxes(const OrientedSamples& source,
                 const OrientedSamples& target,
                 const std::vector<MainNormal>& target_main_normals,
                 const Eigen::Matrix3d& R_target_source,
                 double min_cos);

/// The histograms of two scans along an axis and their correlation, as searchTranslations() takes them.
struct AxisCorrelation {
  std::vector<HistogramOptions::Facing> facings; ///< forward and backward; either where normals have no sign
  std::vector<AxisHistogram> source;             ///< one per facing, of the square root of the surface, smoothed
  std::vector<AxisHistogram> target;             ///< one per facing
  Correlation sum;                               ///< of the correlations of all facings
};

/** \brief Correlate the scans along an axis; opposite faces are kept apart, their correlations added.
 * \param[in] source_axis the axis in the source frame, unit
 * \param[in] target_axis the same in the target frame
 */
AxisCorrelation
correlateAlongAxis(const OrientedSamples& source,
                   const OrientedSamples& target,
                   const Eigen::Vector3d& source_axis,
                   const Eigen::Vector3d& target_axis,
                   const PoseSearchOptions& options);

/// How searchTranslations() takes the \p count highest peaks of a correlation.
CorrelationOptions
searchPeakOptions(const PoseSearchOptions& options, int count);

/** \brief Translations for one rotation: correlation peaks along the two best observed axes (METHOD stages 9 to 11),
 * every shift along the third (METHOD, "Search": it is the axis with few planes on which the truth gets lost), judged
 * by votes of the samples. \return at most SearchPass::refined poses, distinct by peak_separation, best first
 */
std::vector<PoseHypothesis>
searchTranslations(const OrientedSamples& source,
                   const VotingSamples& votes,
                   const OrientedSamples& target,
                   const std::vector<MainNormal>& target_main_normals,
                   const PatchIndex& target_index,
                   const RangeImage* target_image,
                   const Eigen::Matrix3d& R_target_source,
                   const PoseSearchOptions& options);

} // namespace pcl_ssfr
