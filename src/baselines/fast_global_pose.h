// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

// The part of Fast Global Registration that works on correspondences alone (Zhou, Park, Koltun, "Fast Global
// Registration", ECCV 2016, sections 3.1 and 3.2).
namespace pcl_ssfr::baselines {

/// A column of the source and a column of the target that are taken for the same place.
struct PointMatch {
  Eigen::Index source = 0;
  Eigen::Index target = 0;

  friend bool
  operator==(const PointMatch& a, const PointMatch& b)
  {
    return a.source == b.source && a.target == b.target;
  }
  friend bool
  operator<(const PointMatch& a, const PointMatch& b)
  {
    return a.source != b.source ? a.source < b.source : a.target < b.target;
  }
};

/// How triples of matches are tested against each other.
struct TupleTestOptions {
  double similarity = 0.9;       ///< tau: lengths of corresponding sides agree within this factor, (0, 1]
  std::size_t max_tuples = 1000; ///< enough triples that pass
  std::size_t trials_per_match = 100;
  std::uint64_t seed = 1;
};

/** \brief Random triples of matches whose triangles agree: K_III of the paper.
 *
 * \return the three matches of every triple that passed; a match of several triples is listed several times, as in the
 * authors' implementation, and so counts the more. Empty when there are fewer than three matches.
 */
std::vector<PointMatch>
tupleTest(const Points3& source,
          const Points3& target,
          const std::vector<PointMatch>& matches,
          const TupleTestOptions& options);

/// How the pose is optimised.
struct FastGlobalPoseOptions {
  double distance_threshold = 0; ///< delta, > 0 [m]
  double diameter = 0;           ///< of the larger surface [m]; 0: of the matched points
  /// Gauss-Newton steps; 0: as many as the annealing needs and some more, at least 64.
  int iterations = 0;
};

/// What the optimisation ended with.
struct FastGlobalPose {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double mu = 0;            ///< scale of the estimator at the end [m^2]
  double cost = 0;          ///< sum of the scaled Geman-McClure estimator at delta^2 over all matches [m^2]
  std::size_t matches = 0;  ///< distinct ones
  std::size_t inliers = 0;  ///< distinct matches nearer than delta
  double inlier_spread = 0; ///< second largest standard deviation of the inliers' positions [m]; 0: on a line
  int iterations = 0;       ///< steps taken
};

/** \brief The pose that minimises the scaled Geman-McClure estimator of the distances of the matches (equation 3).
 *
 * Line process and pose are updated alternately (equations 6 and 8); mu starts at the squared diameter and is divided
 * by 1.4 every fourth step down to delta^2. A \p guess is optimised at delta^2 and taken when it ends with the lower
 * cost. Non-finite positions are not allowed. Fewer than three matches give the identity and no inliers. \throw
 * std::invalid_argument when the threshold is not > 0 or a match is out of range
 */
FastGlobalPose
optimizeFastGlobalPose(const Points3& source,
                       const Points3& target,
                       const std::vector<PointMatch>& matches,
                       const FastGlobalPoseOptions& options,
                       const Eigen::Isometry3d* guess = nullptr);

} // namespace pcl_ssfr::baselines
