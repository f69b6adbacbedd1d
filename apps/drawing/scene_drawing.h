// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/drawing/drawing.h>
#include <apps/io/loaded_cloud.h>

#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// Colours that every kind of colour vision distinguishes (Okabe and Ito).
constexpr Colour kTargetColour{0.0, 0.447, 0.698}; // blue
constexpr Colour kSourceColour{0.835, 0.369, 0.0}; // vermilion

using PicturePoints = std::vector<Eigen::Vector3f>;

/// One scan in the frame of a picture: x right, y up in the top view, z up [m].
struct ScanLayer {
  PicturePoints points;
  PicturePoints thinned; ///< some points, evenly over the scan: they decide what is shown
  std::optional<Eigen::Vector3f> sensor;
  Colour colour{};
  std::string label;
};

struct Range {
  double low = 0;
  double high = 0;

  double
  size() const
  {
    return high - low;
  }
};

/// A view of the scene: two axes of the picture frame, to scale.
struct SceneView {
  Eigen::Index right = 0;
  Eigen::Index up = 1;
  Range horizontal;             ///< [m]
  Range vertical;               ///< [m]
  std::optional<Range> heights; ///< only points with z within are shown [m]
  std::string remark;           ///< what the caption says about it
  int left = 0;                 ///< pixel of the upper left corner
  int top = 0;
  double scale = 1; ///< pixels a metre

  int
  width() const;
  int
  height() const;
  /// Where a point of the picture frame lies [pixels].
  Eigen::Vector2d
  pixel(const Eigen::Vector3d& point) const;
  /// Whether a point of the picture frame is shown.
  bool
  shows(const Eigen::Vector3d& point) const;
};

/// The scene from above and, on the same scale, from the side.
struct SceneViews {
  SceneView top;
  SceneView side;
};

/// Room for the views of a picture [pixels].
struct ViewLimits {
  int width;
  int top_height;
  int side_height;
};

/** \brief The frame of pictures of a target: upright, walls along the edges. Takes the target's points without their
 * offset.
 * \param[in] up in the frame of the target, unit
 */
Eigen::Isometry3d
pictureFrame(const io::LoadedCloud& target, const Eigen::Vector3d& up);

/** \brief A scan moved into the frame of the picture.
 * \param[in] T_picture_cloud takes the points of the cloud without the offset
 * \param[in] sensor where the sensor is, in file coordinates [m]; nothing: where the cloud says
 */
ScanLayer
makeScanLayer(const io::LoadedCloud& cloud,
              const Eigen::Isometry3d& T_picture_cloud,
              const Colour& colour,
              std::string label,
              const std::optional<Eigen::Vector3d>& sensor = std::nullopt);

/** \brief Views that show all layers; what is far off, the floor and the ceiling of the first are cut away. */
SceneViews
makeSceneViews(const std::vector<const ScanLayer*>& layers, const ViewLimits& limits);

/// The view made to fit a smaller room, at the same place of the scene.
SceneView
fitted(SceneView view, int width, int height);

/// The name of a file without its folders, cut where it would not fit a legend.
std::string
shortFileName(const std::string& path);

/// Scans like inks on paper: where they meet it is darkest. \p strength makes them paler, (0, 1].
void
drawPoints(cairo_surface_t* surface,
           const SceneView& view,
           const std::vector<const ScanLayer*>& layers,
           double strength = 1);

void
drawSensor(cairo_t* context, const SceneView& view, const ScanLayer& layer);

void
drawFrame(cairo_t* context, const SceneView& view);

/// A picture of its own: both views with title, subtitle, legend and scale bar. \throw io::IoError
void
drawScans(const std::string& path,
          const std::string& title,
          const std::string& subtitle,
          SceneViews views,
          const std::vector<const ScanLayer*>& layers);

constexpr int kScansWidth = 1400;                              ///< of the picture that drawScans writes [pixels]
constexpr ViewLimits kScansLimits{kScansWidth - 56, 900, 500}; ///< of its views

} // namespace apps
} // namespace pcl_ssfr
