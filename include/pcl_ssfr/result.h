// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// Why a registration ended as it did. Only Status::Converged means that the pose may be used.
enum class Status {
  NotRun,           ///< nothing was computed yet
  Converged,        ///< a pose was found and accepted
  InvalidInput,     ///< a cloud is missing or an option is out of range
  TooFewPoints,     ///< too few finite points in one of the scans
  TooFewDirections, ///< fewer than two main normals that are not parallel, and nothing else determines the rotation
  NoCandidate,      ///< no pose that fits the scans' main normals lays surfaces of the two on each other
  Ambiguous,        ///< several distinct poses explain the scans about equally well (symmetry, repetition)
  Unobservable,     ///< the scene does not determine a direction of motion (corridor without an end)
  LowOverlap,       ///< the best pose lays too little of the scans on each other: probably unrelated
  Contradicted,     ///< the best pose puts surfaces where the other sensor saw free space
  TimeLimit         ///< the time limit ran out before the search was complete: candidates hold what was found so far
};

/// The enumerator's name in snake_case, as in the JSON output ("converged", "too_few_directions", ...).
PCL_SSFR_EXPORT const char*
toString(Status status);

/// What went into and came out of one stage, and how long it took.
struct StageReport {
  std::string name;            ///< the stage, that of a scan with "source " or "target " before it
  double seconds = 0;          ///< wall clock [s]
  std::uint64_t count_in = 0;  ///< things that went in: points, directions, rotations, poses, ...
  std::uint64_t count_out = 0; ///< things that came out
};

/// Evidence about one pose beyond overlap and contradiction; what the confidence is computed from.
struct CandidateEvidence {
  /// Share of the patches, each weighted by the fourth root of its area, that met a compatible patch, [0, 1].
  double patches_matched = 0;
  /// Share of the patches, weighted likewise, that lie in the other sensor's free space, [0, 1].
  double patches_contradicted = 0;
  /// As patches_matched, of those patches alone that face their own sensor: a line of points, which noise spreads to a
  /// plane through the sensor, is left out.
  double facing_matched = 0;
  double beyond_planes = 0; ///< of these, the ones in none of the three planes that determine the pose
  double facing_score = 0;  ///< as Candidate::score, of those patches alone that face their own sensor
  double unmatched = 0; ///< share of the surface that is in view of the other sensor but met nothing compatible, [0, 1]
  double third_direction =
      0;                  ///< matched surface that faces the direction that least of it faces, share of all, [0, 1/3]
  double held_second = 0; ///< matched surface that faces the direction which the second largest share faces [m^2]
  double held_third = 0;  ///< matched surface that faces the direction which the least of it faces [m^2]
  double clutter = 0;     ///< points that fit no plane and lie at the depth that the other sensor saw there
  double patches = 0;     ///< of both scans, each weighted by the fourth root of its area [m^0.5]
  double facing_patches = 0; ///< of these, those that face their own sensor
};

/// A pose that was considered, with the evidence for and against it.
struct Candidate {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< maps source points into the target frame
  double probability = 0;   ///< that this pose is the right one, [0, 1]; Profile::Default only
  double score = 0;         ///< evidence for the pose less the evidence against it, comparable within one registration
  double overlap = 0;       ///< share of the surface that met its counterpart, [0, 1]
  double contradiction = 0; ///< share of the surface that lies in the other sensor's free space, [0, 1]
  /// Root mean square distance of the matches [m], as Result::rmse; 0 for candidates that were not polished.
  double rmse = 0;
  CandidateEvidence evidence; ///< default profile only
  bool from_guess = false;    ///< the caller's initial guess (refined), not found by the method
};

/// Whether the evidence for a pose is no worse than that for another one near it: it scores no less, and its matches
/// lie no farther apart. A pose that a local refiner made of ours is worth keeping then, and only then. Both are to be
/// from scorePose(): candidates that were not polished have no rmse.
inline bool
isNoWorse(const Candidate& pose, const Candidate& than)
{
  return pose.score >= than.score && pose.rmse <= than.rmse;
}

/// A direction of motion that the scene does not determine.
struct UnobservableDirection {
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero(); ///< unit, target frame: translation along it, or rotation about it
  bool rotation = false;       ///< true: a rotation about \ref direction; false: a translation along it
  double strength = 0; ///< information along it relative to the best determined one of its kind, [0, 1]; 0 where
                       ///< probable poses differ by it (Status::Ambiguous)
};

/// All that a registration found. Safe to use as constructed: identity pose, not run.
struct Result {
  Status status = Status::NotRun; ///< why it ended
  std::string message;            ///< one sentence for people: what was found, or why nothing was accepted
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< best pose; meaningful when accepted
  double overlap = 0;                                                ///< of the best pose, [0, 1]
  double contradiction = 0;                                          ///< of the best pose, [0, 1]
  /// Estimated probability that the pose is right, [0, 1]. Profile::Paper2017 estimates none and leaves 0.
  double confidence = 0;
  /// Probability that none of the candidates is right; with those of the candidates it sums to 1. Profile::Default
  /// only.
  double probability_of_none = 1;
  double rmse = 0; ///< root mean square point-to-plane distance over the inliers [m]
  /// Maximum correspondence distance for a local refiner (ICP, GICP) that starts from this pose [m]: how far apart
  /// corresponding points may lie, from the residuals of the matches, the uncertainty of the pose and the spacing of
  /// the points (docs/METHOD.md, "Correspondence distance"). Clouds thinned more coarsely than the leaf of the scans
  /// need more. 0 when no pose was judged, and with Profile::Paper2017.
  double correspondence_distance = 0;
  /// Information matrix (inverse covariance) of the pose, order (rotation [rad], translation [m]): a small motion
  /// (w, v) applied on the left about the target's origin, T <- Exp(w, v) T. Zero when nothing was judged.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<Candidate> candidates;               ///< distinct poses, best first; the first is T_target_source
  std::vector<UnobservableDirection> unobservable; ///< directions that the scene does not determine
  /// In order of execution; those of a prepared scan are from its preparation, maybe for an earlier registration.
  std::vector<StageReport> stages;
  bool source_viewpoint_used = false;  ///< the source's normals and free space follow from a position of its sensor
  bool target_viewpoint_used = false;  ///< the same of the target
  bool source_viewpoint_found = false; ///< that position was estimated from the points, not given
  bool target_viewpoint_found = false; ///< the same of the target
  Eigen::Vector3d source_viewpoint = Eigen::Vector3d::Zero(); ///< that position, source frame [m]; zero when not used
  Eigen::Vector3d target_viewpoint = Eigen::Vector3d::Zero(); ///< the same of the target, target frame [m]

  /// Whether the pose may be used: the status is Status::Converged.
  bool
  accepted() const
  {
    return status == Status::Converged;
  }
};

} // namespace pcl_ssfr
