// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/drawing/scene_drawing.h>
#include <apps/view/view_model.h>

#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A planar patch as a coloured rectangle in the frame of a picture.
struct PatchShape {
  std::array<Eigen::Vector3d, 4> corners; ///< [m]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  Colour colour{};
  int rank = 0; ///< higher ones are drawn later
};

/// The patches of a scan; \p T_picture_patches takes them relative to PatchScan::origin. All black.
std::vector<PatchShape>
makePatchShapes(const PatchScan& scan, const Eigen::Isometry3d& T_picture_patches);

/// Colour of a direction in the frame of a picture: the hue says where it points, greys are up (light) and down (dark).
Colour
directionColour(const Eigen::Vector3d& normal);

/// Colour of a fate: green, red, orange, grey.
Colour
fateColour(SurfaceFate fate);

/// What a fate is called in legends.
const char*
fateName(SurfaceFate fate);

/// Draw the patches that a view shows: those seen edge-on as lines, those seen face-on pale.
void
drawPatches(cairo_t* context, const SceneView& view, std::vector<PatchShape> shapes);

/// A key to directionColour(): directions seen from above, with the horizontal ones on the rim.
void
drawDirectionKey(cairo_t* context, double x, double y, double radius);

} // namespace apps
} // namespace pcl_ssfr
