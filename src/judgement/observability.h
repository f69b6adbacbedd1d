// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "refinement/refinement.h"

#include <pcl_ssfr/result.h>

#include <vector>

namespace pcl_ssfr {

/// Options of the observability test.
struct ObservabilityOptions {
  // Information along a direction, relative to the best determined one of its kind:
  double min_translation = 0.005; ///< of a shift
  double min_rotation = 0.003;    ///< of a turn: long scenes tell the one about their axis by short levers
};

/** \brief Directions of motion that the matches leave undetermined: translations along directions that no matched
 * plane faces, rotations about axes that no lever arm binds (METHOD, "Where it fails").
 * \param[in] refinement with the Hessian of its last step; empty result when it had no matches
 */
std::vector<UnobservableDirection>
findUnobservableDirections(const Refinement& refinement, const ObservabilityOptions& options = {});

/** \brief Information matrix about the origin of the target frame, order (rotation [rad], translation [m]).
 *
 * The Hessian over the variance of the plane distances (at least \p noise_floor^2 [m^2]), divided by
 * \p samples_per_patch because the errors of points on one patch are not independent.
 * \param[in] origin position of the frame of the refinement in the target frame [m]
 */
Eigen::Matrix<double, 6, 6>
informationMatrix(const Refinement& refinement,
                  const Eigen::Vector3d& origin,
                  double noise_floor,
                  double samples_per_patch);

/// How well a turn is known.
struct RotationDeviation {
  double deviation = 0; ///< one standard deviation [rad]; infinite where nothing tells the turn
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ(); ///< unit, target frame
  double strength = 0; ///< information about it relative to the best determined turn, [0, 1]
};

/** \brief The turn that informationMatrix() and a prior together tell least about, whatever the place; the same for
 * every origin. The parameters are those of informationMatrix(). \param[in] prior information that is known of the
 * rotation otherwise, target frame [1/rad^2], symmetric and >= 0
 */
RotationDeviation
largestRotationDeviation(const Refinement& refinement,
                         double noise_floor,
                         double samples_per_patch,
                         const Eigen::Matrix3d& prior = Eigen::Matrix3d::Zero());

/// A small motion of the source about Refinement::centre: rotation [rad], then translation [m].
using SmallMotion = Eigen::Matrix<double, 6, 1>;

/// A direction in which a pose may move, and how well the matches tell it.
struct MotionStrength {
  SmallMotion motion; ///< moves the matched surface by about 1 m
  double strength;    ///< information about it relative to the best determined motion, [0, 1]
};

/** \brief The six independent motions, least determined first. Rotations are measured by how far they move the matched
 * surface, so that they can be compared with translations. Empty when there were no matches.
 */
std::vector<MotionStrength>
rankMotions(const Refinement& refinement);

} // namespace pcl_ssfr
