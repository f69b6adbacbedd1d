// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <memory>
#include <vector>

namespace pcl_ssfr {

/** \brief Nearest-neighbour search over points in three dimensions; hides PCL's KD-tree (FLANN).
 *
 * Total on empty input: searches answer "nothing". Copies share the tree. Safe to query from many threads.
 */
class NeighborIndex {
public:
  /// A neighbour: column of the indexed points and its squared distance [m^2].
  struct Neighbor {
    Eigen::Index index = -1;
    double squared_distance = 0;
  };

  NeighborIndex() = default;
  /// Index the columns of \p points, all finite (std::invalid_argument otherwise).
  explicit NeighborIndex(const Points3& points);

  Eigen::Index
  size() const;
  /// The nearest point nearer than \p max_distance [m]; index -1 when there is none.
  Neighbor
  nearest(const Eigen::Vector3d& query, double max_distance) const;
  /// The \p k nearest points in ascending distance, fewer when there are fewer.
  std::vector<Neighbor>
  kNearest(const Eigen::Vector3d& query, int k) const;

private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

} // namespace pcl_ssfr
