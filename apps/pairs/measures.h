// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How far a pose is from the truth.
struct PoseError {
  double rotation_deg = 0;  ///< angle of the rotation that is left [deg]
  double translation_m = 0; ///< distance between where the two poses put the reference point [m]
};

/** \brief Compare a pose with the truth.
 * \param[in] reference point of the source frame at which the translation is taken: its sensor, so that neither a
 * rotated frame nor a far map origin changes the figure
 */
PoseError
poseError(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth, const Eigen::Vector3d& reference);

/// A bound on both errors within which a pose counts as right.
struct SuccessBound {
  double rotation_deg;
  double translation_m;
};

/// The bounds that every dataset is judged by, besides its own; from a usable start to a survey.
constexpr std::array<SuccessBound, 4> kSuccessBounds{{{15, 0.3}, {5, 2}, {2, 0.3}, {1, 0.1}}};

bool
isWithin(const PoseError& error, const SuccessBound& bound);

/** \brief Sums over correspondences fixed at the ground truth (source point p, target point q), from which the RMSE of
 * any pose follows exactly: the paper's measure without keeping the points.
 */
struct CorrespondenceSums {
  double count = 0;
  Eigen::Vector3d mean_source = Eigen::Vector3d::Zero(); ///< [m]
  Eigen::Vector3d mean_target = Eigen::Vector3d::Zero(); ///< [m]
  double source_spread = 0;                              ///< sum of squared distances to the mean [m^2]
  double target_spread = 0;                              ///< the same of the targets [m^2]
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();       ///< sum of (q - mean)(p - mean)^T [m^2]
};

/// The sums over the columns of two 3 x N matrices [m].
CorrespondenceSums
sumCorrespondences(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target);

/// Root mean square distance of the correspondences under a pose [m]; NaN without any.
double
rmseOf(const CorrespondenceSums& sums, const Eigen::Isometry3d& T_target_source);

/// An interval that holds a rate.
struct Interval {
  double low = 0;
  double high = 1;
};

/// Wilson's 95 % confidence interval of a rate, after \p successes of \p trials; [0, 1] without any trial.
Interval
wilsonInterval(std::size_t successes, std::size_t trials);

/** \brief The value below which a share of the finite values lies, linear between neighbours (as in NumPy); NaN of
 * none.
 * \param[in] share [0, 1]
 */
double
quantile(std::vector<double> values, double share);

/// An answer of a method: how sure it was, and whether it was right.
struct JudgedAnswer {
  double confidence = 0;
  bool right = false;
};

/// What accepting all answers from a confidence on gives.
struct PrecisionRecall {
  double confidence = 0; ///< smallest accepted
  double precision = 0;  ///< right among the accepted
  double recall = 0;     ///< right and accepted among all pairs
};

/** \brief Precision against recall over the confidence, from the surest answer down: one point for each confidence
 * that occurs.
 * \param[in] pairs number of pairs tried, those without an answer included
 */
std::vector<PrecisionRecall>
precisionRecall(std::vector<JudgedAnswer> answers, std::size_t pairs);

/** \brief Mean of -log(probability that was stated for what came true); NaN of none. Confidences count as at least
 * 1e-4 and at most 1 - 1e-4: one false certainty does not outweigh all else.
 */
double
logLoss(const std::vector<JudgedAnswer>& answers);

/// Expected calibration error: the mean difference of confidence and share of right answers over ten bins of equal
/// width, weighted by their answers, [0, 1]; NaN of none.
double
calibrationError(const std::vector<JudgedAnswer>& answers);

} // namespace apps
} // namespace pcl_ssfr
