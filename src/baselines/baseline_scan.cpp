// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baseline_scan.h"

#include "preparation/thinning.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace pcl_ssfr::baselines {

namespace {

constexpr double kLeafPerRadius = 1.0 / 50;   ///< first voxel edge against the radius of the scan
constexpr double kMaxLeafPerRadius = 1.0 / 5; ///< a larger voxel leaves nothing of the shape
constexpr double kLeafGrowth = 1.5;           ///< from one trial to the next
constexpr double kPointsPerVoxel = 3;         ///< average at which the scan is dense enough for the voxel
constexpr double kMinRadius = 1e-9;           ///< a scan smaller than this is a single point [m]

bool
isDenseEnough(const ScanView& scan, const ScanExtent& extent, double leaf, unsigned threads)
{
  const ThinnedCloud cloud = thinScan(scan, leaf, extent.median, 0, threads);
  return static_cast<double>(extent.returns) >= kPointsPerVoxel * static_cast<double>(cloud.size());
}

} // namespace

double
deriveLeaf(const ScanView& source, const ScanView& target, unsigned threads)
{
  const ScanExtent source_extent = measureExtent(source);
  const ScanExtent target_extent = measureExtent(target);
  const double radius = std::min(source_extent.radius, target_extent.radius);
  if (!(radius > kMinRadius))
    return 0;
  double leaf = kLeafPerRadius * radius;
  while (leaf < kMaxLeafPerRadius * radius &&
         (!isDenseEnough(source, source_extent, leaf, threads) || !isDenseEnough(target, target_extent, leaf, threads)))
    leaf *= kLeafGrowth;
  return std::min(leaf, kMaxLeafPerRadius * radius);
}

BaselineScan
thinBaselineScan(const ScanView& scan, double leaf, unsigned threads)
{
  BaselineScan result;
  const ScanExtent extent = measureExtent(scan);
  result.origin = extent.median;
  result.viewpoint = scan.viewpoint - result.origin;
  if (leaf > 0) {
    result.points = thinScan(scan, leaf, result.origin, 0, threads).points.cast<double>();
    return result;
  }
  result.points.resize(3, static_cast<Eigen::Index>(extent.returns));
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < scan.count(); ++i) {
    if (scan.isReturn(i))
      result.points.col(column++) = scan.point(i).cast<double>() - result.origin;
  }
  return result;
}

std::optional<BaselinePair>
thinPair(const ScanView& source,
         const ScanView& target,
         double leaf,
         unsigned threads,
         Eigen::Index min_points,
         BaselineResult& result)
{
  result.leaf = leaf > 0 ? leaf : deriveLeaf(source, target, threads);
  if (!(result.leaf > 0)) {
    result.message = "a scan is empty or has no extent";
    return std::nullopt;
  }
  BaselinePair pair{thinBaselineScan(source, result.leaf, threads), thinBaselineScan(target, result.leaf, threads)};
  result.source_points = static_cast<std::size_t>(pair.source.points.cols());
  result.target_points = static_cast<std::size_t>(pair.target.points.cols());
  if (std::min(pair.source.points.cols(), pair.target.points.cols()) < min_points) {
    result.message = "too few points: " + std::to_string(result.source_points) + " in the source, " +
                     std::to_string(result.target_points) + " in the target";
    return std::nullopt;
  }
  return pair;
}

Eigen::Isometry3d
uncentred(const Eigen::Isometry3d& T_centred, const BaselineScan& source, const BaselineScan& target)
{
  Eigen::Isometry3d T = T_centred;
  T.translation() += target.origin - T_centred.linear() * source.origin;
  return T;
}

Eigen::Isometry3d
centred(const Eigen::Isometry3d& T, const BaselineScan& source, const BaselineScan& target)
{
  Eigen::Isometry3d T_centred = T;
  T_centred.translation() += T.linear() * source.origin - target.origin;
  return T_centred;
}

} // namespace pcl_ssfr::baselines
