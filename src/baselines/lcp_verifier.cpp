// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "lcp_verifier.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace pcl_ssfr::baselines {

namespace {

constexpr double kCellsPerRadius = 3;
constexpr int kMaxCells = 384;     ///< along an axis
constexpr double kRounding = 1e-6; ///< relative; what is nearer to the radius is left to the tree

} // namespace

LcpVerifier::LcpVerifier(const Points3& source, const Points3& target, double radius)
    : source_(source), target_(target), radius_(radius)
{
  if (target.cols() == 0)
    return;
  const Eigen::Vector3d min = target.rowwise().minCoeff();
  const Eigen::Vector3d max = target.rowwise().maxCoeff();
  edge_ = std::max(radius / kCellsPerRadius, ((max - min).maxCoeff() + 2 * radius) / (kMaxCells - 4));
  const int reach = static_cast<int>(std::ceil(radius / edge_)) + 1;
  origin_ = min - Eigen::Vector3d::Constant(reach * edge_);
  size_ = ((max - origin_) / edge_).array().floor().cast<int>() + reach + 1;
  may_be_near_.assign(static_cast<std::size_t>(size_.cast<std::ptrdiff_t>().prod()), false);
  is_near_.assign(may_be_near_.size(), false);
  const double outer = radius * radius * (1 + kRounding);
  const double inner = radius * radius * (1 - kRounding);
  for (Eigen::Index i = 0; i < target.cols(); ++i) {
    const Eigen::Array3d place = (target.col(i) - origin_) / edge_;
    const Eigen::Array3i cell = place.floor().cast<int>();
    // Of the cells along an axis: squared distance of the nearest and of the farthest side from the point.
    const auto sides = [&](Eigen::Index axis, int step) {
      const double below = (cell[axis] + step - place[axis]) * edge_;
      const double above = below + edge_;
      const double nearest = std::max({below, -above, 0.0});
      const double farthest = std::max(std::abs(below), std::abs(above));
      return std::make_pair(nearest * nearest, farthest * farthest);
    };
    for (int z = -reach; z <= reach; ++z) {
      const auto [near_z, far_z] = sides(2, z);
      for (int y = -reach; y <= reach && near_z <= outer; ++y) {
        const auto [near_y, far_y] = sides(1, y);
        for (int x = -reach; x <= reach && near_z + near_y <= outer; ++x) {
          const auto [near_x, far_x] = sides(0, x);
          if (near_x + near_y + near_z > outer)
            continue;
          const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(cell.z() + z) * size_.y() + cell.y() + y;
          const auto number = static_cast<std::size_t>(row * size_.x() + cell.x() + x);
          may_be_near_[number] = true;
          if (far_x + far_y + far_z < inner)
            is_near_[number] = true;
        }
      }
    }
  }
}

LcpVerifier::Place
LcpVerifier::placeOf(const Eigen::Vector3d& point) const
{
  const Eigen::Array3d place = ((point - origin_) / edge_).array().floor();
  if (!((place >= 0).all() && (place < size_.array().cast<double>()).all()))
    return Place::Far;
  const Eigen::Array3i cell = place.cast<int>();
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(cell.z()) * size_.y() + cell.y();
  const auto number = static_cast<std::size_t>(row * size_.x() + cell.x());
  if (!may_be_near_[number])
    return Place::Far;
  return is_near_[number] ? Place::Near : Place::Unsure;
}

Eigen::Index
LcpVerifier::count(const Eigen::Isometry3d& T_target_source, Eigen::Index floor) const
{
  std::vector<Eigen::Vector3d> unsure;
  Eigen::Index possible = source_.cols();
  for (Eigen::Index i = 0; i < source_.cols(); ++i) {
    const Eigen::Vector3d point = T_target_source * source_.col(i);
    const Place place = placeOf(point);
    if (place == Place::Unsure)
      unsure.push_back(point);
    else if (place == Place::Far && --possible <= floor)
      return 0;
  }
  for (const Eigen::Vector3d& point : unsure) {
    if (target_.nearest(point, radius_).index < 0 && --possible <= floor)
      return 0;
  }
  return possible > floor ? possible : 0;
}

} // namespace pcl_ssfr::baselines
