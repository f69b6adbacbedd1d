// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/go_icp.h>
#include <pcl_ssfr/baselines/impl/baseline_registration.hpp>

namespace pcl_ssfr::baselines {

template <typename PointSource, typename PointTarget, typename Scalar>
GoIcpOptions
GoIcp<PointSource, PointTarget, Scalar>::getOptions() const
{
  GoIcpOptions options = options_;
  options.inlier_distance = this->maxCorrespondenceDistance();
  options.icp_iterations = this->max_iterations_;
  options.threads = this->threads();
  return options;
}

template <typename PointSource, typename PointTarget, typename Scalar>
BaselineResult
GoIcp<PointSource, PointTarget, Scalar>::runMethod(const ScanView& source,
                                                   const ScanView& target,
                                                   const std::optional<Eigen::Isometry3d>& guess) const
{
  report_ = GoIcpReport();
  return registerGoIcp(source, target, getOptions(), guess, &report_);
}

} // namespace pcl_ssfr::baselines
