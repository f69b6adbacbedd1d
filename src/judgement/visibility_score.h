// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "preparation/patch_index.h"
#include "preparation/range_image.h"

#include <Eigen/Geometry>

namespace pcl_ssfr {

/// Options of the visibility score (METHOD points 6 and 13).
struct VisibilityOptions {
  PatchIndex::Tolerance match;
  float free_ratio = 0.95f;   ///< nearer than this share of the nearest return ...
  float free_margin = 0.3f;   ///< ... less this [m]: hangs in free space
  float hidden_ratio = 1.05f; ///< farther than this share of the farthest return ...
  float hidden_margin = 0.3f; ///< ... plus this [m]: hidden behind what was seen
  double min_facing = kMinFacing; ///< |cosine| between a normal and a line of sight from which on a sample faces that sensor
};

/// How loudly the samples of a scan speak for a pose and against it: each with the fourth root of its area [m^2]. A
/// patch is one observation, and large ones are hardly surer: by area a floor would outvote all that tells places
/// apart.
struct Voices {
  double total = 0;        ///< of all samples
  double matched = 0;      ///< of those that meet a compatible patch
  double contradicted = 0; ///< of those that hang in front of what the other sensor saw through

  Voices&
  operator+=(const Voices& other);
};

/// What becomes of the surface of a scan when it is laid into the other scan; all in weight (square metres).
struct SurfaceEvidence {
  double total = 0;        ///< all of it
  double matched = 0;      ///< meets a compatible patch
  double contradicted = 0; ///< hangs in front of what the other sensor saw through
  double unmatched = 0;    ///< in view, at the depth that was seen, but no compatible patch there
  // The rest is hidden, behind, or out of view: no evidence.
  /// Sum of weight n n^T in the target frame, over the matched surface and over all that gave evidence.
  Eigen::Matrix3d matched_normals = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d visible_normals = Eigen::Matrix3d::Zero();
  Voices voices;
  /// The same of the samples that face their own sensor (VisibilityOptions::min_facing); of these contradict only those
  /// that face the other sensor too: what is seen edge-on is easily missed.
  Voices facing;

  double
  visible() const
  {
    return matched + contradicted + unmatched;
  }
  SurfaceEvidence&
  operator+=(const SurfaceEvidence& other);
};

/** \brief Share of the visible surface that is matched, in the direction where that is least: in [0, 1].
 *
 * A wrong shift along one axis leaves the planes across the others matched; this looks at each direction by itself.
 * Directions that hardly any visible surface faces (under 2 % of it) are left out. 0 when nothing is visible.
 */
double
weakestMatchedShare(const SurfaceEvidence& evidence);

/** \brief Lay the samples into the scan behind \p index and \p image and collect the evidence for and against.
 * \param[in] T maps the samples into the frame of \p index \param[in] image null: no free-space reasoning
 */
SurfaceEvidence
collectEvidence(const OrientedSamples& samples,
                const PatchIndex& index,
                const RangeImage* image,
                const Eigen::Isometry3d& T,
                const VisibilityOptions& options);

} // namespace pcl_ssfr
