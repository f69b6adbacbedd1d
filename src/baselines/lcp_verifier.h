// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace pcl_ssfr::baselines {

/** \brief Counts the source points that a pose brings nearer than a radius to the target (LCP), and stops as soon as a
 * pose cannot win any more.
 *
 * A grid of the target's surroundings decides most points; those in between are looked up in a KD-tree, so that the
 * count is exact.
 */
class LcpVerifier {
public:
  /// \p source in an order that has nothing to do with position, \p target, finite, 3 x N [m]; \p radius > 0 [m].
  LcpVerifier(const Points3& source, const Points3& target, double radius);

  /// The exact count when it is greater than \p floor, otherwise 0.
  Eigen::Index
  count(const Eigen::Isometry3d& T_target_source, Eigen::Index floor) const;

  Eigen::Index
  size() const
  {
    return source_.cols();
  }

private:
  enum class Place { Far, Near, Unsure };

  Place
  placeOf(const Eigen::Vector3d& point) const;

  Points3 source_;
  NeighborIndex target_;
  double radius_ = 0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero(); ///< corner of the grid [m]
  double edge_ = 1;                                  ///< of a cell [m]
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<bool> may_be_near_; ///< some of the cell is nearer than the radius to a target point
  std::vector<bool> is_near_;     ///< all of the cell is nearer than the radius to one target point
};

} // namespace pcl_ssfr::baselines
