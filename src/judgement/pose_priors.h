// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/scored_pose.h"
#include "refinement/refinement.h"
#include "search/pose_search.h"

#include <pcl_ssfr/options.h>

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace pcl_ssfr {

/// How exact a pose is, when a prior judges it.
enum class Exactness {
  Proposed, ///< from main normals and a search: a refinement may still move it
  Refined,
};

/** \brief What is known of the pose of two scans beforehand: a vertical (Options::gravity) and a guess of known
 * tolerance (Options::guess_tolerance). Poses and rotations are between the inner, centred frames.
 */
class PosePriors {
public:
  /// \param[in] guess without it, or without Options::guess_tolerance, no guess bounds the pose
  /// \param[in] place of the source, inner frame [m]: translations are compared there
  /// \param[in] radius of the source [m]: a rotation moves it by so much per radian
  /// \param[in] config numbers for the pair, with its lengths
  PosePriors(const Options& options,
             const std::optional<Eigen::Isometry3d>& guess,
             const Eigen::Vector3d& place,
             double radius,
             const PatchProfileConfig& config);

  /// The guess that bounds the pose, if any.
  const std::optional<Eigen::Isometry3d>&
  guess() const
  {
    return guess_;
  }

  /// Whether a rotation keeps the vertical within its tolerance and what \p exactness allows for.
  bool
  keepVertical(const Eigen::Matrix3d& R_target_source, Exactness exactness) const;

  /// Whether a rotation agrees with all that is known.
  bool
  allow(const Eigen::Matrix3d& R_target_source, Exactness exactness) const;

  /// Whether a pose does.
  bool
  allow(const Eigen::Isometry3d& T_target_source, Exactness exactness) const;

  /// Drop the poses that do not.
  void
  dropExcluded(std::vector<ScoredPose>& poses, Exactness exactness) const;

  /** \brief Logarithm of the prior probability of a pose, up to a constant of the pair.
   *
   * A vertical and a guess of known tolerance are Gaussian: minus half a squared Mahalanobis distance. A guess without
   * a tolerance may be wrong: its weight over poses far from it is bounded (PriorConfig::guess_trust).
   */
  double
  logPrior(const Eigen::Isometry3d& T_target_source) const;

  /// Where the guess leaves the translation under a rotation, widened by \p margin [m]; none where no guess bounds the
  /// pose.
  std::optional<ShiftWindow>
  translationWindow(const Eigen::Matrix3d& R_target_source, double margin) const;

  /// The vertical for a refinement, if any.
  std::optional<KnownVertical>
  vertical() const;

  /// Information on the rotation [1/rad^2], target frame: the tolerance of a guess is one standard deviation, that of a
  /// vertical three.
  Eigen::Matrix3d
  rotationInformation() const;

private:
  double
  poseInformation(double deviation) const;
  double
  tiltDeviation() const;

  PriorConfig config_;
  std::optional<GravityPrior> gravity_;
  GuessTolerance tolerance_;               ///< read where there is a guess
  std::optional<Eigen::Isometry3d> guess_; ///< that bounds the pose
  std::optional<Eigen::Isometry3d> hint_;  ///< of no known tolerance
  double radius_;
  Eigen::Vector3d place_;
  double bound_deviations_;   ///< standard deviations of a vertical that its tolerance stands for
  double direction_error_;    ///< of a proposed rotation [rad]
  double translation_margin_; ///< of a proposed pose [m]
};

} // namespace pcl_ssfr
