// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/scene_directions.h"

#include "common/rotation_math.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace pcl_ssfr {

double
parallelCos(const SearchConfig& config)
{
  return std::cos(std::min(2 * config.direction_error, kPi / 2));
}

std::vector<MainNormal>
withVertical(std::vector<MainNormal> main_normals, const Eigen::Vector3d& up, const SearchConfig& config)
{
  double heaviest = 1;
  for (const MainNormal& m : main_normals) {
    heaviest = std::max(heaviest, m.support);
    if (m.direction.dot(up) > std::cos(config.direction_error))
      return main_normals;
  }
  main_normals.push_back({up, heaviest});
  return main_normals;
}

bool
isRoundAbout(const OrientedSamples& samples, const Eigen::Vector3d& axis, const SearchConfig& config)
{
  const Eigen::Vector3d x = axis.unitOrthogonal();
  const Eigen::Vector3d y = axis.cross(x);
  const auto bins = static_cast<std::size_t>(config.sweep_steps); // as rotations about it would be tried
  std::vector<double> around(bins, 0.0);
  const double parallel_cos = parallelCos(config);
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d n = samples.normals.col(i);
    const double along = n.dot(axis);
    if (1 - along * along < parallel_cos * parallel_cos)
      continue; // it does not face across
    const double share = std::atan2(n.dot(y), n.dot(x)) / (2 * kPi) + 0.5;
    around[static_cast<std::size_t>(share * static_cast<double>(bins)) % bins] += samples.weights[i];
  }
  double across = 0;
  for (const double a : around)
    across += a;
  std::sort(around.begin(), around.end(), std::greater<>());
  double full = 0;
  for (std::size_t k = 0; k < bins / 3; ++k)
    full += around[k];
  return full < config.round_share * across;
}

std::vector<Eigen::Vector3d>
sweepAxes(const std::vector<MainNormal>& main_normals,
          const OrientedSamples& samples,
          bool all_of_them,
          const SearchConfig& config)
{
  std::vector<Eigen::Vector3d> axes;
  for (std::size_t k = 0; k < std::min(main_normals.size(), static_cast<std::size_t>(config.sweep_axes)); ++k)
    if (all_of_them || isRoundAbout(samples, main_normals[k].direction, config))
      axes.push_back(main_normals[k].direction);
  return axes;
}

} // namespace pcl_ssfr
