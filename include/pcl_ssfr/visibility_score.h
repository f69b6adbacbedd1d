// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/patch_index.h>
#include <pcl_ssfr/range_image.h>
#include <pcl_ssfr/types.h>

#include <Eigen/Geometry>

namespace pcl_ssfr {

/// Options of the visibility score (METHOD points 6 and 13).
struct VisibilityOptions {
  PatchIndex::Tolerance match;
  float free_ratio = 0.95f;  ///< nearer than this share of the nearest return ...
  float free_margin = 0.3f;  ///< ... less this [m]: hangs in free space
  float hidden_ratio = 1.05f; ///< farther than this share of the farthest return ...
  float hidden_margin = 0.3f; ///< ... plus this [m]: hidden behind what was seen
};

/// What becomes of one scan's surface when it is laid into the other scan; all in weight (square metres).
struct SurfaceEvidence {
  double total = 0;        ///< all of it
  double matched = 0;      ///< meets a compatible patch
  double contradicted = 0; ///< hangs in front of what the other sensor saw through
  double unmatched = 0;    ///< in view, at the depth that was seen, but no compatible patch there
  // The rest is hidden, behind, or out of view: no evidence.

  SurfaceEvidence&
  operator+=(const SurfaceEvidence& other)
  {
    total += other.total;
    matched += other.matched;
    contradicted += other.contradicted;
    unmatched += other.unmatched;
    return *this;
  }
};

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
