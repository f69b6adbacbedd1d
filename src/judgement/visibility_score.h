// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "preparation/patch_index.h"
#include "preparation/range_image.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>

namespace pcl_ssfr {

/// Options of the visibility score (METHOD, "Evidence").
struct VisibilityOptions {
  PatchIndex::Tolerance match;
  float free_ratio = 0.95f;   ///< nearer than this share of the nearest return ...
  float free_margin = 0.3f;   ///< ... less this [m]: hangs in free space
  float hidden_ratio = 1.05f; ///< farther than this share of the farthest return ...
  float hidden_margin = 0.3f; ///< ... plus this [m]: hidden behind what was seen
};

/// Where a place lies in what a sensor saw.
enum class Visibility {
  Unseen,  ///< nothing was seen in its direction
  Free,    ///< in front of what was seen
  AtDepth, ///< where something was seen
  Hidden   ///< behind it
};

/// Of a place at \p range [m] in a direction that is free up to \p free and where the farthest return is at
/// \p farthest; see RangeImage.
inline Visibility
visibilityAt(float range, float free, float farthest, const VisibilityOptions& options)
{
  const bool is_free = range < options.free_ratio * free - options.free_margin;
  const bool is_hidden = !(range < options.hidden_ratio * farthest + options.hidden_margin);
  const Visibility seen = is_free ? Visibility::Free : is_hidden ? Visibility::Hidden : Visibility::AtDepth;
  return free == 0 ? Visibility::Unseen : seen;
}

/// \param[in] ray from the viewpoint of \p image to the place [m], of any length > 0
inline Visibility
visibilityAt(const Eigen::Vector3f& ray, const RangeImage& image, const VisibilityOptions& options)
{
  const std::size_t cell = image.cell(ray);
  return visibilityAt(ray.norm(), image.freeRange(cell), image.farthest(cell), options);
}

/// What a sample of some area [m^2] weighs: a patch is one observation, and a large one is hardly surer. By area a
/// floor would outvote all that distinguishes places.
inline double
voteOf(double area)
{
  return std::sqrt(std::sqrt(area));
}

/// Evidence for and against a pose, each sample weighted by voteOf() its area.
struct WeightedEvidence {
  double total = 0;        ///< of all samples
  double matched = 0;      ///< of those that meet a compatible patch
  double contradicted = 0; ///< of those that hang in front of what the other sensor saw through
  double unmatched = 0;    ///< of those in view, at the depth that was seen, where no compatible patch is
  double beyond = 0;       ///< of those matched that are in none of three planes; see beyondThreePlanes()

  /// Of those that meet a patch, or are where the other sensor saw something or through.
  double
  visible() const
  {
    return matched + unmatched + contradicted;
  }
  WeightedEvidence&
  operator+=(const WeightedEvidence& other);
  WeightedEvidence&
  operator*=(double factor);
};

/// The fate of the surface of a scan in the other scan; all in weight (square metres).
struct SurfaceEvidence {
  double total = 0;        ///< all of it
  double matched = 0;      ///< meets a compatible patch
  double contradicted = 0; ///< lies in front of what the other sensor saw through
  double unmatched = 0;    ///< in view, at the depth that was seen, but no compatible patch there
  // The rest is hidden, behind, or out of view: no evidence.
  /// Sum of weight n n^T in the target frame over the matched surface.
  Eigen::Matrix3d matched_normals = Eigen::Matrix3d::Zero();
  WeightedEvidence patches;
  /// The same of the samples that face their own sensor (kMinFacing); of these contradict only those that face the
  /// other sensor too: what is seen edge-on is easily missed.
  WeightedEvidence facing;
  double clutter = 0; ///< points that fit no plane and lie at the depth that was seen; see countAtDepth()

  SurfaceEvidence&
  operator+=(const SurfaceEvidence& other);
};

/** \brief Lay the samples into the scan behind \p index and \p image and collect the evidence for and against.
 * \param[in] T maps the samples into the frame of \p index
 * \param[in] image null: no free-space reasoning
 */
SurfaceEvidence
collectEvidence(const OrientedSamples& samples,
                const PatchIndex& index,
                const RangeImage* image,
                const Eigen::Isometry3d& T,
                const VisibilityOptions& options);

/** \brief Lay points into another scan and count those that lie within the depths that its sensor saw in their
 * direction.
 *
 * Needs no surface: leaves, wires and what sparse rings leave of things stand where they were seen, too.
 * \param[in] points 3 x N [m]
 * \param[in] T maps them into the frame of \p image, which may be empty: nothing was seen
 * \param[in] tolerance on both sides of the depths [m], >= 0
 */
std::size_t
countAtDepth(const Eigen::Matrix3Xf& points, const RangeImage& image, const Eigen::Isometry3d& T, float tolerance);

} // namespace pcl_ssfr
