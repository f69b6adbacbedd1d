// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/sphere_drawing.h>

#include "common/angles.h"
#include "preparation/range_image.h"

#include <pcl_ssfr/options.h>

#include <apps/drawing/chart.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kRim = -0.035;                ///< a mark this far beyond the rim (as z) is shown on both halves
constexpr Eigen::Index kMostDirections = 4000; ///< more are merged into cells before they are drawn
constexpr double kMergeCell = 0.02;            ///< [rad]
constexpr double kContrast = 0.4; ///< power of the density that the colours follow: the faint must be seen too
constexpr Colour kNothing{0.985, 0.985, 0.985};
constexpr Colour kGrid{0.75, 0.75, 0.75};

/// Where a direction of this half lies on the disc of radius 1, y upwards.
Eigen::Vector2d
project(const Eigen::Vector3d& direction)
{
  const double z = std::min(std::abs(direction.z()), 1.0);
  const double across = direction.head<2>().norm();
  if (across < 1e-12)
    return Eigen::Vector2d::Zero();
  return std::sqrt(1 - z) * direction.head<2>() / across;
}

/// The direction at a place of the disc.
Eigen::Vector3d
unproject(const Eigen::Vector2d& place, bool upper)
{
  const double z = 1 - place.squaredNorm();
  const double across = std::sqrt(std::max(0.0, 1 - z * z));
  const double r = place.norm();
  const Eigen::Vector2d flat = r > 1e-12 ? Eigen::Vector2d(place / r * across) : Eigen::Vector2d::Zero();
  return {flat.x(), flat.y(), upper ? z : -z};
}

/// From nearly white over orange to dark red, for a share of the highest density.
Colour
heatColour(double share)
{
  static const std::array<Colour, 5> kStops{
      {kNothing, {0.996, 0.85, 0.6}, {0.99, 0.65, 0.35}, {0.87, 0.32, 0.2}, {0.5, 0.0, 0.05}}};
  const double at = std::pow(std::clamp(share, 0.0, 1.0), kContrast) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double f = at - static_cast<double>(i);
  const Colour& a = kStops[i];
  const Colour& b = kStops[i + 1];
  return {a.red + f * (b.red - a.red), a.green + f * (b.green - a.green), a.blue + f * (b.blue - a.blue)};
}

/// The directions, rotated; many are merged by cells.
DirectionSet
rotated(const DirectionSet& directions, const Eigen::Matrix3d& turn)
{
  DirectionSet result;
  result.weights = directions.weights;
  result.directions = turn * directions.directions;
  if (result.size() <= kMostDirections)
    return result;
  const DirectionGrid grid(kMergeCell);
  std::vector<Eigen::Vector4d> cells(grid.size(), Eigen::Vector4d::Zero());
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    Eigen::Vector4d& cell = cells[grid.cell(result.directions.col(i).cast<float>())];
    cell.head<3>() += result.weights[i] * result.directions.col(i);
    cell[3] += result.weights[i];
  }
  cells.erase(std::remove_if(cells.begin(), cells.end(), [](const Eigen::Vector4d& c) { return !(c[3] > 0); }),
              cells.end());
  result.directions.resize(3, static_cast<Eigen::Index>(cells.size()));
  result.weights.resize(static_cast<Eigen::Index>(cells.size()));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    result.directions.col(static_cast<Eigen::Index>(i)) = cells[i].head<3>().normalized();
    result.weights[static_cast<Eigen::Index>(i)] = cells[i][3];
  }
  return result;
}

double
densityAt(const DirectionSet& directions, const Eigen::Vector3d& at, double radius)
{
  const double scale = 4 / (radius * radius);
  const double cut = 1 - radius * radius / 2;
  double sum = 0;
  for (Eigen::Index i = 0; i < directions.size(); ++i) {
    const double c = directions.directions.col(i).dot(at);
    if (c > cut)
      sum += directions.weights[i] * std::exp(-(2 - 2 * c) * scale);
  }
  return sum;
}

void
drawCircleAround(
    cairo_t* context, const Eigen::Vector3d& centre, double chord, bool upper, double x, double y, double radius)
{
  constexpr int kSteps = 48;
  const double angle = 2 * std::asin(std::min(1.0, chord / 2));
  const Eigen::Vector3d u = centre.unitOrthogonal();
  const Eigen::Vector3d v = centre.cross(u);
  bool drawing = false;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = 2 * kPi * i / kSteps;
    const Eigen::Vector3d d = std::cos(angle) * centre + std::sin(angle) * (std::cos(a) * u + std::sin(a) * v);
    if ((d.z() >= 0) != upper) {
      drawing = false;
      continue;
    }
    const Eigen::Vector2d p = project(d);
    if (drawing)
      cairo_line_to(context, x + radius * p.x(), y - radius * p.y());
    else
      cairo_move_to(context, x + radius * p.x(), y - radius * p.y());
    drawing = true;
  }
  setColour(context, kInk, 0.65);
  cairo_set_line_width(context, 1);
  cairo_stroke(context);
}

} // namespace

void
drawSphere(cairo_surface_t* surface,
           cairo_t* context,
           const SphereView& sphere,
           const Eigen::Matrix3d& turn,
           bool upper,
           double x,
           double y,
           double radius,
           unsigned threads)
{
  constexpr int kCell = 2; // pixels share a value
  const DirectionSet directions = rotated(sphere.directions, turn);
  double highest = 1e-12;
  for (const DenseRegion& region : sphere.regions)
    highest = std::max(highest, densityAt(directions, turn * region.peak, sphere.radius));
  const int half = static_cast<int>(radius) / kCell;
  std::vector<double> values(static_cast<std::size_t>((2 * half + 1) * (2 * half + 1)), -1);
  [[maybe_unused]] const auto team = static_cast<int>(threadCount(threads));
#pragma omp parallel for schedule(dynamic, 4) num_threads(team)
  for (int row = -half; row <= half; ++row)
    for (int column = -half; column <= half; ++column) {
      const Eigen::Vector2d place(column * kCell / radius, -row * kCell / radius);
      if (place.norm() <= 1)
        values[static_cast<std::size_t>((row + half) * (2 * half + 1) + column + half)] =
            densityAt(directions, unproject(place, upper), sphere.radius);
    }
  cairo_surface_flush(surface);
  unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int row = -half; row <= half; ++row)
    for (int column = -half; column <= half; ++column) {
      const double value = values[static_cast<std::size_t>((row + half) * (2 * half + 1) + column + half)];
      if (value < 0)
        continue;
      const Colour colour = heatColour(value / highest);
      std::uint32_t pixel = 0xff;
      for (const double channel : {colour.red, colour.green, colour.blue})
        pixel = pixel << 8 | static_cast<std::uint32_t>(std::lround(255 * channel));
      for (int dy = 0; dy < kCell; ++dy)
        for (int dx = 0; dx < kCell; ++dx) {
          const int px = static_cast<int>(x) + column * kCell + dx;
          const int py = static_cast<int>(y) + row * kCell + dy;
          std::memcpy(data + static_cast<std::ptrdiff_t>(py) * stride + 4 * static_cast<std::ptrdiff_t>(px), &pixel, 4);
        }
    }
  cairo_surface_mark_dirty(surface);

  // Circles of 30 and 60 degrees from the vertical, and the rim.
  cairo_set_line_width(context, 1);
  for (const double degrees : {30.0, 60.0, 90.0}) {
    cairo_new_path(context);
    cairo_arc(context, x, y, radius * std::sqrt(1 - std::cos(degrees * kDegree)), 0, 2 * kPi);
    setColour(context, degrees < 90 ? kGrid : kInk, degrees < 90 ? 1 : 0.7);
    cairo_stroke(context);
  }
  for (const DenseRegion& region : sphere.regions)
    drawCircleAround(context, turn * region.peak, sphere.radius, upper, x, y, radius);
}

void
drawSphereMark(cairo_t* context,
               const Eigen::Vector3d& direction,
               bool upper,
               double x,
               double y,
               double radius,
               int number,
               const Colour& colour,
               bool hollow)
{
  if ((upper ? direction.z() : -direction.z()) < kRim)
    return;
  const Eigen::Vector2d p = project(direction);
  const double px = x + radius * p.x();
  const double py = y - radius * p.y();
  if (hollow) {
    cairo_new_path(context);
    cairo_arc(context, px, py, 9, 0, 2 * kPi);
    setColour(context, colour);
    cairo_set_line_width(context, 2);
    cairo_stroke(context);
    return;
  }
  drawDot(context, px, py, 4, colour);
  // The number stands next to it, within the disc.
  const double away = p.norm() > 0.6 ? -1 : 1;
  const Eigen::Vector2d out = p.norm() > 0.1 ? Eigen::Vector2d(away * p.normalized()) : Eigen::Vector2d(0.7, 0.7);
  drawAlignedText(context, px + 18 * out.x(), py - 18 * out.y() + 5, std::to_string(number), 14, 0.5, colour, true);
}

void
drawDensityKey(cairo_t* context, double x, double y)
{
  constexpr int kSteps = 60;
  constexpr double kWidth = 120; // [pixels]
  for (int i = 0; i < kSteps; ++i) {
    cairo_rectangle(context, x + i * kWidth / kSteps, y, kWidth / kSteps + 1, 14);
    setColour(context, heatColour((i + 0.5) / kSteps));
    cairo_fill(context);
  }
  cairo_rectangle(context, x + 0.5, y + 0.5, kWidth, 13);
  setColour(context, kInk, 0.5);
  cairo_set_line_width(context, 1);
  cairo_stroke(context);
  drawText(context, x + kWidth + 10, y + 12, "density: none to the densest", 14);
}

} // namespace apps
} // namespace pcl_ssfr
