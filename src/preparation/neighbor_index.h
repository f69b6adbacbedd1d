// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <limits>
#include <memory>

namespace pcl_ssfr {

/** \brief Exact nearest neighbours in double; a binary tree of boxes around the points.
 *
 * For single queries, millions of them: PCL's tree opens an OpenMP region for each, which ends in system calls that
 * take longer than the search. Equally near points: the one with the lower column. Copies share the tree. Safe to query
 * from many threads.
 */
class NeighborIndex {
public:
  /// A neighbour: column of the indexed points and its squared distance [m^2].
  struct Neighbor {
    Eigen::Index index = -1; ///< -1: none
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  NeighborIndex() = default;
  /// Index the columns of \p points, all finite (std::invalid_argument otherwise).
  explicit NeighborIndex(const Points3& points);

  Eigen::Index
  size() const;
  /// The nearest point nearer than \p max_distance [m]; none for a query that is not finite, or among no points.
  Neighbor
  nearest(const Eigen::Vector3d& query, double max_distance = std::numeric_limits<double>::infinity()) const;

private:
  class Tree;
  std::shared_ptr<const Tree> tree_;
};

} // namespace pcl_ssfr
