// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The only source that needs VTK; no_window.cpp takes its place where that is not there.

#include <apps/view/view_window.h>

#include <apps/io/io_error.h>
#include <apps/view/patch_drawing.h>
#include <apps/view/view_text.h>

#include <X11/Xlib.h>

#include <pcl/PolygonMesh.h>
#include <pcl/conversions.h>
#include <pcl/visualization/pcl_visualizer.h>

#include <vtkLODActor.h>
#include <vtkObject.h>
#include <vtkProperty.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <set>

namespace pcl_ssfr {
namespace apps {

namespace {

using ColourPoint = pcl::PointXYZRGB;
using ColourCloud = pcl::PointCloud<ColourPoint>;

constexpr int kWidth = 1400; ///< of the window [pixels]
constexpr int kHeight = 860;
constexpr double kSide = 0.74;              ///< where the column of sphere and text begins, share of the width
constexpr double kDistance = 1.6;           ///< of the camera, of the diagonal of the scene
constexpr double kSphereBottom = 0.42;      ///< share of the height
constexpr std::size_t kMostPoints = 150000; ///< drawn of a scan
constexpr double kSettleMilliseconds = 300; ///< before a screenshot is taken
constexpr const char* kHelp = "b   before / after\n"
                              "Right, Left   next, previous candidate\n"
                              "t   the truth, where it is known\n"
                              "m   matches (green), contradictions (red)\n"
                              "d   patches coloured by direction\n"
                              "y   only points\n"
                              "k   hide or show the points\n"
                              "n   hide or show the ceiling\n"
                              "z   from above        x   from the side\n"
                              "i   hide or show these keys\n"
                              "r   whole scene       q   quit\n"
                              "mouse: rotate; wheel: zoom; middle: move";

std::uint8_t
channel(double value)
{
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

ColourPoint
makePoint(const Eigen::Vector3f& place, const Colour& colour)
{
  ColourPoint point;
  point.getVector3fMap() = place;
  point.r = channel(colour.red);
  point.g = channel(colour.green);
  point.b = channel(colour.blue);
  return point;
}

/// Points of a scan up to a height [m].
ColourCloud::Ptr
makeCloud(const ScanLayer& layer, double highest)
{
  auto cloud = pcl::make_shared<ColourCloud>();
  const std::size_t step = layer.points.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < layer.points.size(); i += step)
    if (static_cast<double>(layer.points[i].z()) <= highest)
      cloud->push_back(makePoint(layer.points[i], layer.colour));
  return cloud;
}

pcl::PolygonMesh
makeMesh(const std::vector<PatchShape>& shapes)
{
  ColourCloud corners;
  pcl::PolygonMesh mesh;
  for (const PatchShape& shape : shapes) {
    pcl::Vertices quad;
    for (const Eigen::Vector3d& corner : shape.corners) {
      quad.vertices.push_back(static_cast<pcl::index_t>(corners.size()));
      corners.push_back(makePoint(corner.cast<float>(), shape.colour));
    }
    mesh.polygons.push_back(quad);
  }
  pcl::toPCLPointCloud2(corners, mesh.cloud);
  return mesh;
}

class Window {
public:
  Window(const ViewModel& model, WindowLayer layer)
      : model_(model), run_(model.run()), T_picture_target_(pictureFrame(run_.target, model.up())),
        viewer_("ssfr_view: " + shortFileName(run_.report.source) + " onto " + shortFileName(run_.report.target)),
        pose_(model.chosen()), layer_(layer)
  {
    viewer_.setSize(kWidth, kHeight);
    viewer_.createViewPort(0, 0, kSide, 1, scene_port_);
    viewer_.createViewPort(kSide, kSphereBottom, 1, 1, sphere_port_);
    viewer_.createViewPort(kSide, 0, 1, kSphereBottom, text_port_);
    viewer_.setBackgroundColor(1, 1, 1, scene_port_);
    viewer_.setBackgroundColor(0.97, 0.97, 0.97, sphere_port_);
    viewer_.setBackgroundColor(0.97, 0.97, 0.97, text_port_);
    viewer_.createViewPortCamera(sphere_port_);
    viewer_.createViewPortCamera(text_port_);
    viewer_.registerKeyboardCallback([this](const pcl::visualization::KeyboardEvent& event) { onKey(event); });
    target_ = makeScanLayer(run_.target, T_picture_target_, kTargetColour, "");
    const SceneView view = makeSceneViews({&target_}, kScansLimits).top;
    if (view.heights)
      ceiling_ = view.heights->high;
    show();
    lookFrom(Eigen::Vector3d(-0.35, -0.75, 0.9));
    viewer_.setCameraPosition(0, -5.2, 4.2, 0, 0, 0, 0, 0, 1, sphere_port_);
  }

  void
  runUntilClosed()
  {
    viewer_.spin();
  }

  void
  save(const std::string& path)
  {
    viewer_.spinOnce(static_cast<int>(kSettleMilliseconds), true);
    viewer_.saveScreenshot(path);
  }

private:
  void
  onKey(const pcl::visualization::KeyboardEvent& event)
  {
    if (!event.keyDown())
      return;
    const std::string& key = event.getKeySym();
    const std::size_t candidates = model_.poses().size() - (model_.truth() ? 1 : 0);
    if (key == "b") {
      before_ = !before_;
    }
    else if (key == "Right" || key == "Left") {
      before_ = false;
      pose_ = pose_ >= candidates ? 0 : (pose_ + (key == "Right" ? 1 : candidates - 1)) % candidates;
    }
    else if (key == "t" && model_.truth()) {
      before_ = false;
      pose_ = candidates;
    }
    else if (key == "m") {
      layer_ = WindowLayer::Matches;
    }
    else if (key == "d") {
      layer_ = WindowLayer::Patches;
    }
    else if (key == "y") {
      layer_ = WindowLayer::Points;
      points_ = true;
    }
    else if (key == "k") {
      points_ = !points_;
    }
    else if (key == "n") {
      cut_ = !cut_;
    }
    else if (key == "i") {
      help_ = !help_;
    }
    else if (key == "z") {
      lookFrom(Eigen::Vector3d(0, 0, 1));
      return;
    }
    else if (key == "x") {
      lookFrom(Eigen::Vector3d(0, -1, 0));
      return;
    }
    else {
      return;
    }
    show();
  }

  /// Look at the whole target and source from a direction.
  void
  lookFrom(const Eigen::Vector3d& direction)
  {
    Eigen::AlignedBox3f box;
    for (const ScanLayer* layer : {&source_, &target_})
      for (const Eigen::Vector3f& point : layer->thinned)
        box.extend(point);

    if (box.isEmpty())
      return;
    const Eigen::Vector3d centre = box.center().cast<double>();
    const Eigen::Vector3d from =
        centre + kDistance * static_cast<double>(box.diagonal().norm()) * direction.normalized();
    const bool from_above = direction.normalized().z() > 0.99;
    viewer_.setCameraPosition(from.x(),
                              from.y(),
                              from.z(),
                              centre.x(),
                              centre.y(),
                              centre.z(),
                              0,
                              from_above ? 1 : 0,
                              from_above ? 0 : 1,
                              scene_port_);
  }

  /// Up to where the scene is shown [m].
  double
  highest() const
  {
    return cut_ ? ceiling_ : std::numeric_limits<double>::infinity();
  }

  const ViewedPose&
  pose() const
  {
    return model_.poses()[pose_];
  }

  Eigen::Isometry3d
  shownPose() const
  {
    return before_ ? Eigen::Isometry3d::Identity() : pose().candidate.T_target_source;
  }

  void
  show()
  {
    const Eigen::Isometry3d T = T_picture_target_ * Eigen::Translation3d(-run_.target.offset) * shownPose() *
                                Eigen::Translation3d(run_.source.offset);
    source_ = makeScanLayer(run_.source, T, kSourceColour, "");
    for (const ScanLayer* layer : {&source_, &target_}) {
      const char* name = layer == &source_ ? "source" : "target";
      viewer_.removePointCloud(name);
      viewer_.addPointCloud<ColourPoint>(makeCloud(*layer, highest()), name, scene_port_);
    }
    for (const char* cloud : {"source", "target"})
      viewer_.setPointCloudRenderingProperties(
          pcl::visualization::PCL_VISUALIZER_OPACITY, points_ ? (layer_ == WindowLayer::Points ? 1 : 0.25) : 0, cloud);
    showSurfaces();
    showSphere();
    showText();
  }

  void
  showSurfaces()
  {
    for (const char* mesh : {"source patches", "target patches"})
      viewer_.removePolygonMesh(mesh);
    if (layer_ == WindowLayer::Points)
      return;
    const Eigen::Isometry3d target = T_picture_target_ * Eigen::Translation3d(model_.target().origin);
    for (const bool of_source : {true, false}) {
      std::vector<PatchShape> shapes = makePatchShapes(of_source ? model_.source() : model_.target(),
                                                       of_source ? target * model_.toPatches(shownPose()) : target);
      if (layer_ == WindowLayer::Matches) {
        ViewedPose shown = pose();
        shown.candidate.T_target_source = shownPose();
        const SurfaceFates fates = model_.fates(shown, of_source);
        for (std::size_t i = 0; i < shapes.size(); ++i)
          shapes[i].colour = fateColour(fates.each[i]);
      }
      else {
        for (PatchShape& shape : shapes)
          shape.colour = directionColour(shape.normal);
      }
      shapes.erase(std::remove_if(shapes.begin(),
                                  shapes.end(),
                                  [this](const PatchShape& shape) { return shape.centre.z() > highest(); }),
                   shapes.end());
      const char* name = of_source ? "source patches" : "target patches";
      if (shapes.empty())
        continue;
      viewer_.addPolygonMesh(makeMesh(shapes), name, scene_port_);
      const auto actor = viewer_.getCloudActorMap()->find(name);
      if (actor != viewer_.getCloudActorMap()->end())
        actor->second.actor->GetProperty()->LightingOff(); // colours mean something
    }
  }

  void
  showSphere()
  {
    const Eigen::Matrix3d up = T_picture_target_.linear();
    for (const bool of_source : {true, false}) {
      const SphereView sphere = model_.sphere(of_source);
      const Eigen::Matrix3d turn = of_source ? Eigen::Matrix3d(up * shownPose().linear()) : up;
      const Colour& colour = of_source ? kSourceColour : kTargetColour;
      const std::string name = of_source ? "source" : "target";
      auto cloud = pcl::make_shared<ColourCloud>();
      const Eigen::Index step = sphere.directions.size() / 20000 + 1;
      for (Eigen::Index i = 0; i < sphere.directions.size(); i += step)
        cloud->push_back(makePoint((turn * sphere.directions.directions.col(i)).cast<float>(), colour));
      viewer_.removePointCloud(name + " sphere");
      viewer_.addPointCloud<ColourPoint>(cloud, name + " sphere", sphere_port_);
      viewer_.setPointCloudRenderingProperties(pcl::visualization::PCL_VISUALIZER_POINT_SIZE, 2, name + " sphere");
      for (std::size_t i = 0; i < sphere.main_normals.size(); ++i) {
        const std::string id = name + " normal " + std::to_string(i);
        const Eigen::Vector3f tip = (turn * sphere.main_normals[i].direction).cast<float>();
        viewer_.removeShape(id);
        viewer_.removeText3D(id + " number", sphere_port_);
        // Target outside, source inside, so that both stay visible where they meet.
        const float length = of_source ? 1.0f : 1.12f;
        viewer_.addLine(ColourPoint(makePoint(Eigen::Vector3f(0.8f * tip), colour)),
                        ColourPoint(makePoint(Eigen::Vector3f(length * tip), colour)),
                        colour.red,
                        colour.green,
                        colour.blue,
                        id,
                        sphere_port_);
        viewer_.setShapeRenderingProperties(pcl::visualization::PCL_VISUALIZER_LINE_WIDTH, 5, id);
        viewer_.addText3D(std::to_string(i + 1),
                          makePoint(Eigen::Vector3f((length + (of_source ? 0.24f : 0.1f)) * tip), colour),
                          0.07,
                          colour.red,
                          colour.green,
                          colour.blue,
                          id + " number",
                          sphere_port_);
      }
    }
  }

  void
  showText()
  {
    const double scene_top = kHeight - 30;
    const std::string name = before_ ? "before: both scans in their own coordinates" : pose().name;
    setText("title", name, 14, static_cast<int>(scene_top), 18, {0.1, 0.1, 0.1}, scene_port_);
    std::string figures;
    if (!before_) {
      const Candidate& c = pose().candidate;
      figures = formatted(
          "matched %.1f %%, contradicted %.2f %%, score %.3f", 100 * c.overlap, 100 * c.contradiction, c.score);
      if (pose().error && !pose().is_truth)
        figures += formatted("; %.2f deg, %.3f m from the truth: %s",
                             pose().error->rotation_deg,
                             pose().error->translation_m,
                             pose().right ? "right" : "wrong");
    }
    setText("figures",
            figures.empty() ? " " : figures,
            14,
            static_cast<int>(scene_top) - 24,
            14,
            {0.1, 0.1, 0.1},
            scene_port_);
    setText("target", "target", 14, 14, 15, kTargetColour, scene_port_);
    setText("source", "source", 84, 14, 15, kSourceColour, scene_port_);
    const int top = static_cast<int>(kSphereBottom * kHeight);
    setText("head", headlineOf(model_), 10, top - 28, 15, {0.1, 0.1, 0.1}, text_port_);
    setText("help", help_ ? kHelp : "i   keys", 10, help_ ? 14 : top - 60, 13, {0.25, 0.25, 0.25}, text_port_);
    setText("sphere", "directions that surfaces face, and main normals", 10, 10, 12, {0.25, 0.25, 0.25}, sphere_port_);
  }

  void
  setText(const std::string& id, const std::string& text, int x, int y, int size, const Colour& colour, int port)
  {
    const std::string name = "text " + id;
    if (texts_.insert(name).second)
      viewer_.addText(text, x, y, size, colour.red, colour.green, colour.blue, name, port);
    else
      viewer_.updateText(text, x, y, size, colour.red, colour.green, colour.blue, name);
  }

  const ViewModel& model_;
  const ViewRun& run_;
  Eigen::Isometry3d T_picture_target_; ///< takes the points of the target without their offset
  pcl::visualization::PCLVisualizer viewer_;
  int scene_port_ = 0;
  int sphere_port_ = 0;
  int text_port_ = 0;
  ScanLayer target_;
  ScanLayer source_;
  double ceiling_ = std::numeric_limits<double>::infinity(); ///< [m]
  std::set<std::string> texts_;
  std::size_t pose_;
  bool before_ = false;
  bool points_ = true;
  bool cut_ = true; ///< the ceiling is hidden
  bool help_ = true;
  WindowLayer layer_;
};

} // namespace

bool
hasWindow()
{
  return true;
}

bool
canOpenDisplay()
{
  Display* display = XOpenDisplay(nullptr);
  if (display)
    XCloseDisplay(display);
  return display != nullptr;
}

void
showWindow(const ViewModel& model, WindowLayer layer, const std::string& screenshot)
{
  vtkObject::GlobalWarningDisplayOff(); // this program reports errors itself
  Window window(model, layer);
  if (screenshot.empty()) {
    window.runUntilClosed();
    return;
  }
  std::error_code error;
  std::filesystem::remove(screenshot, error);
  window.save(screenshot);
  if (!std::filesystem::is_regular_file(screenshot, error))
    throw io::IoError(screenshot + ": cannot be written");
}

} // namespace apps
} // namespace pcl_ssfr
