// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "preparation/patch_index.h"
#include "preparation/planar_patches.h"
#include "refinement/plane_equations.h"
#include "refinement/robust_scale.h"

#include <pcl_ssfr/deadline.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ssfr {

/// A vertical that is known in both scans: where the matches tell the tilt worse than it does, a refinement keeps it.
struct KnownVertical {
  Eigen::Vector3d up_source = Eigen::Vector3d::UnitZ(); ///< unit, source frame
  Eigen::Vector3d up_target = Eigen::Vector3d::UnitZ(); ///< unit, target frame
  /// Standard deviation of the tilt between them [rad], > 0, as if the distances of all matches erred independently:
  /// the less they do, the smaller it is to be.
  double deviation = 0.01;
};

/// Options of the robust plane-to-plane refinement (METHOD, "Refinement").
struct RefinementOptions {
  PatchIndex::Tolerance match;                       ///< of the first step; distances shrink from step to step
  double final_distance = 0.05;                      ///< plane distance allowed in the last step [m], > 0
  int steps = 8;                                     ///< >= 1
  double least_rms = RefinementConfig{}.match_noise; ///< what matches are good to, at best [m], > 0
  double unseen_curvature = UncertaintyConfig{}.unseen_curvature; ///< share of matches that do not face their sensor
  double min_step = 1e-5;                ///< stop when a step at the final distance is smaller ([m] and [rad])
  int threads = 1;                       ///< of refineMutual(), >= 1; the bits do not depend on it
  Deadline deadline;                     ///< no further step when it has passed; one is always made
  std::optional<KnownVertical> vertical; ///< none: the matches alone tell the pose
};

/// A refined pose and the linear system of its last step.
struct Refinement {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  /// Sum of weight J J^T with J = [p x n; n], p relative to \ref centre: rotation [rad], translation [m]. Of the
  /// matches alone: without a known vertical.
  Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< mean place of the source at the start, target frame [m]
  double rms = 0;                                   ///< weighted root mean square plane distance of the matches [m]
  EquationStatistics statistics;                    ///< at the pose, about the centre; zero but of refineMutual()
  Eigen::Index matches = 0;
  int steps = 0;
};

/** \brief Refine a pose by robust point-to-plane steps, patches of the source onto planes of the target.
 *
 * Each patch counts with the square root of its area, taken as an evenly covered flat rectangle, so that large patches
 * also bind the rotation: what is wrong with a patch is wrong with all of it, so four times the area does not tell four
 * times as much. Motions that the matches leave free are not moved. With fewer than 3 matches the pose stays.
 */
Refinement
refinePatches(const PlanarPatches& source,
              const PatchIndex& target,
              const Eigen::Isometry3d& T_target_source,
              const RefinementOptions& options);

/// Points on the surface of a scan, for the final polish.
struct SurfacePoints {
  Eigen::Matrix3Xf points;           ///< 3 x N [m]
  Eigen::Matrix3Xf normals;          ///< unit, 3 x N
  std::vector<std::int32_t> patches; ///< the patch that each lies on: its index in the scan's PlanarPatches, N
  std::vector<std::uint8_t> facing;  ///< of each patch of the scan: 1 when it faces its sensor (kMinFacing), else 0
};

/// Evenly strided points of every patch with the patch's normal: \p drawn_of_group (>= 0) for each \p group (>= 1) of
/// its points that it begins, but no more than it has. Where that gives more than \p most of all patches together (>=
/// 0; 0: any number), groups are twice as large, or four times and so on, until every patch begins one only: it lends
/// \p drawn_of_group at least.
SurfacePoints
drawSurfacePoints(const ThinnedCloud& cloud, const PlanarPatches& patches, int drawn_of_group, int group, int most = 0);

/// What a scan brings to the final polish: its points, and the planes that those of the other scan are laid onto.
struct ScanSurface {
  const SurfacePoints& points;
  const PatchIndex& planes;
};

/** \brief The final polish: points of each scan onto the planes of the other, both ways in one system.
 *
 * Patches that do not face their sensor are lines of points that noise spreads to a plane. Lines of one sensor lie
 * alike in every scan and find partners at any pose: they take part in the steps, but Refinement::statistics counts a
 * share of their curvature only (UncertaintyConfig::unseen_curvature).
 */
Refinement
refineMutual(const ScanSurface& source,
             const ScanSurface& target,
             const Eigen::Isometry3d& T_target_source,
             const RefinementOptions& options);

/// The plane distance of a match that follows from the noise of the matches of the polish at a pose. Of the options
/// those are read that fitMutual() reads.
double
mutualMatchDistance(const ScanSurface& source,
                    const ScanSurface& target,
                    const Eigen::Isometry3d& T_target_source,
                    const RefinementOptions& options,
                    const NoiseRule& rule);

/// The matches of two scans at a pose, linearised there.
struct MutualFit {
  Refinement refinement;                                                      ///< of no steps
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero(); ///< sum of weight distance J
  std::vector<PatchSum> patches; ///< of each patch of the source, then of the target
  double match_distance = 0;     ///< plane distance of a match, twice the robust scale [m]
  double wide_weight = 0;        ///< of all matches within NoiseRule::most, its half the robust scale
  double wide_rms = 0;           ///< root mean square plane distance of those [m]
};

/// The matches of the polish at a pose, as far apart as \p rule says. Start, number and end of steps and the final
/// distance are not read from the options, nor is a vertical.
MutualFit
fitMutual(const ScanSurface& source,
          const ScanSurface& target,
          const Eigen::Isometry3d& T_target_source,
          const RefinementOptions& options,
          const NoiseRule& rule);

/// Small motion (w, v) as a rigid transform: rotation by w [rad], then translation by v [m].
Eigen::Isometry3d
expSe3(const Eigen::Matrix<double, 6, 1>& motion);

} // namespace pcl_ssfr
