// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/patch_drawing.h>

#include "common/angles.h"

#include <apps/drawing/chart.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr Colour kUpColour{0.72, 0.72, 0.72};
constexpr Colour kDownColour{0.28, 0.28, 0.28};
constexpr double kFaceOnOpacity = 0.12;
constexpr double kEdgeOnOpacity = 0.9;
constexpr double kLineWidth = 1.6; // [pixels]

/// A saturated colour of a hue in [0, 1), evenly bright enough for white paper.
Colour
hueColour(double hue)
{
  const auto channel = [hue](double shift) {
    const double h = 6 * (hue + shift - std::floor(hue + shift));
    const double up = std::clamp(std::abs(h - 3) - 1, 0.0, 1.0);
    return 0.06 + 0.82 * up;
  };
  return {channel(0), channel(2. / 3), channel(1. / 3)};
}

Colour
blend(const Colour& a, const Colour& b, double share)
{
  return {a.red + share * (b.red - a.red), a.green + share * (b.green - a.green), a.blue + share * (b.blue - a.blue)};
}

} // namespace

std::vector<PatchShape>
makePatchShapes(const PatchScan& scan, const Eigen::Isometry3d& T_picture_patches)
{
  const PlanarPatches& patches = scan.patches;
  std::vector<PatchShape> shapes;
  shapes.reserve(static_cast<std::size_t>(patches.size()));
  for (Eigen::Index i = 0; i < patches.size(); ++i) {
    PatchShape shape;
    shape.centre = T_picture_patches * patches.samples.points.col(i);
    shape.normal = T_picture_patches.linear() * patches.samples.normals.col(i);
    const Eigen::Vector3d major = T_picture_patches.linear() * patches.majors.col(i);
    const Eigen::Vector3d along = patches.samples.extents[i] * major;
    const Eigen::Vector3d across = patches.half_minors[i] * shape.normal.cross(major);
    shape.corners = {shape.centre + along + across,
                     shape.centre + along - across,
                     shape.centre - along - across,
                     shape.centre - along + across};
    shapes.push_back(shape);
  }
  return shapes;
}

Colour
directionColour(const Eigen::Vector3d& normal)
{
  const Colour around = hueColour(std::atan2(normal.y(), normal.x()) / (2 * kPi) + 1);
  const double upright = std::clamp(1.4 * std::abs(normal.z()) - 0.35, 0.0, 1.0);
  return blend(around, normal.z() > 0 ? kUpColour : kDownColour, upright);
}

Colour
fateColour(SurfaceFate fate)
{
  switch (fate) {
  case SurfaceFate::Matched:
    return {0.0, 0.58, 0.22};
  case SurfaceFate::Contradicted:
    return {0.84, 0.02, 0.1};
  case SurfaceFate::Unmatched:
    return {0.93, 0.6, 0.1};
  case SurfaceFate::Unseen:
    break;
  }
  return {0.66, 0.66, 0.66};
}

const char*
fateName(SurfaceFate fate)
{
  switch (fate) {
  case SurfaceFate::Matched:
    return "meets a compatible patch";
  case SurfaceFate::Contradicted:
    return "contradicts: hangs where the other sensor saw free space";
  case SurfaceFate::Unmatched:
    return "in view, but nothing like it there";
  case SurfaceFate::Unseen:
    break;
  }
  return "hidden or out of view: says nothing";
}

void
drawPatches(cairo_t* context, const SceneView& view, std::vector<PatchShape> shapes)
{
  Eigen::Vector3d sight = Eigen::Vector3d::Zero(); // along which the view looks
  sight[3 - view.right - view.up] = 1;
  std::stable_sort(shapes.begin(), shapes.end(), [&sight](const PatchShape& a, const PatchShape& b) {
    if (a.rank != b.rank)
      return a.rank < b.rank;
    return std::abs(a.normal.dot(sight)) > std::abs(b.normal.dot(sight));
  });
  cairo_save(context);
  cairo_rectangle(context, view.left, view.top, view.width(), view.height());
  cairo_clip(context);
  for (const PatchShape& shape : shapes) {
    if (!view.shows(shape.centre))
      continue;
    const double face_on = std::abs(shape.normal.dot(sight));
    const double opacity = kEdgeOnOpacity + (kFaceOnOpacity - kEdgeOnOpacity) * std::pow(face_on, 1.5);
    cairo_new_path(context);
    for (const Eigen::Vector3d& corner : shape.corners) {
      const Eigen::Vector2d p = view.pixel(corner);
      cairo_line_to(context, p.x(), p.y());
    }
    cairo_close_path(context);
    setColour(context, shape.colour, opacity);
    cairo_fill_preserve(context);
    setColour(context, shape.colour, std::min(1.0, opacity + 0.15));
    cairo_set_line_width(context, shape.rank > 0 ? kLineWidth + 0.6 : kLineWidth * (1 - 0.6 * face_on));
    cairo_stroke(context);
  }
  cairo_restore(context);
}

void
drawDirectionKey(cairo_t* context, double x, double y, double radius)
{
  constexpr int kSectors = 48;
  constexpr double kHole = 0.5;
  for (int i = 0; i < kSectors; ++i) {
    const double from = 2 * kPi * i / kSectors;
    const double to = 2 * kPi * (i + 1.1) / kSectors;
    cairo_new_path(context);
    cairo_arc_negative(context, x, y, radius, -from, -to);
    cairo_arc(context, x, y, kHole * radius, -to, -from);
    cairo_close_path(context);
    const double middle = (from + to) / 2;
    setColour(context, directionColour({std::cos(middle), std::sin(middle), 0}));
    cairo_fill(context);
  }
  for (const bool up : {true, false}) {
    cairo_new_path(context);
    if (up)
      cairo_arc(context, x, y, kHole * radius - 3, kPi, 0);
    else
      cairo_arc(context, x, y, kHole * radius - 3, 0, kPi);
    cairo_close_path(context);
    setColour(context, up ? kUpColour : kDownColour);
    cairo_fill(context);
  }
  drawAlignedText(context, x, y - 3, "up", 11, 0.5);
  drawAlignedText(context, x, y + 12, "down", 11, 0.5, {1, 1, 1});
}

} // namespace apps
} // namespace pcl_ssfr
