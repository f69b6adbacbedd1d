// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_registration.h>
#include <pcl_ssfr/impl/cloud_access.hpp>
#include <pcl_ssfr/impl/registration_adaptor.hpp>
#include <pcl_ssfr/impl/registration_support.h>
#include <pcl_ssfr/options.h>

#include <exception>
#include <string>

namespace pcl_ssfr::baselines {

template <typename PointSource, typename PointTarget, typename Scalar>
BaselineRegistration<PointSource, PointTarget, Scalar>::BaselineRegistration(const char* name) : Adaptor(name, 0)
{}

template <typename PointSource, typename PointTarget, typename Scalar>
unsigned
BaselineRegistration<PointSource, PointTarget, Scalar>::threads() const
{
  return pcl_ssfr::threadCount(threads_);
}

template <typename PointSource, typename PointTarget, typename Scalar>
typename BaselineRegistration<PointSource, PointTarget, Scalar>::Answer
BaselineRegistration<PointSource, PointTarget, Scalar>::findPose(const std::optional<Eigen::Isometry3d>& guess)
{
  const pcl::Indices* indices = fake_indices_ ? nullptr : indices_.get();
  try {
    result_ = runMethod(pcl_ssfr::detail::viewOf(*input_, indices, std::nullopt),
                        pcl_ssfr::detail::viewOf(*target_, nullptr, std::nullopt),
                        guess);
  }
  catch (const std::exception& error) {
    reject(error.what());
    pcl_ssfr::detail::reportError(getClassName(), "align", error.what());
  }
  Answer answer;
  answer.is_accepted = result_.converged;
  answer.T_target_source = result_.T_target_source;
  answer.iterations = result_.iterations;
  answer.inlier_distance = result_.inlier_distance;
  return answer;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::reject(const std::string& problem)
{
  result_ = BaselineResult();
  result_.message = problem;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::clearResult()
{
  reject("align() was not called");
}

} // namespace pcl_ssfr::baselines
