// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/neighbor_index.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

constexpr Eigen::Index kLeafSize = 8; // points of a box that are looked at one by one

} // namespace

class NeighborIndex::Tree {
public:
  explicit Tree(const Points3& points) : columns_(static_cast<std::size_t>(points.cols()))
  {
    std::iota(columns_.begin(), columns_.end(), Eigen::Index{0});
    build(points, 0, points.cols());
    points_.resize(3, points.cols());
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      points_.col(i) = points.col(columns_[static_cast<std::size_t>(i)]);
  }

  Eigen::Index
  size() const
  {
    return points_.cols();
  }

  /// Take the nearest point for \p best that is nearer than it, or as near and of a lower column.
  void
  search(const Eigen::Vector3d& query, Neighbor& best) const
  {
    search(0, query, best);
  }

private:
  /// Points [begin, end) and the box around them: on a wall it is flat, which keeps queries from afar short.
  struct Node {
    Eigen::Array3d low, high;
    Eigen::Index begin = 0;
    Eigen::Index end = 0;
    std::size_t right = 0; ///< the left child follows its parent; 0: a leaf
  };

  void
  build(const Points3& points, Eigen::Index begin, Eigen::Index end)
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

  static double
  squaredDistance(const Node& node, const Eigen::Vector3d& query)
  {
    const Eigen::Array3d nearest = query.array().max(node.low).min(node.high);
    return (query.array() - nearest).square().sum();
  }

  void
  search(std::size_t node, const Eigen::Vector3d& query, Neighbor& best) const
  {
    const Node& here = nodes_[node];
    if (here.right == 0) {
      for (Eigen::Index i = here.begin; i < here.end; ++i) {
        const double squared = (points_.col(i) - query).squaredNorm();
        const Eigen::Index column = columns_[static_cast<std::size_t>(i)];
        if (squared < best.squared_distance || (squared <= best.squared_distance && column < best.index))
          best = {column, squared};
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

  Points3 points_;                    ///< in the order of the leaves
  std::vector<Eigen::Index> columns_; ///< of the points given
  std::vector<Node> nodes_;
};

NeighborIndex::NeighborIndex(const Points3& points)
{
  if (!points.allFinite())
    throw std::invalid_argument("NeighborIndex: points must be finite");
  if (points.cols() > 0)
    tree_ = std::make_shared<const Tree>(points);
}

Eigen::Index
NeighborIndex::size() const
{
  return tree_ ? tree_->size() : 0;
}

NeighborIndex::Neighbor
NeighborIndex::nearest(const Eigen::Vector3d& query, double max_distance) const
{
  if (!tree_ || !query.allFinite())
    return {};
  Neighbor best;
  best.squared_distance = max_distance * max_distance;
  tree_->search(query, best);
  return best.index < 0 ? Neighbor{} : best;
}

} // namespace pcl_ssfr
