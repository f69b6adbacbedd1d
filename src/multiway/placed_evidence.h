// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/map_stages.h"

#include <Eigen/Geometry>

#include <map>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// What the surfaces of scans say of where a map puts them.
class PlacedEvidence {
public:
  /// All must outlive it.
  /// \param[in] places of the sensors in the frames of their scans [m]
  PlacedEvidence(const MapInput& input, const MultiwayMap& map, const std::vector<Eigen::Vector3d>& places);

  /// Whether two scans, whose sensors are \p distance [m] apart, are too far from each other to share anything.
  bool
  areTooFar(int source, int target, double distance) const;

  /// Of two scans at a pose; none where they are too far from each other to share anything.
  PlacementEvidence
  at(int source, int target, const Eigen::Isometry3d& T_target_source, double looseness) const;

  /// Of all pairs of a part, in their order; valid until it is called again for the part. Stages ask again before
  /// anything has moved: for n scans that is n^2 / 2 looks at two scans.
  const std::vector<PlacementEvidence>&
  of(const Assembly& assembly, const std::vector<int>& members, const std::vector<std::pair<int, int>>& pairs);

private:
  struct Part {
    std::vector<int> members;
    std::vector<Eigen::Isometry3d> poses; ///< of the members, that the evidence is of
    std::vector<PlacementEvidence> evidence;
  };

  const MapInput& input_;
  const std::vector<Eigen::Vector3d>& places_;
  std::vector<SightOfScan> sights_; ///< of each scan
  std::map<int, Part> known_;       ///< by the first scan of the part
};

} // namespace pcl_ssfr
