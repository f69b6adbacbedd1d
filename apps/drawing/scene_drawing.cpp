// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/drawing/scene_drawing.h>

#include "common/angles.h"
#include "common/rotation_math.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <unordered_set>

namespace pcl_ssfr {
namespace apps {

namespace {

// Layout of drawScans [pixels].
constexpr int kMargin = 28;
constexpr int kHeader = 84;
constexpr int kCaption = 30;
constexpr int kFooter = 64;

constexpr std::size_t kMaxSamples = 400000; ///< points a scan that decide about view and cuts
constexpr double kCell = 0.1;               ///< of the thinning before percentiles are taken [m]
constexpr double kOutliers = 0.01;          ///< share of the thinned points cut off at each side
constexpr double kViewMargin = 0.03;        ///< around what is shown, share of the extent
constexpr double kMinExtent = 1;            ///< of what is shown [m]

// ---------------------------------------------------------------------------------------------------------------------
// What to show

PicturePoints
thin(const PicturePoints& points)
{
  PicturePoints result;
  std::unordered_set<std::uint64_t> cells;
  const std::size_t step = points.size() / kMaxSamples + 1;
  for (std::size_t i = 0; i < points.size(); i += step) {
    std::uint64_t key = 0;
    for (Eigen::Index k = 0; k < 3; ++k) {
      constexpr std::int64_t kHalf = 1 << 20;
      const double cell = std::clamp(std::floor(points[i][k] / kCell), -1.0 * kHalf, 1.0 * kHalf - 1);
      key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + kHalf);
    }
    if (cells.insert(key).second)
      result.push_back(points[i]);
  }
  return result;
}

std::vector<float>
coordinates(const PicturePoints& points, Eigen::Index axis)
{
  std::vector<float> values;
  values.reserve(points.size());
  for (const Eigen::Vector3f& point : points)
    values.push_back(point[axis]);
  return values;
}

/// The range that all but a share of kOutliers of the values at each end lie in.
Range
trimmedRange(std::vector<float> values)
{
  if (values.empty())
    return {};
  const auto cut = static_cast<std::ptrdiff_t>(kOutliers * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const double low = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, *(values.end() - 1 - cut)};
}

Range
united(const Range& a, const Range& b)
{
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

/// A histogram of values over a range.
std::vector<double>
histogramOf(const std::vector<float>& values, const Range& range, std::size_t bins)
{
  std::vector<double> counts(bins, 0);
  for (const float value : values) {
    const double at = (value - range.low) / std::max(range.size(), 1e-9) * static_cast<double>(bins);
    if (at >= 0 && at < static_cast<double>(bins))
      counts[static_cast<std::size_t>(at)] += 1;
  }
  return counts;
}

double
sumOfSquares(const std::vector<double>& values)
{
  double sum = 0;
  for (const double value : values)
    sum += value * value;
  return sum;
}

/// A rotation about the vertical that lays the walls along the edges of the picture and the longer side across it.
Eigen::Matrix3d
straighten(const PicturePoints& thinned)
{
  constexpr int kSteps = 90;
  constexpr std::size_t kBins = 400;
  double best = -1;
  double best_angle = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double angle = step * (kPi / 2 / kSteps);
    const auto c = static_cast<float>(std::cos(angle));
    const auto s = static_cast<float>(std::sin(angle));
    std::vector<float> u;
    std::vector<float> v;
    const std::size_t stride = thinned.size() / 20000 + 1;
    for (std::size_t i = 0; i < thinned.size(); i += stride) {
      u.push_back(c * thinned[i].x() - s * thinned[i].y());
      v.push_back(s * thinned[i].x() + c * thinned[i].y());
    }
    // Bins are equally wide along both axes, and each axis has its own: a scan may lie far from its origin.
    const Range along_u = trimmedRange(u), along_v = trimmedRange(v);
    const double width = std::max(along_u.size(), along_v.size());
    const double sharpness = sumOfSquares(histogramOf(u, {along_u.low, along_u.low + width}, kBins)) +
                             sumOfSquares(histogramOf(v, {along_v.low, along_v.low + width}, kBins));
    // A picture that is nearly straight already is left as it is.
    if (sharpness > best * (step == 0 ? 1 : 1.02)) {
      best = sharpness;
      best_angle = angle;
    }
  }
  Eigen::Matrix3d R = Eigen::AngleAxisd(best_angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  PicturePoints rotated;
  for (const Eigen::Vector3f& point : thinned)
    rotated.push_back(R.cast<float>() * point);
  if (trimmedRange(coordinates(rotated, 1)).size() > 1.1 * trimmedRange(coordinates(rotated, 0)).size())
    R = Eigen::AngleAxisd(-kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R;
  return R;
}

/// Heights that the top view shows: from just above the floor to just under the ceiling, where there are such.
Range
topViewHeights(const PicturePoints& thinned, const Range& all)
{
  constexpr double kBin = 0.1;           // [m]
  constexpr double kPeakShare = 0.12;    // of the thinned points in three bins: a floor or a ceiling
  constexpr double kFloorMargin = 0.15;  // [m]
  constexpr double kCeilingMargin = 0.4; // [m]
  constexpr double kRoom = 1.2;          // least height between a floor and a ceiling [m]
  constexpr double kLeastShown = 0.3;    // [m]
  const auto bins = static_cast<std::size_t>(std::clamp(all.size() / kBin, 3.0, 1000.0));
  const auto counts = histogramOf(coordinates(thinned, 2), all, bins);
  const double width = all.size() / static_cast<double>(bins);
  const double needed = kPeakShare * static_cast<double>(thinned.size());
  const auto peak = [&](std::size_t i) {
    return counts[i] + (i > 0 ? counts[i - 1] : 0) + (i + 1 < bins ? counts[i + 1] : 0) > needed;
  };
  // The lowest and the highest such layer; a single one is what its half of the heights makes likely.
  std::size_t floor = 0;
  while (floor < bins && !peak(floor))
    ++floor;
  if (floor == bins)
    return all;
  std::size_t ceiling = bins - 1;
  while (!peak(ceiling))
    --ceiling;
  std::size_t floor_top = floor;
  while (floor_top + 1 < bins && peak(floor_top + 1))
    ++floor_top;
  std::size_t ceiling_bottom = ceiling;
  while (ceiling_bottom > 0 && peak(ceiling_bottom - 1))
    --ceiling_bottom;
  const bool two = static_cast<double>(ceiling_bottom) - static_cast<double>(floor_top) > kRoom / width;
  Range shown = all;
  if (two || floor < bins / 2)
    shown.low = all.low + static_cast<double>(floor_top + 1) * width + kFloorMargin;
  if (two || floor >= bins / 2)
    shown.high = all.low + static_cast<double>(ceiling_bottom) * width - kCeilingMargin;
  return shown.size() < kLeastShown ? all : shown;
}

Range
widened(const Range& range)
{
  const double grow = std::max(kViewMargin * range.size(), (kMinExtent - range.size()) / 2);
  return {range.low - grow, range.high + grow};
}

// ---------------------------------------------------------------------------------------------------------------------
// Drawing

/// How much of each pixel of a view a scan covers, 0 to 1: more points, darker, with the eye's logarithm.
std::vector<float>
coverage(const ScanLayer& layer, const SceneView& view)
{
  constexpr double kFullShade = 0.9; // quantile of the hit pixels that is drawn darkest
  constexpr float kLeastShade = 0.3F;
  constexpr double kDotRadius = 1.6; // [pixels]
  const int width = view.width();
  const int height = view.height();
  std::vector<float> counts(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  const auto at = [&](int x, int y) -> float& {
    return counts[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  };
  for (const Eigen::Vector3f& point : layer.points) {
    if (view.heights && (point.z() < view.heights->low || point.z() > view.heights->high))
      continue;
    const double x = (point[view.right] - view.horizontal.low) * view.scale - 0.5;
    const double y = (view.vertical.high - point[view.up]) * view.scale - 0.5;
    if (!(x > 0 && x < width - 1 && y > 0 && y < height - 1))
      continue;
    // A soft dot of three pixels: the nearest gets most, so that sparse walls stay lines and dense ones stay sharp.
    const int column = static_cast<int>(std::lround(x));
    const int row = static_cast<int>(std::lround(y));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double away = std::hypot(column + dx - x, row + dy - y);
        if (away < kDotRadius && column + dx >= 0 && column + dx < width && row + dy >= 0 && row + dy < height)
          at(column + dx, row + dy) += static_cast<float>(1 - away / kDotRadius);
      }
  }
  std::vector<float> hit;
  for (const float count : counts)
    if (count > 0)
      hit.push_back(count);
  if (hit.empty())
    return counts;
  const auto quantile = hit.begin() + static_cast<std::ptrdiff_t>(kFullShade * static_cast<double>(hit.size() - 1));
  std::nth_element(hit.begin(), quantile, hit.end());
  const float full = std::log1p(std::max(*quantile, 0.5F));
  for (float& count : counts)
    if (count > 0) {
      const float shade = std::min(1.0F, std::log1p(count) / full);
      count = std::min(1.0F, count * 3) * (kLeastShade + (1 - kLeastShade) * shade);
    }
  return counts;
}

/// The colour of two inks on each other.
Colour
mixed(const Colour& a, const Colour& b)
{
  return {a.red * b.red, a.green * b.green, a.blue * b.blue};
}

} // namespace

int
SceneView::width() const
{
  return static_cast<int>(std::lround(horizontal.size() * scale));
}

int
SceneView::height() const
{
  return static_cast<int>(std::lround(vertical.size() * scale));
}

Eigen::Vector2d
SceneView::pixel(const Eigen::Vector3d& point) const
{
  return {left + (point[right] - horizontal.low) * scale, top + (vertical.high - point[up]) * scale};
}

bool
SceneView::shows(const Eigen::Vector3d& point) const
{
  return point[right] > horizontal.low && point[right] < horizontal.high && point[up] > vertical.low &&
         point[up] < vertical.high && (!heights || (point.z() >= heights->low && point.z() <= heights->high));
}

ScanLayer
makeScanLayer(const io::LoadedCloud& cloud,
              const Eigen::Isometry3d& T_picture_cloud,
              const Colour& colour,
              std::string label,
              const std::optional<Eigen::Vector3d>& sensor)
{
  ScanLayer layer;
  layer.colour = colour;
  layer.label = std::move(label);
  layer.points.reserve(cloud.points->size());
  for (const auto& point : *cloud.points)
    if (point.getVector3fMap().allFinite())
      layer.points.push_back((T_picture_cloud * point.getVector3fMap().cast<double>()).cast<float>());
  layer.thinned = thin(layer.points);
  const std::optional<Eigen::Vector3d>& known = sensor ? sensor : cloud.viewpoint;
  if (known || cloud.offset.isZero(0))
    layer.sensor = (T_picture_cloud * (known.value_or(Eigen::Vector3d::Zero()) - cloud.offset)).cast<float>();
  return layer;
}

Eigen::Isometry3d
pictureFrame(const io::LoadedCloud& target, const Eigen::Vector3d& up)
{
  const Eigen::Isometry3d T_picture_target(rotationOnto(up, Eigen::Vector3d::UnitZ()));
  return straighten(makeScanLayer(target, T_picture_target, kTargetColour, "").thinned) * T_picture_target;
}

SceneViews
makeSceneViews(const std::vector<const ScanLayer*>& layers, const ViewLimits& limits)
{
  const PicturePoints& first = layers.front()->thinned;
  std::array<Range, 3> shown;
  for (Eigen::Index k = 0; k < 3; ++k) {
    Range range = trimmedRange(coordinates(first, k));
    for (const ScanLayer* layer : layers)
      if (!layer->thinned.empty())
        range = united(range, trimmedRange(coordinates(layer->thinned, k)));
    shown[static_cast<std::size_t>(k)] = widened(range);
  }
  SceneViews views;
  SceneView& top = views.top;
  top.horizontal = shown[0];
  top.vertical = shown[1];
  const Range heights = trimmedRange(coordinates(first, 2));
  top.heights = topViewHeights(first, heights);
  const bool no_floor = top.heights->low > heights.low;
  const bool no_ceiling = top.heights->high < heights.high;
  top.remark = no_floor && no_ceiling ? ", floor and ceiling cut away"
               : no_floor             ? ", floor cut away"
               : no_ceiling           ? ", ceiling cut away"
                                      : "";
  top.scale = std::min(
      {limits.width / shown[0].size(), limits.top_height / shown[1].size(), limits.side_height / shown[2].size()});
  SceneView& side = views.side;
  side.horizontal = shown[0];
  side.vertical = shown[2];
  side.up = 2;
  side.scale = top.scale;
  return views;
}

SceneView
fitted(SceneView view, int width, int height)
{
  view.scale = std::min(width / view.horizontal.size(), height / view.vertical.size());
  return view;
}

std::string
shortFileName(const std::string& path)
{
  constexpr std::size_t kLongest = 28;
  const std::string name = std::filesystem::path(path).filename().string();
  return name.size() <= kLongest ? name : name.substr(0, kLongest - 3) + "...";
}

void
drawPoints(cairo_surface_t* surface,
           const SceneView& view,
           const std::vector<const ScanLayer*>& layers,
           double strength)
{
  const int width = view.width();
  const int height = view.height();
  std::vector<std::vector<float>> inks;
  inks.reserve(layers.size());
  for (const ScanLayer* layer : layers)
    inks.push_back(coverage(*layer, view));
  cairo_surface_flush(surface);
  unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<double, 3> colour{{1, 1, 1}};
      for (std::size_t l = 0; l < layers.size(); ++l) {
        const double ink =
            strength *
            static_cast<double>(
                inks[l][static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)]);
        colour[0] *= 1 - ink * (1 - layers[l]->colour.red);
        colour[1] *= 1 - ink * (1 - layers[l]->colour.green);
        colour[2] *= 1 - ink * (1 - layers[l]->colour.blue);
      }
      std::uint32_t pixel = 0xff;
      for (const double value : colour)
        pixel = pixel << 8 | static_cast<std::uint32_t>(std::lround(255 * value));
      std::memcpy(data + static_cast<std::ptrdiff_t>(view.top + y) * stride + 4 * (view.left + x), &pixel, 4);
    }
  cairo_surface_mark_dirty(surface);
}

void
drawSensor(cairo_t* context, const SceneView& view, const ScanLayer& layer)
{
  if (!layer.sensor)
    return;
  const double x = ((*layer.sensor)[view.right] - view.horizontal.low) * view.scale;
  const double y = (view.vertical.high - (*layer.sensor)[view.up]) * view.scale;
  if (!(x > 0 && x < view.width() && y > 0 && y < view.height()))
    return;
  drawDot(context, view.left + x, view.top + y, 6, layer.colour);
}

void
drawFrame(cairo_t* context, const SceneView& view)
{
  cairo_rectangle(context, view.left - 0.5, view.top - 0.5, view.width() + 1, view.height() + 1);
  setColour(context, kInk, 0.35);
  cairo_set_line_width(context, 1);
  cairo_stroke(context);
}

void
drawScans(const std::string& path,
          const std::string& title,
          const std::string& subtitle,
          SceneViews views,
          const std::vector<const ScanLayer*>& layers)
{
  SceneView& top = views.top;
  SceneView& side = views.side;
  const int height = kHeader + kCaption + top.height() + kCaption + side.height() + kFooter;
  const SurfacePtr surface = makePicture(kScansWidth, height);
  const ContextPtr context = makeContext(surface);
  drawText(context.get(), kMargin, 38, title, 26, true);
  drawText(context.get(), kMargin, 66, subtitle, 17);

  top.left = side.left = (kScansWidth - top.width()) / 2;
  top.top = kHeader + kCaption;
  side.top = top.top + top.height() + kCaption;
  for (const SceneView* view : {&top, &side}) {
    drawPoints(surface.get(), *view, layers);
    drawFrame(context.get(), *view);
    for (const ScanLayer* layer : layers)
      drawSensor(context.get(), *view, *layer);
  }
  drawText(context.get(), top.left, top.top - 9, "From above" + top.remark, 15);
  drawText(context.get(), side.left, side.top - 9, "From the side", 15);

  const double baseline = height - 24;
  double left = kMargin;
  for (const ScanLayer* layer : layers)
    left = drawLegendEntry(context.get(), left, baseline, layer->colour, layer->label);
  if (layers.size() > 1)
    left = drawLegendEntry(context.get(), left, baseline, mixed(kTargetColour, kSourceColour), "both; dots: sensors");
  drawScaleBar(context.get(), std::max<double>(left, kScansWidth - 420), baseline, top.scale);
  writePng(path, surface);
}

} // namespace apps
} // namespace pcl_ssfr
