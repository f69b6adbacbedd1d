// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "refinement/refinement.h"

#include <pcl_ssfr/result.h>

#include <pcl_ssfr/patch_config.h>

#include <Eigen/Core>

#include <vector>

namespace pcl_ssfr {

/// A translation of the source along a direction of the target frame.
struct PrincipalTranslation {
  Eigen::Vector3d direction; ///< unit
  double strength;           ///< share of the surface that faces it, relative to the direction that most faces, [0, 1]
};

/// A rotation about an axis of the target frame, whatever the translation (marginalised over it).
struct PrincipalRotation {
  Eigen::Vector3d axis; ///< unit
  double deviation;     ///< standard deviation [rad]; infinite: nothing determines it
  double strength;      ///< information relative to the best determined rotation, [0, 1]
};

/// A small motion (rotation [rad], translation [m]) about PoseUncertainty::centre that moves the matched surface by
/// about 1 m (root mean square).
struct PrincipalMotion {
  Eigen::Matrix<double, 6, 1> motion;
  double deviation; ///< standard deviation of the surface along it [m]; infinite: nothing determines it
};

/** \brief How well a pose is known: by its matches and by what is known of its rotation beforehand.
 *
 * All of it is about small motions (w, v), order (rotation [rad], translation [m]), applied on the left about \ref
 * centre: x <- Exp(w) (x - centre) + centre + v.
 *
 * The covariance is that of a robust estimate whose data are correlated in groups (the sandwich estimate with
 * clusters): A^-1 B A^-1 with A the derivative of the summed gradient and B its covariance. B is not modelled but seen:
 * the gradients of single patches scatter about their sum, which is zero. So what is wrong with a whole patch, be it
 * noise, a tilt of few rings or a curved surface, counts once however many points the patch has. A match is counted
 * with its patch of the source and with that of the target. That overstates B, by two at most, about as much as the
 * fit understates it. Errors that all patches have in common, such as motion during a scan, are not seen.
 */
struct PoseUncertainty {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< frame of the refinement [m]
  /// Inverse of the covariance; zero along what nothing determines.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  /// Principal directions, least determined first; all empty when nothing matched.
  std::vector<PrincipalTranslation> translations; ///< 3, orthogonal
  std::vector<PrincipalRotation> rotations;       ///< 3, orthogonal
  std::vector<PrincipalMotion> motions;           ///< 6, independent

  /// Largest standard deviation of a rotation [rad]; infinite when nothing matched.
  double
  largestRotationDeviation() const;

  /// The information about the origin of another frame, which lies at \p origin of the frame of the refinement [m].
  Eigen::Matrix<double, 6, 6>
  informationAbout(const Eigen::Vector3d& origin) const;
};

/// Standard deviation of each patch and of each match, besides what is seen, where matches leave the root mean square
/// distance \p rms [m].
double
noiseFloor(const UncertaintyConfig& config, double rms);

/** \brief The uncertainty of a polished pose.
 * \param[in] polish of refineMutual(), with the statistics of its matches
 * \param[in] noise_floor see noiseFloor() [m], > 0: no fit is better known than that, be it exact
 * \param[in] rotation_prior what is known of the rotation otherwise: information [1/rad^2], target frame, symmetric
 * and >= 0
 * \param[in] sensors_coincide the pose lays one sensor on the other, and with them the patterns of their rays: lines of
 * points that pass for small tilted patches then match all along a corridor. So the translations are as the matches of
 * surface that faces its sensor determine them, the others with their share of the curvature
 * (UncertaintyConfig::unseen_curvature)
 */
PoseUncertainty
poseUncertainty(const Refinement& polish,
                double noise_floor,
                const Eigen::Matrix3d& rotation_prior = Eigen::Matrix3d::Zero(),
                bool sensors_coincide = false);

/// Directions that the scene leaves undetermined: translations that hardly any matched surface faces, then rotations
/// that are not known well enough. Least determined first of each kind; empty when nothing matched.
std::vector<UnobservableDirection>
unobservableDirections(const PoseUncertainty& uncertainty, const UncertaintyConfig& config = {});

/// The motions along which neighbouring optima are worth a look, least determined first: those along which the standard
/// deviation of the matched surface is above \p deviation [m].
std::vector<PrincipalMotion>
motionsToExplore(const PoseUncertainty& uncertainty, double deviation);

} // namespace pcl_ssfr
