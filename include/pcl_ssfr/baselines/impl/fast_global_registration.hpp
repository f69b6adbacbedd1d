// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/fast_global_registration.h>
#include <pcl_ssfr/baselines/impl/baseline_registration.hpp>

namespace pcl_ssfr::baselines {

template <typename PointSource, typename PointTarget, typename Scalar>
FastGlobalRegistration<PointSource, PointTarget, Scalar>::FastGlobalRegistration() : Base("FastGlobalRegistration")
{}

template <typename PointSource, typename PointTarget, typename Scalar>
FastGlobalOptions
FastGlobalRegistration<PointSource, PointTarget, Scalar>::getOptions() const
{
  FastGlobalOptions options = options_;
  options.distance_threshold = this->maxCorrespondenceDistance();
  options.iterations = this->max_iterations_;
  options.threads = this->threads();
  return options;
}

template <typename PointSource, typename PointTarget, typename Scalar>
BaselineResult
FastGlobalRegistration<PointSource, PointTarget, Scalar>::runMethod(const ScanView& source,
                                                                    const ScanView& target,
                                                                    const std::optional<Eigen::Isometry3d>& guess) const
{
  return registerFastGlobal(source, target, getOptions(), guess);
}

} // namespace pcl_ssfr::baselines
