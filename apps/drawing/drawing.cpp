// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/drawing/drawing.h>

#include "common/angles.h"

#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace pcl_ssfr {
namespace apps {

namespace {

/// 1, 2 or 5 times a power of ten, at most \p longest.
double
roundLength(double longest)
{
  const double decade = std::pow(10, std::floor(std::log10(longest)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= longest)
      return factor * decade;
  return decade;
}

} // namespace

SurfacePtr
makePicture(int width, int height)
{
  SurfacePtr picture(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy);
  const ContextPtr context = makeContext(picture);
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  return picture;
}

ContextPtr
makeContext(const SurfacePtr& picture)
{
  return {cairo_create(picture.get()), cairo_destroy};
}

void
setColour(cairo_t* context, const Colour& colour, double alpha)
{
  cairo_set_source_rgba(context, colour.red, colour.green, colour.blue, alpha);
}

void
drawText(cairo_t* context, double x, double y, const std::string& text, double size, bool bold)
{
  cairo_select_font_face(
      context, "sans-serif", CAIRO_FONT_SLANT_NORMAL, bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context, size);
  setColour(context, kInk);
  cairo_move_to(context, x, y);
  cairo_show_text(context, text.c_str());
}

double
textWidth(cairo_t* context, const std::string& text)
{
  cairo_text_extents_t extents;
  cairo_text_extents(context, text.c_str(), &extents);
  return extents.x_advance;
}

void
drawScaleBar(cairo_t* context, double left, double baseline, double scale, double longest)
{
  constexpr int kFields = 4;
  const double metres = roundLength(longest / scale);
  const double length = metres * scale;
  for (int i = 0; i < kFields; ++i) {
    cairo_rectangle(context, left + i * length / kFields, baseline - 8, length / kFields, 8);
    if (i % 2 == 0)
      setColour(context, kInk);
    else
      cairo_set_source_rgb(context, 1, 1, 1);
    cairo_fill_preserve(context);
    setColour(context, kInk);
    cairo_set_line_width(context, 1);
    cairo_stroke(context);
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g m", metres);
  drawText(context, left + length + 10, baseline, text.data(), 16);
}

double
drawLegendEntry(cairo_t* context, double left, double baseline, const Colour& colour, const std::string& label)
{
  cairo_rectangle(context, left, baseline - 13, 16, 16);
  setColour(context, colour);
  cairo_fill(context);
  drawText(context, left + 24, baseline, label, 16);
  return left + 24 + textWidth(context, label) + 32;
}

void
drawDot(cairo_t* context, double x, double y, double radius, const Colour& colour)
{
  cairo_new_path(context); // text leaves a point behind
  cairo_arc(context, x, y, radius, 0, 2 * kPi);
  setColour(context, colour);
  cairo_fill_preserve(context);
  cairo_set_source_rgb(context, 1, 1, 1);
  cairo_set_line_width(context, radius / 3);
  cairo_stroke(context);
}

void
writePng(const std::string& path, const SurfacePtr& picture)
{
  std::string png;
  const auto append = [](void* to, const unsigned char* bytes, unsigned int count) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), count);
    return CAIRO_STATUS_SUCCESS;
  };
  const cairo_status_t status = cairo_surface_write_to_png_stream(picture.get(), append, &png);
  if (status != CAIRO_STATUS_SUCCESS)
    throw io::IoError(path + ": cannot be written: " + cairo_status_to_string(status));
  io::writeFile(path, png);
}

} // namespace apps
} // namespace pcl_ssfr
