// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "patch_scenes.h"
#include "preparation/patch_index.h"
#include "preparation/range_image.h"
#include "preparation/thinning.h"
#include "search/pose_search.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ssfr::testing {

/// A scan as the searches take it.
struct SearchedScan {
  PlanarPatches patches;
  PatchIndex index;
  RangeImage image;
  VotingSamples votes;
  std::vector<MainNormal> main_normals;
};

/// How a scan is drawn from a scene and prepared.
struct ScanDrawing {
  double density;   ///< points a square metre
  double leaf;      ///< [m] they are thinned to
  double thickness; ///< [m] of the patches
  double cell;      ///< [rad] of the range image
};

/// A scan of rectangles by a sensor in its own frame.
/// \param[in] main_normals in that frame
inline SearchedScan
makeSearchedScan(const std::vector<Rectangle>& rectangles,
                 const Eigen::Isometry3d& T_world_sensor,
                 std::vector<MainNormal> main_normals,
                 const ScanDrawing& drawing,
                 std::uint64_t seed)
{
  const Eigen::Matrix3Xf points =
      transformed(T_world_sensor.inverse(), samplePoints(rectangles, drawing.density, seed));
  const ThinnedCloud cloud = thinScan(viewOfPoints(points), drawing.leaf, Eigen::Vector3d::Zero());
  const Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  PatchConfig options;
  options.coarsest_level = 5;
  SearchedScan scan;
  scan.patches = extractPatches(cloud, &viewpoint, drawing.thickness, options);
  scan.index = PatchIndex(scan.patches, 0.5);
  scan.image = RangeImage(cloud.points, viewpoint.cast<float>(), drawing.cell);
  scan.main_normals = std::move(main_normals);
  scan.votes = drawVotingSamples(scan.patches.samples, scan.main_normals, 160);
  return scan;
}

} // namespace pcl_ssfr::testing
