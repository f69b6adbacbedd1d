// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scene_pictures.h>

#include "common/angles.h"

#include <apps/drawing/drawing.h>
#include <apps/io/io_error.h>
#include <apps/simulation/ray_caster.h>

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ssfr::simulation {

namespace {

using apps::Colour;
using apps::kInk;

// Layout [pixels].
constexpr int kWidth = 1000;
constexpr int kMargin = 24;
constexpr int kHeader = 84;
constexpr int kCaption = 30;
constexpr int kFooter = 56;
constexpr int kMaxTopHeight = 450;
constexpr int kMaxViewHeight = 500;
constexpr int kViewWidth = kWidth - 2 * kMargin;
constexpr int kSubsamples = 2; // a pixel side

constexpr double kMaxWall = 0.7;     // what is thinner where it is cut is drawn as cut through [m]
constexpr double kHighCeiling = 5;   // from here on the cut is a share of the height [m]
constexpr double kCutShare = 0.66;   // of the height under a high ceiling
constexpr double kCutHeight = 1.6;   // above the floor, under a lower one [m]
constexpr double kFieldOfView = 0.5; // tangent of half the horizontal angle
constexpr double kElevation = 0.95;  // of the camera above the horizon [rad]
constexpr double kAside = 0.42;      // azimuth from the middle of the longer side [rad]
constexpr double kFilled = 0.96;     // share of the width of the view that is used
constexpr Colour kScanColour{0.835, 0.369, 0.0};
constexpr double kCutLight = 0.29; // brightness of what is cut through

/// What a ray of a picture meets.
struct Sample {
  double depth = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  std::uint16_t material = 0;
  bool cut = false; ///< the inside of what the cut goes through
};

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction; ///< unit
};

/// Somewhere to look from: pixels to rays, points to pixels.
class Camera {
public:
  virtual ~Camera() = default;
  virtual Ray
  rayOf(double x, double y) const = 0;
  virtual Eigen::Vector2d
  pixelOf(const Eigen::Vector3d& point) const = 0;
};

class TopCamera : public Camera {
public:
  TopCamera(const Eigen::AlignedBox3d& box, double scale) : box_(box), scale_(scale) {}
  Ray
  rayOf(double x, double y) const override
  {
    return {{box_.min().x() + x / scale_, box_.max().y() - y / scale_, box_.max().z() + 1}, -Eigen::Vector3d::UnitZ()};
  }
  Eigen::Vector2d
  pixelOf(const Eigen::Vector3d& point) const override
  {
    return {(point.x() - box_.min().x()) * scale_, (box_.max().y() - point.y()) * scale_};
  }

private:
  Eigen::AlignedBox3d box_;
  double scale_; ///< pixels a metre
};

/// Looks at a box from outside and above, from so far that it fills the picture.
class ViewCamera : public Camera {
public:
  ViewCamera(const Eigen::AlignedBox3d& box, int width, int max_height)
  {
    const Eigen::Vector3d size = box.sizes();
    const bool along_x = size.x() >= size.y();
    const double slimness = along_x ? size.y() / size.x() : size.x() / size.y();
    const double azimuth = (along_x ? -kPi / 2 : 0) + kAside * std::min(1.0, 1.5 * slimness);
    const Eigen::Vector3d away(
        std::cos(kElevation) * std::cos(azimuth), std::cos(kElevation) * std::sin(azimuth), std::sin(kElevation));
    axes_.col(2) = away;
    axes_.col(0) = Eigen::Vector3d::UnitZ().cross(away).normalized();
    axes_.col(1) = away.cross(axes_.col(0));
    focal_ = width / 2.0 / kFieldOfView;
    middle_ = {width / 2.0, max_height / 2.0};
    // Step back until every corner is inside, then centre what is seen; again, as one moves the other.
    constexpr int kRounds = 4;
    Eigen::Vector3d centre = box.center();
    Eigen::AlignedBox2d seen;
    for (int round = 0; round < kRounds; ++round) {
      double distance = 0;
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d corner = axes_.transpose() * (cornerOf(box, i) - centre);
        const double x = std::abs(corner.x()) * focal_ / (kFilled * middle_.x());
        const double y = std::abs(corner.y()) * focal_ / (kFilled * middle_.y());
        distance = std::max(distance, corner.z() + std::max(x, y));
      }
      eye_ = centre + distance * away;
      seen.setEmpty();
      for (int i = 0; i < 8; ++i)
        seen.extend(pixelOf(cornerOf(box, i)));
      const Eigen::Vector2d off = (seen.center() - middle_) * (distance / focal_);
      centre += axes_.col(0) * off.x() - axes_.col(1) * off.y();
    }
    height_ = std::min(max_height, static_cast<int>(std::ceil(seen.sizes().y() + (1 - kFilled) * width)));
    middle_.y() += (height_ - max_height) / 2.0;
  }
  /// Of the picture, no more than is needed [pixels].
  int
  height() const
  {
    return height_;
  }
  Ray
  rayOf(double x, double y) const override
  {
    return {eye_, (axes_ * Eigen::Vector3d(x - middle_.x(), middle_.y() - y, -focal_)).normalized()};
  }
  Eigen::Vector2d
  pixelOf(const Eigen::Vector3d& point) const override
  {
    const Eigen::Vector3d seen = axes_.transpose() * (point - eye_);
    return {middle_.x() - focal_ * seen.x() / seen.z(), middle_.y() + focal_ * seen.y() / seen.z()};
  }

private:
  static Eigen::Vector3d
  cornerOf(const Eigen::AlignedBox3d& box, int index)
  {
    return box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(index));
  }

  Eigen::Matrix3d axes_; ///< columns: right, up, towards the eye
  Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d middle_;
  double focal_ = 1; ///< [pixels]
  int height_ = 0;
};

// ---------------------------------------------------------------------------------------------------------------------
// What is shown

/// The height above which everything is taken off, when most of the path has a ceiling [m].
std::optional<double>
cutHeight(const Scene& scene, const RayCaster& caster)
{
  constexpr double kEye = 1;        // above the path [m]
  constexpr double kHighest = 1000; // [m]
  std::vector<double> clearances;
  for (const Eigen::Vector3d& point : scene.path)
    if (const auto hit = caster.cast(point + kEye * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ(), kHighest))
      clearances.push_back(hit->distance + kEye);
  if (clearances.size() * 2 <= scene.path.size())
    return std::nullopt;
  const auto middle = clearances.begin() + static_cast<std::ptrdiff_t>(clearances.size() / 2);
  std::nth_element(clearances.begin(), middle, clearances.end());
  return scene.path.front().z() + (*middle < kHighCeiling ? kCutHeight : kCutShare * *middle);
}

class Painter {
public:
  Painter(const RayCaster& caster, std::optional<double> cut, unsigned threads)
      : caster_(caster), cut_(cut), threads_(threads == 0 ? omp_get_max_threads() : static_cast<int>(threads))
  {}

  /// Shade every pixel; ARGB as cairo has it.
  std::vector<std::uint32_t>
  paint(const Camera& camera, int width, int height) const
  {
    const int columns = width * kSubsamples;
    const int rows = height * kSubsamples;
    std::vector<Sample> samples(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads_)
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] =
            look(camera.rayOf((column + 0.5) / kSubsamples, (row + 0.5) / kSubsamples));
    const auto at = [&](int column, int row) -> const Sample& {
      column = std::clamp(column, 0, columns - 1);
      row = std::clamp(row, 0, rows - 1);
      return samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(column)];
    };
    std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        Ink sum;
        for (int i = 0; i < kSubsamples * kSubsamples; ++i) {
          const int column = x * kSubsamples + i % kSubsamples;
          const int row = y * kSubsamples + i / kSubsamples;
          const Sample& here = at(column, row);
          const bool edge = isEdge(here, at(column - 1, row), at(column + 1, row)) ||
                            isEdge(here, at(column, row - 1), at(column, row + 1));
          const Ink ink = inkOf(here);
          sum.light += ink.light * (edge ? kEdgeShade : 1);
          sum.flat += ink.flat;
          sum.painted += ink.painted;
        }
        pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
            packed(sum);
      }
    return pixels;
  }

private:
  /// What is added up over a pixel.
  struct Ink {
    double light = 0;   ///< brightness
    double flat = 0;    ///< share of level surfaces, which are warm; walls are cool
    double painted = 0; ///< number of samples that met anything; the others are paper
  };

  static constexpr double kFar = 10000; // [m]
  static constexpr double kEdgeShade = 0.6;

  Sample
  look(Ray ray) const
  {
    Sample sample;
    double skipped = 0;
    if (cut_ && ray.origin.z() > *cut_) {
      if (ray.direction.z() >= 0)
        return sample;
      skipped = (*cut_ - ray.origin.z()) / ray.direction.z();
      ray.origin += skipped * ray.direction;
      if (isInside(ray.origin)) {
        sample.cut = true;
        sample.depth = skipped;
        sample.normal = Eigen::Vector3d::UnitZ();
        return sample;
      }
    }
    if (const auto hit = caster_.cast(ray.origin, ray.direction, kFar)) {
      sample.depth = skipped + hit->distance;
      sample.normal = hit->normal;
      sample.material = hit->material;
    }
    return sample;
  }

  /// Between two surfaces that are a wall's thickness apart.
  bool
  isInside(const Eigen::Vector3d& point) const
  {
    const auto thin = [&](const Eigen::Vector3d& direction) {
      const auto one = caster_.cast(point, direction, kMaxWall);
      if (!one)
        return false;
      const auto other = caster_.cast(point, -direction, kMaxWall);
      return other && one->distance + other->distance < kMaxWall && std::abs(one->normal.dot(other->normal)) > 0.5;
    };
    return thin(Eigen::Vector3d::UnitX()) || thin(Eigen::Vector3d::UnitY());
  }

  /// A corner or a step between neighbours in a row or column: depth does not go on as a plane does.
  static bool
  isEdge(const Sample& here, const Sample& before, const Sample& after)
  {
    constexpr double kCorner = 0.8;  // cosine
    constexpr double kStep = 0.0025; // of the depth
    if (std::isinf(here.depth))
      return false;
    if (here.cut != before.cut || here.cut != after.cut || std::isinf(before.depth) || std::isinf(after.depth))
      return true;
    return here.normal.dot(after.normal) < kCorner || here.normal.dot(before.normal) < kCorner ||
           2 * here.depth - before.depth - after.depth < -kStep * here.depth;
  }

  /// Diffuse light from two sides and the sky, on a grey of the material's reflectance.
  Ink
  inkOf(const Sample& sample) const
  {
    if (sample.cut)
      return {kCutLight, 0, 1};
    if (std::isinf(sample.depth))
      return {};
    const Eigen::Vector3d sun = Eigen::Vector3d(-0.45, -0.75, 1.1).normalized();
    const Eigen::Vector3d lamp = Eigen::Vector3d(0.8, -0.3, 0.4).normalized();
    const double light = 0.45 + 0.45 * std::max(0.0, sample.normal.dot(sun)) +
                         0.17 * std::max(0.0, sample.normal.dot(lamp)) + 0.09 * sample.normal.z();
    const double grey = 0.62 + 0.38 * std::sqrt(caster_.material(sample.material).reflectance);
    return {std::min(1.0, light * grey), std::round(sample.normal.z() * sample.normal.z()), 1};
  }

  static std::uint32_t
  packed(const Ink& sum)
  {
    constexpr double kLevels = 24; // of brightness; few, so that the file stays small
    const Eigen::Vector3d warm(1, 0.965, 0.9);
    const Eigen::Vector3d cool(0.93, 0.97, 1);
    Eigen::Vector3d colour = Eigen::Vector3d::Ones();
    if (sum.painted > 0) {
      const double covered = sum.painted / (kSubsamples * kSubsamples);
      const double flat = sum.flat / sum.painted;
      const double light = std::round(kLevels * sum.light / sum.painted) / kLevels;
      colour = (1 - covered) * colour + covered * light * (flat * warm + (1 - flat) * cool);
    }
    std::uint32_t pixel = 0xff;
    for (Eigen::Index k = 0; k < 3; ++k)
      pixel = pixel << 8 | static_cast<std::uint32_t>(std::lround(255 * std::clamp(colour[k], 0.0, 1.0)));
    return pixel;
  }

  const RayCaster& caster_;
  std::optional<double> cut_;
  int threads_;
};

// ---------------------------------------------------------------------------------------------------------------------
// Drawing

/// Where a view lies in the picture [pixels].
struct Frame {
  int left;
  int top;
  int width;
  int height;
};

void
copyPixels(const apps::SurfacePtr& picture, const Frame& frame, const std::vector<std::uint32_t>& pixels)
{
  cairo_surface_flush(picture.get());
  unsigned char* data = cairo_image_surface_get_data(picture.get());
  const int stride = cairo_image_surface_get_stride(picture.get());
  const auto width = static_cast<std::size_t>(frame.width);
  for (int y = 0; y < frame.height; ++y)
    std::memcpy(data + static_cast<std::ptrdiff_t>(frame.top + y) * stride +
                    4 * static_cast<std::ptrdiff_t>(frame.left),
                pixels.data() + static_cast<std::size_t>(y) * width,
                4 * width);
  cairo_surface_mark_dirty(picture.get());
}

/// The scans in order: dots, joined by a line; the first and the last are numbered.
void
drawScans(cairo_t* context, const Frame& frame, const Camera& camera, const std::vector<Eigen::Isometry3d>& poses)
{
  constexpr double kRadius = 5;
  cairo_save(context);
  cairo_rectangle(context, frame.left, frame.top, frame.width, frame.height);
  cairo_clip(context);
  std::vector<Eigen::Vector2d> dots;
  dots.reserve(poses.size());
  for (const Eigen::Isometry3d& pose : poses)
    dots.emplace_back(camera.pixelOf(pose.translation()) + Eigen::Vector2d(frame.left, frame.top));
  for (const Eigen::Vector2d& dot : dots)
    cairo_line_to(context, dot.x(), dot.y());
  apps::setColour(context, kScanColour, 0.6);
  cairo_set_line_width(context, 1.5);
  cairo_stroke(context);
  // All rims first: close dots become a band.
  for (const auto& [radius, colour] : {std::pair(kRadius + 1.5, Colour{1, 1, 1}), std::pair(kRadius, kScanColour)})
    for (const Eigen::Vector2d& dot : dots) {
      cairo_arc(context, dot.x(), dot.y(), radius, 0, 2 * kPi);
      apps::setColour(context, colour);
      cairo_fill(context);
    }
  if (!dots.empty())
    apps::drawText(context, dots.front().x() + 8, dots.front().y() - 6, "1", 15, true);
  if (dots.size() > 1)
    apps::drawText(context, dots.back().x() + 8, dots.back().y() - 6, std::to_string(dots.size()), 15, true);
  cairo_restore(context);
}

void
drawFrame(cairo_t* context, const Frame& frame)
{
  cairo_rectangle(context, frame.left - 0.5, frame.top - 0.5, frame.width + 1, frame.height + 1);
  apps::setColour(context, kInk, 0.35);
  cairo_set_line_width(context, 1);
  cairo_stroke(context);
}

} // namespace

void
drawScene(const std::string& path,
          const Scene& scene,
          const SurfaceModel& surfaces,
          const std::vector<Eigen::Isometry3d>& T_world_sensor,
          unsigned threads)
{
  const RayCaster caster(surfaces);
  const std::optional<double> cut = cutHeight(scene, caster);
  Eigen::AlignedBox3d box = boundsOf(surfaces);
  if (cut)
    box.max().z() = std::min(box.max().z(), *cut);
  // Of a scene that goes on and on only what lies about the path.
  constexpr double kLeastAbout = 20; // [m]
  Eigen::AlignedBox3d about;
  for (const Eigen::Vector3d& point : scene.path)
    about.extend(point);
  const double reach = std::max(kLeastAbout, about.diagonal().norm() / 2);
  box.min().head<2>() = box.min().head<2>().cwiseMax((about.min().array() - reach).matrix().head<2>());
  box.max().head<2>() = box.max().head<2>().cwiseMin((about.max().array() + reach).matrix().head<2>());
  const double margin = 0.01 * box.diagonal().head<2>().norm() + 0.1;
  box.min().head<2>().array() -= margin;
  box.max().head<2>().array() += margin;

  const Eigen::Vector3d size = box.sizes();
  const double scale = std::min((kWidth - 2 * kMargin) / size.x(), kMaxTopHeight / size.y());
  Frame top{0, kHeader + kCaption, static_cast<int>(std::lround(size.x() * scale)), 0};
  top.height = static_cast<int>(std::lround(size.y() * scale));
  top.left = (kWidth - top.width) / 2;
  const ViewCamera oblique(box, kViewWidth, kMaxViewHeight);
  const Frame view{kMargin, top.top + top.height + kCaption, kViewWidth, oblique.height()};
  const int height = view.top + view.height + kFooter;

  const apps::SurfacePtr picture = apps::makePicture(kWidth, height);
  const apps::ContextPtr context = apps::makeContext(picture);
  apps::drawText(context.get(), kMargin, 38, scene.name, 26, true);
  apps::drawText(context.get(), kMargin, 66, scene.description, 17);

  const TopCamera above(box, scale);
  const Painter painter(caster, cut, threads);
  for (const auto& [camera, frame] :
       {std::pair<const Camera&, const Frame&>(above, top), std::pair<const Camera&, const Frame&>(oblique, view)}) {
    copyPixels(picture, frame, painter.paint(camera, frame.width, frame.height));
    drawFrame(context.get(), frame);
    drawScans(context.get(), frame, camera, T_world_sensor);
  }
  apps::drawText(
      context.get(), top.left, top.top - 9, cut ? "From above, cut open under the ceiling" : "From above", 15);
  apps::drawText(context.get(), view.left, view.top - 9, "Oblique view", 15);
  const double baseline = height - 20;
  const double left = apps::drawLegendEntry(context.get(), kMargin, baseline, kScanColour, "scans, in order");
  apps::drawText(context.get(), left, baseline, "view from above:", 16);
  apps::drawScaleBar(context.get(), left + apps::textWidth(context.get(), "view from above:") + 12, baseline, scale);
  apps::writePng(path, picture);
}

void
drawPlan(const std::string& folder, const PreparedPlan& prepared, unsigned threads)
{
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw io::IoError(folder + ": cannot be created: " + error.message());
  const fs::path file = fs::path(folder) / (fs::path(prepared.scene.name).stem().string() + ".png");
  const auto first = static_cast<std::size_t>(prepared.plan.start);
  drawScene(file.string(),
            prepared.scene,
            surfacesAt(prepared.scene,
                       prepared.plan.movables,
                       prepared.plan.seed,
                       first,
                       {prepared.T_world_sensor.front().translation()}),
            prepared.T_world_sensor,
            threads);
}

} // namespace pcl_ssfr::simulation
