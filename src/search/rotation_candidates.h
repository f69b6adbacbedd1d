// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "directions/mean_shift.h"

#include <pcl_ssfr/paper_options.h>

#include <array>
#include <vector>

namespace pcl_ssfr {

/// A rotation that maps two main normals of the source onto two of the target.
struct RotationCandidate {
  Eigen::Matrix3d R_target_source = Eigen::Matrix3d::Identity(); ///< proper rotation
  std::array<int, 2> target_pair{{-1, -1}}; ///< main normals of the target that it was found by; -1: of a sweep
  double support = 0; ///< sum over matched main normals of min(source, target) support, each scan's supports
                      ///< normalised to sum 1; ranks merged candidates, [0, 1]
};

/** \brief How far the scans have two main normals in common: of all rotations, the most support of the main normals
 * that one lays on each other, but for those that face along the best supported of them.
 *
 * Little where ground meets ground.
 * \param[in] max_angle between two main normals that are one [rad]
 * \return of supports normalised to sum 1, [0, 1): 0 where there are none
 */
double
supportAcross(const std::vector<RotationCandidate>& rotations,
              const std::vector<MainNormal>& source,
              const std::vector<MainNormal>& target,
              double max_angle);

/// Whether some two of the main normals form a pair (RotationOptions::max_abs_cos): else they tell no rotation.
bool
hasPair(const std::vector<MainNormal>& normals, const RotationOptions& options);

/** \brief The rotation that best maps two source directions onto two target directions (METHOD stage 8).
 * Least squares over the two unit vectors; always proper (det = +1).
 */
Eigen::Matrix3d
rotationFromPairs(const Eigen::Vector3d& source_a,
                  const Eigen::Vector3d& source_b,
                  const Eigen::Vector3d& target_a,
                  const Eigen::Vector3d& target_b);

/** \brief All candidate rotations (METHOD stages 6 to 8): unordered pairs of source main normals against ordered
 * pairs of target main normals whose inner angles agree.
 *
 * With merge_angle > 0, candidates closer than it in SO(3) become one, refitted by a weighted SVD on every main
 * normal that it matches within refit_angle, and the list is ordered by descending support; otherwise the order is
 * that of the enumeration. Empty when either scan has no pair.
 * \param[in] threads >= 1; the bits do not depend on it
 */
std::vector<RotationCandidate>
proposeRotations(const std::vector<MainNormal>& source,
                 const std::vector<MainNormal>& target,
                 const RotationOptions& options,
                 unsigned threads = 1);

/** \brief Rotations about a direction that the scans share, all around it in equal steps: for scenes whose main normals
 * do not tell the rotation about it (one plane with things on it, a round hall).
 *
 * Each of the axes of the source is laid on each of those of the target; of rotations that meet, the first is kept.
 * \param[in] source_axes unit directions
 * \param[in] target_axes unit directions
 * \param[in] steps around, >= 1
 * \return empty when there is no axis in either scan
 */
std::vector<RotationCandidate>
sweepRotations(const std::vector<Eigen::Vector3d>& source_axes,
               const std::vector<Eigen::Vector3d>& target_axes,
               int steps);

} // namespace pcl_ssfr
