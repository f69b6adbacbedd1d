// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/pose_priors.h"

#include "common/rotation_math.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr double kLeastDeviation = 1e-4; // [rad] of a prior: no scan is known to less

double
information(double deviation)
{
  return 1 / std::pow(std::max(deviation, kLeastDeviation), 2);
}

} // namespace

PosePriors::PosePriors(const Options& options,
                       const std::optional<Eigen::Isometry3d>& guess,
                       const Eigen::Vector3d& place,
                       double radius,
                       const PatchProfileConfig& config)
    : config_(config.judgement.prior), gravity_(options.gravity), radius_(radius), place_(place),
      bound_deviations_(config.judgement.uncertainty.bound_deviations), direction_error_(config.search.direction_error),
      translation_margin_(config.refinement.distinct_distance)
{
  if (guess && options.guess_tolerance) {
    guess_ = guess;
    tolerance_ = *options.guess_tolerance;
  }
  else
    hint_ = guess;
}

bool
PosePriors::keepVertical(const Eigen::Matrix3d& R_target_source, Exactness exactness) const
{
  if (!gravity_)
    return true;
  // Main normals err by no more than the margin of what is proposed, be the tolerance large or small.
  const double reach = exactness == Exactness::Proposed ? std::max(gravity_->tolerance, direction_error_)
                                                        : gravity_->tolerance + config_.pose_error;
  return keepsVertical(R_target_source, *gravity_, reach);
}

bool
PosePriors::allow(const Eigen::Matrix3d& R_target_source, Exactness exactness) const
{
  return keepVertical(R_target_source, exactness) &&
         (!guess_ ||
          angleBetween(guess_->linear(), R_target_source) <=
              tolerance_.rotation + (exactness == Exactness::Proposed ? direction_error_ : config_.pose_error));
}

bool
PosePriors::allow(const Eigen::Isometry3d& T_target_source, Exactness exactness) const
{
  const double margin = exactness == Exactness::Proposed ? translation_margin_ : 0;
  return allow(Eigen::Matrix3d(T_target_source.linear()), exactness) &&
         (!guess_ || translationBetween(T_target_source, *guess_, place_) <= tolerance_.translation + margin);
}

void
PosePriors::dropExcluded(std::vector<ScoredPose>& poses, Exactness exactness) const
{
  poses.erase(std::remove_if(poses.begin(),
                             poses.end(),
                             [&](const ScoredPose& pose) { return !allow(pose.T_target_source, exactness); }),
              poses.end());
}

std::optional<ShiftWindow>
PosePriors::translationWindow(const Eigen::Matrix3d& R_target_source, double margin) const
{
  if (!guess_)
    return std::nullopt;
  return ShiftWindow{*guess_ * place_ - R_target_source * place_, tolerance_.translation + margin};
}

/// Information on the rotation of a refined pose, which errs by itself [1/rad^2].
double
PosePriors::poseInformation(double deviation) const
{
  return 1 / (std::pow(deviation, 2) + std::pow(config_.pose_error, 2));
}

double
PosePriors::logPrior(const Eigen::Isometry3d& T_target_source) const
{
  double log_prior = 0;
  if (gravity_) {
    const double tilt = angleBetweenDirections(T_target_source.linear() * gravity_->up_source, gravity_->up_target);
    log_prior -= 0.5 * std::pow(tilt, 2) * poseInformation(gravity_->tolerance / bound_deviations_);
  }
  if (guess_)
    log_prior -= 0.5 * (std::pow(rotationBetween(T_target_source, *guess_), 2) * poseInformation(tolerance_.rotation) +
                        std::pow(translationBetween(T_target_source, *guess_, place_) / tolerance_.translation, 2));
  if (hint_) {
    const double distance =
        translationBetween(T_target_source, *hint_, place_) + radius_ * rotationBetween(T_target_source, *hint_);
    log_prior += std::log1p(config_.guess_trust / (1 + std::pow(distance / config_.guess_deviation, 2)));
  }
  return log_prior;
}

std::optional<KnownVertical>
PosePriors::vertical() const
{
  if (!gravity_)
    return std::nullopt;
  return KnownVertical{gravity_->up_source, gravity_->up_target, tiltDeviation()};
}

Eigen::Matrix3d
PosePriors::rotationInformation() const
{
  Eigen::Matrix3d known = Eigen::Matrix3d::Zero();
  if (guess_)
    known += information(tolerance_.rotation) * Eigen::Matrix3d::Identity();
  if (gravity_) {
    const Eigen::Vector3d up = gravity_->up_target.normalized();
    known += information(gravity_->tolerance / bound_deviations_) * (Eigen::Matrix3d::Identity() - up * up.transpose());
  }
  return known;
}

/// Standard deviation of the given vertical, comparable with what the matches claim of theirs [rad].
double
PosePriors::tiltDeviation() const
{
  return std::max(gravity_->tolerance / (bound_deviations_ * config_.match_inflation), kLeastDeviation);
}

} // namespace pcl_ssfr
