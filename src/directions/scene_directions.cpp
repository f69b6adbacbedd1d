// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/scene_directions.h"

#include "common/rotation_math.h"
#include "profiles/patch_constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>

namespace pcl_ssfr {

namespace {

constexpr std::size_t kSweepAxes = 2;
constexpr double kSameDirection =
    0.12;                         // [rad] a main normal this near to the vertical is it: SearchConfig::direction_error
constexpr double kMaxSlope = 0.3; // sine of the angle by which surface that faces across an axis may face along it
constexpr double kRoundShare = 0.3; // of the surface that faces across an axis for the scene to be round about it ...
constexpr double kRoundFullShare = 0.6; // ... and of that, so much at most in the fullest third of all directions

} // namespace

std::vector<MainNormal>
withVertical(std::vector<MainNormal> main_normals, const Eigen::Vector3d& up)
{
  double heaviest = 1;
  for (const MainNormal& m : main_normals) {
    heaviest = std::max(heaviest, m.support);
    if (m.direction.dot(up) > std::cos(kSameDirection))
      return main_normals;
  }
  main_normals.push_back({up, heaviest});
  return main_normals;
}

bool
isRoundAbout(const OrientedSamples& samples, const Eigen::Vector3d& axis)
{
  constexpr int kBins = 36;
  constexpr int kFullBins = 12; // that hold nearly all of a scene of planes
  const Eigen::Vector3d x = axis.unitOrthogonal();
  const Eigen::Vector3d y = axis.cross(x);
  std::array<double, kBins> around{};
  double total = 0;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    total += samples.weights[i];
    const Eigen::Vector3d n = samples.normals.col(i);
    if (std::abs(n.dot(axis)) > kMaxSlope)
      continue;
    const double share = std::atan2(n.dot(y), n.dot(x)) / (2 * kPi) + 0.5;
    around[static_cast<std::size_t>(share * kBins) % kBins] += samples.weights[i];
  }
  double across = 0;
  for (const double a : around)
    across += a;
  std::sort(around.begin(), around.end(), std::greater<>());
  double full = 0;
  for (int k = 0; k < kFullBins; ++k)
    full += around[static_cast<std::size_t>(k)];
  return across > kRoundShare * total && full < kRoundFullShare * across;
}

std::vector<Eigen::Vector3d>
sweepAxes(const std::vector<MainNormal>& main_normals, const OrientedSamples& samples, bool all_of_them)
{
  std::vector<Eigen::Vector3d> axes;
  for (std::size_t k = 0; k < std::min(main_normals.size(), kSweepAxes); ++k)
    if (all_of_them || isRoundAbout(samples, main_normals[k].direction))
      axes.push_back(main_normals[k].direction);
  return axes;
}

} // namespace pcl_ssfr
