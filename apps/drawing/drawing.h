// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cairo.h>

#include <memory>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// Red, green, blue, each in [0, 1].
struct Colour {
  double red;
  double green;
  double blue;
};
constexpr Colour kInk{0.13, 0.13, 0.13};

/// What cairo draws into, freed with the object.
using SurfacePtr = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using ContextPtr = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

/// A white picture [pixels].
SurfacePtr
makePicture(int width, int height);
ContextPtr
makeContext(const SurfacePtr& picture);

void
setColour(cairo_t* context, const Colour& colour, double alpha = 1);

/// Text in ink; \p y is its baseline, \p size in pixels.
void
drawText(cairo_t* context, double x, double y, const std::string& text, double size, bool bold = false);

/// Width of a text in the font that was used last [pixels].
double
textWidth(cairo_t* context, const std::string& text);

/// A bar of a round length with its label; \p scale in pixels a metre, about \p longest pixels at most.
void
drawScaleBar(cairo_t* context, double left, double baseline, double scale, double longest = 300);

/// A square of a colour and what it means; returns where the next entry begins.
double
drawLegendEntry(cairo_t* context, double left, double baseline, const Colour& colour, const std::string& label);

/// A disc with a white rim.
void
drawDot(cairo_t* context, double x, double y, double radius, const Colour& colour);

/// Replace a file by the picture. \throw io::IoError naming the file
void
writePng(const std::string& path, const SurfacePtr& picture);

} // namespace apps
} // namespace pcl_ssfr
