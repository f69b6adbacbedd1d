// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/overlap.h"

#include "common/parallel.h"

#include <cmath>

namespace pcl_ssfr {

Overlap
computeOverlap(const Points3& source,
               const NeighborIndex& target,
               const Eigen::Isometry3d& T_target_source,
               double radius,
               unsigned threads)
{
  Overlap overlap;
  if (source.cols() == 0 || target.size() == 0)
    return overlap;

  // Squared distance of each source point, infinite when no target point is near.
  Eigen::VectorXd squared_distances(source.cols());
  forEachInParallel(source.cols(), 256, static_cast<int>(threads), [&](Eigen::Index i) {
    squared_distances[i] = target.nearest(T_target_source * source.col(i), radius).squared_distance;
  });

  double squared_sum = 0;
  for (const double squared : squared_distances) {
    if (std::isinf(squared))
      continue;
    ++overlap.inliers;
    overlap.kernel_sum += std::exp(-std::sqrt(squared) / radius);
    squared_sum += squared;
  }
  overlap.ratio = static_cast<double>(overlap.inliers) / static_cast<double>(source.cols());
  if (overlap.inliers > 0)
    overlap.rmse = std::sqrt(squared_sum / static_cast<double>(overlap.inliers));
  return overlap;
}

} // namespace pcl_ssfr
