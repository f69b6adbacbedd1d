// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "preparation/patch_index.h"
#include "preparation/range_image.h"
#include "refinement/refinement.h"
#include "search/pose_search.h"

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>
#include <pcl_ssfr/scan_view.h>
#include <pcl_ssfr/search_trace.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace pcl_ssfr {

/// A scan of a larger scale is hardly in metres, nor are two of which one reaches so many times as far as the other.
constexpr double kUnlikelyScale = 10;

/// One scan as the default profile needs it: patches, main normals, lookup, range image.
struct PatchScan {
  ScanExtent extent;
  double scale = 1;                                 ///< of the scene: 1 for rooms to streets, multiplies every length
  double leaf = 0;                                  ///< spacing that it was thinned to [m]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< subtracted from the points in double [m]
  bool viewpoint_used = false;                      ///< the viewpoint is used as given, or was found ...
  bool viewpoint_found = false;                     ///< ... in the points
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero(); ///< relative to origin [m]; zero when not used
  double thickness = 0;                                ///< that its patches may have [m]
  PlanarPatches patches;
  std::vector<MainNormal> main_normals;
  VotingSamples votes;
  PlanarPatches coarse; ///< a part of the patches that stands for all in the coarse refinement
  PatchIndex index;
  RangeImage range_image;   ///< empty when no viewpoint is used
  Eigen::Matrix3Xf clutter; ///< some points that are in no patch, relative to origin, 3 x N [m]
  SurfacePoints surface;    ///< points for the final polish, laid on the patches of the other scan
  std::vector<StageReport> stages;
  std::string unfinished; ///< stage in which the time ran out: nothing here may be used then; empty when complete

  /// What the sensor saw through; null when no viewpoint is used.
  const RangeImage*
  freeSpace() const
  {
    return range_image.empty() ? nullptr : &range_image;
  }
};

/** \brief Stages 1 to 5 of the default profile for one scan. Never fails on data: see PatchScan::extent and sizes.
 * \param[in] deadline when it passes meanwhile: see PatchScan::unfinished
 */
PatchScan
preparePatchScan(const ScanView& scan, const Options& options, const Deadline& deadline = Deadline());

/** \brief Stages 6 to 13 of the default profile: rotations, translations, visibility, refinement, selection.
 * \param[in] deadline when it passes meanwhile: Status::TimeLimit, with what was found so far; Options::time_limit is
 * not read
 * \param[out] trace what was proposed and looked at; may be null
 */
Result
registerPatchScans(const PatchScan& source,
                   const PatchScan& target,
                   const Options& options,
                   const Eigen::Isometry3d* guess,
                   const Deadline& deadline,
                   SearchTrace* trace);

/// The evidence for a pose between the scans' own frames, as the search rates what it refined. Candidate::probability
/// is left 0: it compares all poses of a pair. No evidence in a scan without patches.
Candidate
scorePatchPose(const PatchScan& source,
               const PatchScan& target,
               const Options& options,
               const Eigen::Isometry3d& T_target_source);

/// How the densest regions of the Gaussian sphere of a scan are found.
DensityOptions
patchDensityOptions(const Options& options);

} // namespace pcl_ssfr
