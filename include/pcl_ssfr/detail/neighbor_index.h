// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>

#include <Eigen/Core>

#include <limits>
#include <memory>

namespace pcl_ssfr {

/** \brief Exact nearest neighbours in double; a binary tree of boxes around the points.
 *
 * For single queries, millions of them: PCL's tree opens an OpenMP region for each, which ends in system calls that
 * take longer than the search. Equally near points: the one with the lower column. Copies share the tree. Safe to query
 * from many threads.
 */
class PCL_SSFR_EXPORT NeighborIndex {
public:
  /// What a query finds.
  struct Neighbor {
    Eigen::Index index = -1;                                           ///< column of the indexed points; -1: none
    double squared_distance = std::numeric_limits<double>::infinity(); ///< [m^2]
    Eigen::Vector3d point = Eigen::Vector3d::Zero();                   ///< as it was indexed [m]
  };

  NeighborIndex() = default;
  /// Index the columns of \p points, 3 x N [m], all finite and fewer than 2^32 (std::invalid_argument otherwise).
  explicit NeighborIndex(Eigen::Matrix3Xd points);

  /// Number of points.
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
