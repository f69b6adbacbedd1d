// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/detail/neighbor_index.h>

#include "common/types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

constexpr std::uint32_t kLeafSize = 16; // points of a box that are looked at one by one

} // namespace

class NeighborIndex::Tree {
public:
  explicit Tree(Points3 points) : points_(std::move(points)), columns_(static_cast<std::size_t>(points_.cols()))
  {
    std::iota(columns_.begin(), columns_.end(), 0U);
    build(0, static_cast<std::uint32_t>(points_.cols()));
    nodes_.shrink_to_fit();
    sortPoints();
  }

  Eigen::Index
  size() const
  {
    return points_.cols();
  }

  /// The nearest point nearer than the root of \p squared_limit [m^2].
  Neighbor
  nearest(const Eigen::Vector3d& query, double squared_limit) const
  {
    Best best;
    best.squared_distance = squared_limit;
    search(0, query, best);
    if (best.column == kNone)
      return {};
    return {best.column, best.squared_distance, points_.col(best.place)};
  }

private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// Points [begin, end) and the box around them: on a wall it is flat, which keeps queries from afar short.
  struct Node {
    Eigen::Array3d low, high;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t right = 0;        ///< the left child follows its parent; 0: a leaf
    std::uint32_t first_column = 0; ///< the lowest of its points
  };

  /// The nearest point so far.
  struct Best {
    double squared_distance = 0;
    std::uint32_t column = kNone; ///< of the points given
    std::uint32_t place = 0;      ///< in the order of the leaves

    /// Whether what is at least that far and of that column or a higher one may come before it.
    bool
    isAfter(double squared, std::uint32_t first_column) const
    {
      return squared < squared_distance || (squared <= squared_distance && column != kNone && first_column < column);
    }
  };

  void
  build(std::uint32_t begin, std::uint32_t end)
  {
    Node node;
    node.begin = begin;
    node.end = end;
    node.first_column = kNone;
    node.low = points_.col(columns_[begin]).array();
    node.high = node.low;
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t column = columns_[i];
      node.first_column = std::min(node.first_column, column);
      node.low = node.low.min(points_.col(column).array());
      node.high = node.high.max(points_.col(column).array());
    }
    const std::size_t self = nodes_.size();
    nodes_.push_back(node);
    if (end - begin <= kLeafSize)
      return;
    int axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::uint32_t i) { return columns_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      return points_(axis, a) < points_(axis, b) || (points_(axis, a) <= points_(axis, b) && a < b);
    });
    build(begin, middle);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
  }

  /// Put the points into the order of the leaves, along the cycles of that permutation: a copy would take most memory.
  void
  sortPoints()
  {
    std::vector<bool> done(columns_.size(), false);
    for (std::size_t start = 0; start < columns_.size(); ++start) {
      const Eigen::Vector3d first = points_.col(static_cast<Eigen::Index>(start));
      std::size_t place = start;
      for (; !done[place]; place = columns_[place]) {
        done[place] = true;
        points_.col(static_cast<Eigen::Index>(place)) =
            columns_[place] == start ? first : points_.col(static_cast<Eigen::Index>(columns_[place]));
      }
    }
  }

  static double
  squaredDistance(const Node& node, const Eigen::Vector3d& query)
  {
    const Eigen::Array3d nearest = query.array().max(node.low).min(node.high);
    return (query.array() - nearest).square().sum();
  }

  void
  search(std::uint32_t node, const Eigen::Vector3d& query, Best& best) const
  {
    const Node& here = nodes_[node];
    if (here.right == 0) {
      for (std::uint32_t i = here.begin; i < here.end; ++i) {
        const double squared = (points_.col(i) - query).squaredNorm();
        if (best.isAfter(squared, columns_[i]))
          best = {squared, columns_[i], i};
      }
      return;
    }
    std::uint32_t near = node + 1;
    std::uint32_t far = here.right;
    double to_near = squaredDistance(nodes_[near], query);
    double to_far = squaredDistance(nodes_[far], query);
    if (to_far < to_near) {
      std::swap(near, far);
      std::swap(to_near, to_far);
    }
    if (best.isAfter(to_near, nodes_[near].first_column))
      search(near, query, best);
    if (best.isAfter(to_far, nodes_[far].first_column))
      search(far, query, best);
  }

  Points3 points_;                     ///< in the order of the leaves
  std::vector<std::uint32_t> columns_; ///< of the points given
  std::vector<Node> nodes_;
};

NeighborIndex::NeighborIndex(Points3 points)
{
  if (!points.allFinite())
    throw std::invalid_argument("NeighborIndex: points must be finite");
  if (points.cols() >= std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("NeighborIndex: points must be fewer than 2^32");
  if (points.cols() > 0)
    tree_ = std::make_shared<const Tree>(std::move(points));
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
  return tree_->nearest(query, max_distance * max_distance);
}

} // namespace pcl_ssfr
