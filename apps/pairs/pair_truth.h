// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/pairs/measures.h>
#include <apps/pairs/pair_input.h>

#include <optional>

namespace pcl_ssfr {
namespace apps {

/// Points of the source and their nearest points of the target under the ground truth, about the clouds' offsets [m].
struct Correspondences {
  Eigen::Matrix3Xd source;
  Eigen::Matrix3Xd target;
  std::size_t samples = 0; ///< points of the source that were asked
  double radius = 0;       ///< farther is no correspondence [m]
};

/** \brief Correspondences fixed at the ground truth, nearer than twice the leaf that the rule gives these scans. Up to
 * 20000 evenly chosen points of the source are asked, of up to two million points of the target.
 * \throw std::invalid_argument when the truth is not known
 */
Correspondences
correspondencesAtTruth(const PairInput& pair);

/// What is known about a pair before any method runs; all poses in file coordinates.
struct PairTruth {
  std::optional<Eigen::Isometry3d>
      T_target_source; ///< after the variation; none: no pose is right, and nothing follows
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(); ///< PairInput::reference [m]
  CorrespondenceSums sums;
  Eigen::Vector3d source_offset = Eigen::Vector3d::Zero(); ///< the sums are about these [m]
  Eigen::Vector3d target_offset = Eigen::Vector3d::Zero();
  double overlap = 0; ///< share of the source with a correspondence, [0, 1]; NaN without a truth
  double radius = 0;  ///< of the correspondences [m]
  double gt_rmse = 0; ///< of the truth itself [m]; NaN without correspondence
  std::size_t source_points = 0;
  std::size_t target_points = 0;

  /// RMSE of a pose over the fixed correspondences [m]; NaN without any.
  double
  rmse(const Eigen::Isometry3d& estimate) const
  {
    return rmseOf(sums, Eigen::Translation3d(-target_offset) * estimate * Eigen::Translation3d(source_offset));
  }
};

PairTruth
measureTruth(const PairInput& pair);

nlohmann::ordered_json
toJson(const PairTruth& truth);

/// \throw nlohmann::json::exception, std::invalid_argument
PairTruth
pairTruthFromJson(const nlohmann::ordered_json& json);

} // namespace apps
} // namespace pcl_ssfr
