// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/impl/baseline_registration.hpp>
#include <pcl_ssfr/baselines/super4pcs.h>

namespace pcl_ssfr::baselines {

template <typename PointSource, typename PointTarget, typename Scalar>
Super4PCS<PointSource, PointTarget, Scalar>::Super4PCS() : Base("Super4PCS")
{}

template <typename PointSource, typename PointTarget, typename Scalar>
Super4PcsOptions
Super4PCS<PointSource, PointTarget, Scalar>::getOptions() const
{
  Super4PcsOptions options = options_;
  options.distance_threshold = this->maxCorrespondenceDistance();
  options.max_bases = this->max_iterations_;
  options.threads = this->threads();
  return options;
}

template <typename PointSource, typename PointTarget, typename Scalar>
BaselineResult
Super4PCS<PointSource, PointTarget, Scalar>::runMethod(const ScanView& source,
                                                       const ScanView& target,
                                                       const std::optional<Eigen::Isometry3d>& guess) const
{
  return registerSuper4Pcs(source, target, getOptions(), guess);
}

} // namespace pcl_ssfr::baselines
