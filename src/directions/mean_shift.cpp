// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/mean_shift.h"

#include <algorithm>

namespace pcl_ssfr {

namespace {

/** \brief Climb to the mode of a region from its peak. The gradient of the Epanechnikov kernel is flat, so each step
 * goes to the weighted mean of the members within the bandwidth.
 */
Eigen::Vector3d
findMode(const DirectionSet& directions, const DenseRegion& region, const MeanShiftOptions& options)
{
  const double squared_bandwidth = options.bandwidth * options.bandwidth;
  Eigen::Vector3d mode = region.peak;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weight = 0;
    for (const Eigen::Index member : region.members) {
      const Eigen::Vector3d direction = directions.directions.col(member);
      if ((direction - mode).squaredNorm() > squared_bandwidth)
        continue;
      sum += directions.weights[member] * direction;
      weight += directions.weights[member];
    }
    if (!(weight > 0))
      break;
    const Eigen::Vector3d next = sum / weight;
    const double shift = (next - mode).norm();
    mode = next;
    if (shift < options.tolerance)
      break;
  }
  // Opposite members could cancel only with a bandwidth of the whole sphere.
  return mode.norm() > 0 ? Eigen::Vector3d(mode.normalized()) : region.peak;
}

} // namespace

std::vector<MainNormal>
findMainNormals(const DirectionSet& directions,
                const std::vector<DenseRegion>& regions,
                const MeanShiftOptions& options)
{
  std::vector<MainNormal> modes;
  modes.reserve(regions.size());
  for (const DenseRegion& region : regions)
    modes.push_back({findMode(directions, region, options), region.weight});
  std::stable_sort(
      modes.begin(), modes.end(), [](const MainNormal& a, const MainNormal& b) { return a.support > b.support; });

  std::vector<MainNormal> main_normals;
  for (const MainNormal& mode : modes) {
    const bool merged = std::any_of(main_normals.begin(), main_normals.end(), [&](const MainNormal& heavier) {
      return (heavier.direction - mode.direction).norm() < options.merge_chord;
    });
    if (!merged)
      main_normals.push_back(mode);
  }
  return main_normals;
}

} // namespace pcl_ssfr
