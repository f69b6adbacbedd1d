// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Core>

#include <cstddef>
#include <limits>
#include <vector>

namespace pcl_ssfr::baselines {

/** \brief Exact nearest neighbours in double; a binary tree of boxes around the points.
 *
 * Equally near points: the one with the lower column. Safe to query from many threads.
 */
class PointTree {
public:
  struct Neighbor {
    Eigen::Index index = -1; ///< column of the points; -1: none within the bound
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  PointTree() = default;
  /// Index the columns of \p points, all finite.
  explicit PointTree(const Points3& points);

  Eigen::Index
  size() const
  {
    return points_.cols();
  }
  /// The nearest point whose squared distance is at most \p squared_bound.
  Neighbor
  nearest(const Eigen::Vector3d& query, double squared_bound = std::numeric_limits<double>::infinity()) const;

private:
  /// Points [begin, end) and the box around them: on a wall it is flat, which keeps queries from afar short.
  struct Node {
    Eigen::Array3d low, high;
    Eigen::Index begin = 0;
    Eigen::Index end = 0;
    std::size_t right = 0; ///< the left child follows its parent; 0: a leaf
  };

  void
  build(const Points3& points, Eigen::Index begin, Eigen::Index end);
  double
  squaredDistance(const Node& node, const Eigen::Vector3d& query) const;
  void
  search(std::size_t node, const Eigen::Vector3d& query, Neighbor& best) const;

  Points3 points_;                    ///< in the order of the leaves
  std::vector<Eigen::Index> columns_; ///< of the points given
  std::vector<Node> nodes_;
};

} // namespace pcl_ssfr::baselines
