// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/assembly.h"
#include "multiway/joint_adjustment.h"
#include "multiway/map_stages.h"
#include "multiway/placed_evidence.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// How exact the poses of a map are once they are adjusted.
struct MapExactness {
  std::vector<Eigen::Matrix<double, 6, 6>> covariances; ///< of each scan; see JointAdjustment
  double graph_error = 0;  ///< root mean square plane distance over all pairs at the poses of the graph [m]
  double bundle_error = 0; ///< and at those adjusted [m]
};

/// The scan of each part that holds its frame: one that is pinned, else one whose pose is known, else the first.
std::vector<int>
fixedScans(const Assembly& assembly, const MapInput& input);

/// The joint adjustment of every part of a map.
class MapAdjustment {
public:
  /// All must outlive it.
  /// \param[in] places of the sensors in the frames of their scans [m]
  MapAdjustment(const MapInput& input,
                const std::vector<PairLink>& links,
                const std::vector<Eigen::Vector3d>& places,
                PlacedEvidence& evidence,
                const MultiwayRegistration::Progress& progress);

  /// From the poses of a graph, which is new.
  void
  startFrom(const std::vector<Eigen::Isometry3d>& graph_poses);

  /// To poses that are exact enough to judge what is seen at them: it ends with steps below what matches are good to.
  void
  adjustRoughly(Assembly& assembly);

  /// To the end.
  MapExactness
  adjustExactly(Assembly& assembly);

  const std::vector<Eigen::Isometry3d>&
  graphPoses() const
  {
    return graph_poses_;
  }

private:
  /// Equations of a pair, where they are known. Stages adjust again where little or nothing has moved, and ask for
  /// those at the poses of the graph last.
  struct KnownEquations {
    struct At {
      Eigen::Isometry3d T_target_source;
      SurfaceEquations equations;
    };
    std::optional<At> graph, latest;
  };
  /// The scans of a part, numbered, and its pairs that overlap.
  struct Network;

  Network
  networkOf(const Assembly& assembly, const std::vector<int>& members, const std::vector<int>& fixed);
  EquationsFunction
  equationsOf(const Network& network) const;
  PatchGradientsFunction
  gradientsOf(const Network& network) const;
  /// Call \p adjust(network) for each part of several scans.
  template <typename Adjust>
  void
  forEachPart(const Assembly& assembly, const Adjust& adjust);

  const MapInput& input_;
  const std::vector<PairLink>& links_;
  const std::vector<Eigen::Vector3d>& places_;
  PlacedEvidence& evidence_;
  const MultiwayRegistration::Progress& progress_;
  int threads_;
  std::vector<Eigen::Isometry3d> graph_poses_;
  std::map<std::pair<int, int>, KnownEquations> known_;
};

} // namespace pcl_ssfr
