// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "point_tree.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace pcl_ssfr::baselines {

namespace {

constexpr Eigen::Index kLeafSize = 8;

} // namespace

PointTree::PointTree(const Points3& points)
{
  columns_.resize(static_cast<std::size_t>(points.cols()));
  std::iota(columns_.begin(), columns_.end(), Eigen::Index{0});
  if (points.cols() > 0)
    build(points, 0, points.cols());
  points_.resize(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points_.col(i) = points.col(columns_[static_cast<std::size_t>(i)]);
}

void
PointTree::build(const Points3& points, Eigen::Index begin, Eigen::Index end)
{
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  nodes_[self].begin = begin;
  nodes_[self].end = end;
  Eigen::Array3d low = points.col(columns_[static_cast<std::size_t>(begin)]).array();
  Eigen::Array3d high = low;
  for (Eigen::Index i = begin; i < end; ++i) {
    low = low.min(points.col(columns_[static_cast<std::size_t>(i)]).array());
    high = high.max(points.col(columns_[static_cast<std::size_t>(i)]).array());
  }
  nodes_[self].low = low;
  nodes_[self].high = high;
  if (end - begin <= kLeafSize)
    return;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const Eigen::Index middle = begin + (end - begin) / 2;
  const auto at = [this](Eigen::Index i) { return columns_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](Eigen::Index a, Eigen::Index b) {
    return points(axis, a) < points(axis, b) || (points(axis, a) <= points(axis, b) && a < b);
  });
  build(points, begin, middle);
  nodes_[self].right = nodes_.size();
  build(points, middle, end);
}

double
PointTree::squaredDistance(const Node& node, const Eigen::Vector3d& query) const
{
  const Eigen::Array3d nearest = query.array().max(node.low).min(node.high);
  return (query.array() - nearest).square().sum();
}

void
PointTree::search(std::size_t node, const Eigen::Vector3d& query, Neighbor& best) const
{
  const Node& here = nodes_[node];
  if (here.right == 0) {
    for (Eigen::Index i = here.begin; i < here.end; ++i) {
      const double squared = (points_.col(i) - query).squaredNorm();
      const Eigen::Index column = columns_[static_cast<std::size_t>(i)];
      const bool is_tie = squared <= best.squared_distance && (best.index < 0 || column < best.index);
      if (squared < best.squared_distance || is_tie) {
        best.squared_distance = squared;
        best.index = column;
      }
    }
    return;
  }
  std::size_t near = node + 1;
  std::size_t far = here.right;
  double to_near = squaredDistance(nodes_[near], query);
  double to_far = squaredDistance(nodes_[far], query);
  if (to_far < to_near) {
    std::swap(near, far);
    std::swap(to_near, to_far);
  }
  if (to_near <= best.squared_distance)
    search(near, query, best);
  if (to_far <= best.squared_distance)
    search(far, query, best);
}

PointTree::Neighbor
PointTree::nearest(const Eigen::Vector3d& query, double squared_bound) const
{
  Neighbor best;
  best.squared_distance = squared_bound;
  if (!nodes_.empty()) {
    search(0, query, best);
  }
  if (best.index < 0)
    best.squared_distance = std::numeric_limits<double>::infinity();
  return best;
}

} // namespace pcl_ssfr::baselines
