// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "lcp_verifier.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ssfr::baselines {

namespace {

constexpr int kMaxCells = 256; ///< along an axis

} // namespace

LcpVerifier::LcpVerifier(const Points3& source, const Points3& target, double radius)
    : source_(source), target_(target), radius_(radius)
{
  if (target.cols() == 0)
    return;
  const Eigen::Vector3d min = target.rowwise().minCoeff();
  const Eigen::Vector3d max = target.rowwise().maxCoeff();
  constexpr double kRounding = 1 + 1e-6;
  edge_ = std::max(radius * kRounding, (max - min).maxCoeff() / (kMaxCells - 4));
  origin_ = min - Eigen::Vector3d::Constant(1.5 * edge_);
  size_ = ((max - origin_) / edge_).array().floor().cast<int>() + 2;
  near_.assign(static_cast<std::size_t>(size_.prod()), false);
  for (Eigen::Index i = 0; i < target.cols(); ++i) {
    const Eigen::Vector3i cell = ((target.col(i) - origin_) / edge_).array().floor().cast<int>();
    for (int z = cell.z() - 1; z <= cell.z() + 1; ++z) {
      for (int y = cell.y() - 1; y <= cell.y() + 1; ++y) {
        for (int x = cell.x() - 1; x <= cell.x() + 1; ++x)
          near_[static_cast<std::size_t>((z * size_.y() + y) * size_.x() + x)] = true;
      }
    }
  }
}

bool
LcpVerifier::mayBeNear(const Eigen::Vector3d& point) const
{
  const Eigen::Array3d place = ((point - origin_) / edge_).array().floor();
  if (!((place >= 0).all() && (place < size_.array().cast<double>()).all()))
    return false;
  const Eigen::Array3i cell = place.cast<int>();
  return near_[static_cast<std::size_t>((cell.z() * size_.y() + cell.y()) * size_.x() + cell.x())];
}

Eigen::Index
LcpVerifier::count(const Eigen::Isometry3d& T_target_source, Eigen::Index floor) const
{
  std::vector<Eigen::Vector3d> candidates;
  candidates.reserve(static_cast<std::size_t>(source_.cols()));
  Eigen::Index possible = source_.cols();
  for (Eigen::Index i = 0; i < source_.cols(); ++i) {
    const Eigen::Vector3d point = T_target_source * source_.col(i);
    if (mayBeNear(point))
      candidates.push_back(point);
    else if (--possible <= floor)
      return 0;
  }
  for (const Eigen::Vector3d& point : candidates) {
    if (target_.nearest(point, radius_).index < 0 && --possible <= floor)
      return 0;
  }
  return possible > floor ? possible : 0;
}

} // namespace pcl_ssfr::baselines
