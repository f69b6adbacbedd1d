// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/hypothesis_graph.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace pcl_ssfr {

/// Scans that are being put together: each a part by itself at first, with the identity as its pose.
class GrowingParts {
public:
  /// All must outlive it.
  /// \param[in] places of the sensors in the scans' frames [m]
  GrowingParts(const std::vector<PairLink>& links,
               const HypothesisGraph& graph,
               const std::vector<Eigen::Vector3d>& places,
               const ChoiceConfig& config);

  Assembly&
  assembly()
  {
    return assembly_;
  }
  const Assembly&
  assembly() const
  {
    return assembly_;
  }
  int
  partOf(int scan) const
  {
    return assembly_.part[static_cast<std::size_t>(scan)];
  }
  /// Of a scan in the frame of its part.
  const Eigen::Isometry3d&
  pose(int scan) const
  {
    return assembly_.poses[static_cast<std::size_t>(scan)];
  }
  /// Ascending; none of a part that was merged into another one.
  const std::vector<int>&
  members(int part) const
  {
    return members_[static_cast<std::size_t>(part)];
  }
  /// The place of the first sensor of a part, in its frame [m].
  Eigen::Vector3d
  placeOf(int part) const;

  /// Where a pose of a pair, which maps the source, lays the part of its source in the frame of that of its target.
  Eigen::Isometry3d
  partPose(const PairLink& pair, const Eigen::Isometry3d& T_target_source) const
  {
    return pose(pair.target) * T_target_source * pose(pair.source).inverse();
  }
  /// Each scan of the one part in each of the other, but for those that are left out: of large parts nearly all.
  std::vector<PlacedPair>
  pairsAt(int a, int b, const Eigen::Isometry3d& T_b_a, const PairTest& left_out = nullptr) const;

  /// The smaller part moves into the frame of the larger one; what has grown enough is adjusted.
  void
  merge(int a, int b, const Eigen::Isometry3d& T_b_a);
  /// All poses by the links that agree with them.
  void
  adjustAll();

private:
  void
  adjust(std::size_t part);

  const std::vector<PairLink>& links_;
  const HypothesisGraph& graph_;
  const std::vector<Eigen::Vector3d>& places_;
  const ChoiceConfig& config_;
  std::vector<std::size_t> adjusted_size_; ///< of each part
  std::vector<std::vector<int>> members_;
  Assembly assembly_;
};

} // namespace pcl_ssfr
