// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/correspondence_distance.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace pcl_ssfr {

double
spacingOf(const PlanarPatches& patches)
{
  std::vector<std::pair<double, double>> spacing_and_area;
  double total = 0;
  for (Eigen::Index i = 0; i < patches.size(); ++i) {
    const double area = patches.samples.weights[i];
    spacing_and_area.emplace_back(std::sqrt(area / patches.counts[static_cast<std::size_t>(i)]), area);
    total += area;
  }
  std::sort(spacing_and_area.begin(), spacing_and_area.end());
  double below = 0;
  for (const auto& [spacing, area] : spacing_and_area) {
    below += area;
    if (2 * below >= total)
      return spacing;
  }
  return 0;
}

double
correspondenceDistance(const Refinement& polish,
                       const PoseUncertainty& uncertainty,
                       double spacing,
                       double most,
                       const UncertaintyConfig& config)
{
  if (polish.matches == 0)
    return 0;
  double pose_variance = 0;
  for (const PrincipalMotion& m : uncertainty.motions)
    if (std::isfinite(m.deviation))
      pose_variance += m.deviation * m.deviation;
  const double noise = config.bound_deviations * std::max(polish.rms, config.noise_floor);
  const double pose = std::min(config.bound_deviations * std::sqrt(pose_variance), most);
  return std::hypot(noise, pose, spacing / std::sqrt(2.0));
}

} // namespace pcl_ssfr
