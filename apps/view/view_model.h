// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "profiles/paper_profile.h"
#include "profiles/patch_profile.h"
#include "search/pose_search.h"
#include "search/rotation_candidates.h"

#include <apps/view/view_run.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A pose to look at.
struct ViewedPose {
  std::string name;       ///< for captions: "candidate 2", "the truth"
  std::string short_name; ///< for tables: "2", "truth"
  bool is_truth = false;
  Candidate candidate;            ///< in file coordinates, judged
  std::optional<PoseError> error; ///< to the truth, where it is known
  bool right = false;             ///< within the bound
  double moved = 0;               ///< by how far it moves the point at which errors are taken [m]
};

/// What becomes of a piece of surface that is laid into the other scan.
enum class SurfaceFate {
  Matched,      ///< meets a compatible patch
  Contradicted, ///< hangs where the other sensor saw free space
  Unmatched,    ///< in view of the other sensor, but nothing like it is there
  Unseen        ///< hidden, behind, or out of view: says nothing
};

/// The fates of one scan's samples and what they weigh.
struct SurfaceFates {
  std::vector<SurfaceFate> each;               ///< one a sample
  std::array<double, 4> surface{{0, 0, 0, 0}}; ///< by SurfaceFate [m^2]

  double
  total() const
  {
    return surface[0] + surface[1] + surface[2] + surface[3];
  }
};

/// The Gaussian sphere of a scan, as the method made it.
struct SphereView {
  DirectionSet directions; ///< in the frame of the scan
  std::vector<DenseRegion> regions;
  std::vector<MainNormal> main_normals;
  double radius = 0; ///< r_d, chord
};

/// A translation along an axis, tried while the other two stay as they are under the pose.
struct ShiftScore {
  double offset = 0;       ///< from the pose [m]
  double matched = 0;      ///< share of the surface of both scans
  double contradicted = 0; ///< share of the surface of both scans
};

/// One of the three axes along which a pose's translation is looked for.
struct AxisView {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX(); ///< unit, target frame
  AxisCorrelation correlation;
  std::vector<ShiftPeak> peaks;     ///< best first; as many as the search tries, none where it tries every shift
  bool every_shift = false;         ///< the search does not rely on peaks here
  double shift = 0;                 ///< of the pose [m]
  std::optional<double> true_shift; ///< that the truth has along this axis [m]
  std::vector<ShiftScore> scores;
};

/// One step at which the truth may get lost.
struct LossStep {
  std::string stage;
  bool passed = false;
  std::string finding; ///< one sentence with figures
};

/// One pass of the search, as the trace of the registration and its own functions show it.
struct ViewedPass {
  PoseSearchOptions options;                ///< of searchTranslations()
  std::vector<MainNormal> target_normals;   ///< main normals, with the vertical where it is given
  std::vector<RotationCandidate> rotations; ///< that were searched, best supported first
  std::vector<PoseHypothesis> poses;        ///< between the patches of the scans, most votes first
  std::size_t refined = 0;                  ///< so many of the poses were refined
};

/// A pose as the registration scores it, without the polish: between the clouds. \p refine refines it first.
Candidate
scoredPose(const PatchScan& source,
           const PatchScan& target,
           const Eigen::Isometry3d& T_target_source,
           const Options& options,
           bool refine);

/// Everything about a run that its result does not keep, computed again with the method's own functions.
class ViewModel {
public:
  /// \throw std::invalid_argument options out of range
  explicit ViewModel(ViewRun run, std::size_t candidate);

  const ViewRun&
  run() const
  {
    return run_;
  }
  const Result&
  result() const
  {
    return run_.report.run.result;
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
  /// Candidates in their order, then the truth where it is known; never empty.
  const std::vector<ViewedPose>&
  poses() const
  {
    return poses_;
  }
  /// The pose to show closely.
  std::size_t
  chosen() const
  {
    return chosen_;
  }
  const ViewedPose&
  chosenPose() const
  {
    return poses_[chosen_];
  }
  /// The truth, null when it is not known.
  const ViewedPose*
  truth() const;

  /// Whether the stages shown are those of the method of the run; else they are what the default profile sees.
  bool
  isOwnMethod() const;
  bool
  isPaperProfile() const
  {
    return paper_source_.has_value();
  }

  /// Where up is in the frame of the target: gravity when it is given, else the floor's direction. Unit.
  Eigen::Vector3d
  up() const;

  SphereView
  sphere(bool of_source) const;

  /// The axes of a pose; their scores are left out when \p with_scores is false (they take the longest).
  std::array<AxisView, 3>
  axes(const ViewedPose& pose, bool with_scores) const;

  /// The fates of the source's patches laid into the target, or the other way round.
  SurfaceFates
  fates(const ViewedPose& pose, bool of_source) const;

  /// Stage by stage whether the truth was still there; empty when it is not known or the method is another.
  std::vector<LossStep>
  findLoss() const;

  /// A pose between the patches of the scans (relative to PatchScan::origin) from one between files.
  Eigen::Isometry3d
  toPatches(const Eigen::Isometry3d& T_files) const;

  /// Points of a scan in file coordinates from its patches.
  Eigen::Vector3d
  sourceOffset() const
  {
    return run_.source.offset + source_.origin;
  }
  Eigen::Vector3d
  targetOffset() const
  {
    return run_.target.offset + target_.origin;
  }

  /// Of the caller: 0 is all processors.
  unsigned
  threads() const
  {
    return options_.threads;
  }

private:
  void
  traceSearch();
  void
  addPoses();
  ViewedPose
  judged(const Eigen::Isometry3d& T_files, const Candidate* known) const;
  /// Poses between clouds (without their offsets), as the library takes them.
  Eigen::Isometry3d
  toClouds(const Eigen::Isometry3d& T_files) const;
  std::array<AxisView, 3>
  patchAxes(const Eigen::Matrix3d& R) const;
  std::array<AxisView, 3>
  paperAxes(const Eigen::Matrix3d& R) const;
  std::vector<ShiftScore>
  scoresAlong(const Eigen::Isometry3d& T_patches, const Eigen::Vector3d& axis) const;
  std::vector<LossStep>
  findPatchLoss() const;
  /// Whether a pass proposed the true rotation, the true shifts under it, and a pose near the truth.
  std::vector<LossStep>
  passSteps(const ViewedPass& search, const std::string& suffix) const;
  LossStep
  shiftStep(const ViewedPass& search, const Eigen::Matrix3d& R, const Eigen::Vector3d& axis, int tried) const;
  LossStep
  voteStep(const ViewedPass& search, const Eigen::Matrix3d& R) const;
  LossStep
  planStep() const;
  LossStep
  refinementStep() const;
  std::vector<LossStep>
  findPaperLoss() const;
  LossStep
  selectionStep() const;

  ViewRun run_;
  Options options_; ///< that the patches are prepared with
  PatchScan source_;
  PatchScan target_;
  std::optional<PaperScan> paper_source_;
  std::optional<PaperScan> paper_target_;
  std::vector<ViewedPass> passes_;
  /// Poses by plan views, between the patches of the scans, most votes first, and whether they were refined.
  std::vector<std::pair<Eigen::Isometry3d, bool>> plan_poses_;
  std::array<std::vector<MainNormal>, 2> normals_; ///< of source and target, with the vertical where it is given
  std::vector<ViewedPose> poses_;
  std::size_t chosen_ = 0;
};

} // namespace apps
} // namespace pcl_ssfr
