// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/pose_priors.h"
#include "judgement/posterior.h"
#include "judgement/scored_pose.h"
#include "judgement/visibility_score.h"
#include "profiles/patch_profile.h"
#include "refinement/refinement.h"

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/options.h>

#include <Eigen/Geometry>

#include <algorithm>

namespace pcl_ssfr {

/** \brief Two prepared scans and what is known of their pose: how a pose between them is judged and refined in the
 * default profile. Nothing in it changes, so many threads may use one. Poses are between the inner, centred frames.
 */
class PatchPair {
public:
  /// Scans and options must outlive it.
  /// \param[in] guess between the scans' own frames, may be nullptr
  PatchPair(const PatchScan& source,
            const PatchScan& target,
            const Options& options,
            const Eigen::Isometry3d* guess,
            const Deadline& deadline);

  const PosePriors&
  priors() const
  {
    return priors_;
  }
  /// Of the scene: the larger one of both scans.
  double
  scale() const
  {
    return scale_;
  }
  int
  threads() const
  {
    return threads_;
  }
  const Deadline&
  deadline() const
  {
    return deadline_;
  }
  bool
  outOfTime() const
  {
    return deadline_.hasPassed();
  }

  /// Whether contradictions can be seen at all, both ways.
  bool
  seesFreeSpace() const;

  /// The tuned numbers, all lengths scaled to the pair.
  const PatchProfileConfig&
  config() const
  {
    return config_;
  }
  /// Of the bins of histograms along an axis: what a match of scans of usual noise is good to [m].
  double
  binWidth() const
  {
    return options_.patch_profile.preparation.match * scale_;
  }
  /// As far as the polish looks for matches [m]: poses nearer than that are one, and noisy scans match from farther.
  double
  polishReach() const
  {
    return std::max(config_.refinement.distinct_distance, config_.preparation.match);
  }
  /// The posterior's numbers for what the sensors of this pair saw.
  PosteriorModel
  posteriorModel() const
  {
    return makePosteriorModel(config_.judgement, seesFreeSpace(), scale_);
  }
  const PatchScan&
  source() const
  {
    return source_;
  }
  const PatchScan&
  target() const
  {
    return target_;
  }
  const Options&
  options() const
  {
    return options_;
  }

  /// What counts as a match and as free space in the search for translations.
  VisibilityOptions
  searchTolerances() const;
  /// ... and for the score of refined poses.
  VisibilityOptions
  fineTolerances() const;

  /// What the surface of each scan meets in the other under a pose, normals in the target frame.
  SurfaceEvidence
  evidenceAt(const Eigen::Isometry3d& T_target_source, const VisibilityOptions& tolerances) const;

  /// Evidence and score of a pose before the fine refinement.
  void
  scoreCoarse(ScoredPose& pose) const;
  /// ... and after it.
  void
  scoreFine(ScoredPose& pose) const;

  /// A pose refined with the few patches that stand for all: from up to 0.5 m at scale 1.
  Eigen::Isometry3d
  refinedCoarse(const Eigen::Isometry3d& T_target_source) const;
  /// A pose refined with all patches: from up to 0.2 m at scale 1.
  Eigen::Isometry3d
  refinedFine(const Eigen::Isometry3d& T_target_source) const;

  /// Lay points of each scan onto the patches of the other, and move a finely judged pose there unless that walks away
  /// or explains less, or Options::refine is off. ScoredPose::polish is of the pose that it leaves.
  void
  polish(ScoredPose& pose) const;
  /// How the surfaces are laid onto each other where the pose is all but exact: one step of refineMutual().
  RefinementOptions
  lastStep() const;

  /// The matches of the polish at a pose, which stays where it is: the Refinement's pose is one step further.
  Refinement
  fitAt(const Eigen::Isometry3d& T_target_source) const;
  /// The same for a pose that other scans hold as well, so that matches as narrow as the noise allows are enough.
  MutualFit
  fitInMap(const Eigen::Isometry3d& T_target_source) const;

  /// Take a finely judged pose to where a refinement has led it, if it explains the scans about as well there, or
  /// better: a refinement may be drawn away by what moved, or by patches of few points. \return whether it moved
  bool
  moveUnlessWorse(ScoredPose& pose, const Eigen::Isometry3d& T_refined) const;

  /// Whether two poses count as one.
  bool
  isSamePlace(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;

  /// Whether a pose lays one sensor on the other. Then the patterns of their rays coincide, and with them what is wrong
  /// with the patches: more matches than the surface accounts for. Along a corridor that alone picks a place.
  bool
  laysSensorOnSensor(const Eigen::Isometry3d& T_target_source) const;

  /// From the scans' own frames to the inner ones, and back.
  Eigen::Isometry3d
  toInner(const Eigen::Isometry3d& T_target_source) const;
  Eigen::Isometry3d
  toOuter(const Eigen::Isometry3d& T_target_source) const;

private:
  ScanSurface
  sourceSurface() const;
  ScanSurface
  targetSurface() const;
  RefinementOptions
  polishOptions() const;
  /// How the matches of the polish follow the noise, for a pose that is held by more than they are.
  NoiseRule
  noiseRule() const;
  /// The plane distance of a match at a pose that its matches alone hold, \p wide ones as yet.
  double
  matchDistance(const Refinement& wide, const Eigen::Isometry3d& T_target_source) const;
  VisibilityOptions
  tolerances(double distance, double angle) const;
  void
  score(ScoredPose& pose, const VisibilityOptions& options) const;
  RefinementOptions
  refinement(double reach, double final_distance, double angle, int steps) const;

  const PatchScan& source_;
  const PatchScan& target_;
  const Options& options_;
  Deadline deadline_;
  double scale_;
  PatchProfileConfig config_;
  bool either_side_;
  int threads_;
  PosePriors priors_;
};

} // namespace pcl_ssfr
