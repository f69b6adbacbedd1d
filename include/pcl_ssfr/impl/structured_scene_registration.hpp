// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/impl/cloud_access.hpp>
#include <pcl_ssfr/impl/registration_adaptor.hpp>
#include <pcl_ssfr/impl/registration_support.h>
#include <pcl_ssfr/structured_scene_registration.h>

#include <algorithm>
#include <exception>
#include <string>
#include <tuple>

namespace pcl_ssfr {

template <typename PointSource, typename PointTarget, typename Scalar>
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::StructuredSceneRegistration()
    : Adaptor("StructuredSceneRegistration", SearchOptions().max_refinement_steps),
      options_(makeOptions(Profile::Default))
{}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setNormalRadius(double radius)
{
  changeOptions("setNormalRadius", [&](Options& options) { options.normal_radius = radius; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setDensityRadius(double chord)
{
  changeOptions("setDensityRadius", [&](Options& options) { options.density_radius = chord; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setBinWidth(double width)
{
  changeOptions("setBinWidth", [&](Options& options) { options.bin_width = width; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setProfile(Profile profile)
{
  changeOptions("setProfile", [&](Options& options) { options.profile = profile; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setNumberOfThreads(unsigned threads)
{
  changeOptions("setNumberOfThreads", [&](Options& options) { options.threads = threads; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setViewpointMode(ViewpointMode mode)
{
  changeOptions("setViewpointMode", [&](Options& options) { options.viewpoint_mode = mode; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setSourceViewpoint(const Eigen::Vector3d& position)
{
  setViewpoint("setSourceViewpoint", position, source_viewpoint_, prepared_source_);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setTargetViewpoint(const Eigen::Vector3d& position)
{
  setViewpoint("setTargetViewpoint", position, target_viewpoint_, prepared_target_);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearViewpoints()
{
  if (source_viewpoint_) {
    prepared_source_ = PreparedScan();
  }
  if (target_viewpoint_) {
    prepared_target_ = PreparedScan();
  }
  source_viewpoint_.reset();
  target_viewpoint_.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setGravity(const Eigen::Vector3d& up_source,
                                                                          const Eigen::Vector3d& up_target,
                                                                          double tolerance)
{
  const std::optional<GravityPrior> gravity = detail::gravityPrior(up_source, up_target, tolerance);
  if (!gravity) {
    detail::reportError(getClassName(),
                        "setGravity",
                        "directions must be finite and not 0, the tolerance in (0, pi]; the old value is kept");
    return;
  }
  options_.gravity = gravity;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearGravity()
{
  options_.gravity.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setGuessTolerance(double rotation, double translation)
{
  changeOptions("setGuessTolerance", [&](Options& options) {
    options.guess_tolerance = GuessTolerance{rotation, translation};
  });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearGuessTolerance()
{
  options_.guess_tolerance.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setRefinement(bool refine)
{
  options_.refine = refine;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setTimeLimit(double seconds)
{
  changeOptions("setTimeLimit", [&](Options& options) { options.time_limit = seconds; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setOptions(const Options& options)
{
  if (!detail::acceptOptions(getClassName(), "setOptions", options)) {
    return;
  }
  options_ = options;
  max_iterations_ = options.max_refinement_steps;
  corr_dist_threshold_ = options.overlap_radius > 0 ? options.overlap_radius : detail::kUnsetCorrespondenceDistance;
}

template <typename PointSource, typename PointTarget, typename Scalar>
Options
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::getOptions() const
{
  Options options = options_;
  options.refine = options_.refine && max_iterations_ > 0;
  options.max_refinement_steps = std::max(max_iterations_, 1);
  options.overlap_radius = this->maxCorrespondenceDistance();
  return options;
}

template <typename PointSource, typename PointTarget, typename Scalar>
typename StructuredSceneRegistration<PointSource, PointTarget, Scalar>::Answer
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::findPose(const std::optional<Eigen::Isometry3d>& guess)
{
  const Deadline deadline = Deadline::after(options_.time_limit);
  const Options options = getOptions();
  Answer answer;
  try {
    prepare(options, deadline);
    result_ = registerScans(prepared_source_, prepared_target_, options, guess ? &*guess : nullptr, deadline);
    for (PreparedScan* scan : {&prepared_source_, &prepared_target_}) {
      if (!scan->isComplete()) {
        *scan = PreparedScan();
      }
    }
  }
  catch (const std::exception& error) {
    forgetSource();
    forgetTarget();
    reject(error.what());
    detail::reportError(getClassName(), "align", error.what());
    return answer;
  }
  answer.is_accepted = result_.accepted();
  answer.T_target_source = result_.T_target_source;
  answer.iterations = static_cast<int>(result_.candidates.size());
  answer.inlier_distance = options.overlap_radius;
  answer.rmse = result_.rmse;
  return answer;
}

template <typename PointSource, typename PointTarget, typename Scalar>
std::optional<Candidate>
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::scorePose(const Matrix4& T_target_source)
{
  const std::optional<Eigen::Isometry3d> T = detail::rigidGuess(T_target_source.template cast<double>());
  if (!T || !input_ || !target_) {
    detail::reportError(
        getClassName(), "scorePose", T ? "a cloud is not set" : "T_target_source is not a finite rigid motion");
    return std::nullopt;
  }
  try {
    const Options options = getOptions();
    prepare(options, Deadline());
    return pcl_ssfr::scorePose(prepared_source_, prepared_target_, options, *T);
  }
  catch (const std::exception& error) {
    detail::reportError(getClassName(), "scorePose", error.what());
    return std::nullopt;
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::reject(const std::string& problem)
{
  result_ = Result();
  result_.status = Status::InvalidInput;
  result_.message = problem;
}

template <typename PointSource, typename PointTarget, typename Scalar>
template <typename Change>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::changeOptions(const char* setter, const Change& change)
{
  Options candidate = options_;
  change(candidate);
  if (detail::acceptOptions(getClassName(), setter, candidate)) {
    options_ = candidate;
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setViewpoint(const char* setter,
                                                                            const Eigen::Vector3d& position,
                                                                            std::optional<Eigen::Vector3d>& viewpoint,
                                                                            PreparedScan& prepared)
{
  if (!position.allFinite()) {
    detail::reportError(getClassName(), setter, "position is not finite; the old value is kept");
    return;
  }
  viewpoint = position;
  prepared = PreparedScan();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::prepare(const Options& options, const Deadline& deadline)
{
  for (PreparedScan* scan : {&prepared_source_, &prepared_target_}) {
    if (!scan->isPreparedWith(options)) {
      *scan = PreparedScan();
    }
  }
  const auto source = [&] {
    return detail::viewOf(*input_, fake_indices_ ? nullptr : indices_.get(), source_viewpoint_);
  };
  const auto target = [&] { return detail::viewOf(*target_, nullptr, target_viewpoint_); };
  if (prepared_source_.empty() && prepared_target_.empty()) {
    std::tie(prepared_source_, prepared_target_) = prepareScans(source(), target(), options, deadline);
  }
  if (prepared_target_.empty()) {
    prepared_target_ = prepareScan(target(), options, deadline);
  }
  if (prepared_source_.empty()) {
    prepared_source_ = prepareScan(source(), options, deadline);
  }
}

} // namespace pcl_ssfr
