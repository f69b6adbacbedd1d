// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_pictures.h>

#include "common/angles.h"

#include <apps/common/degrees.h>
#include <apps/drawing/chart.h>
#include <apps/view/patch_drawing.h>
#include <apps/view/sphere_drawing.h>
#include <apps/view/view_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

namespace pcl_ssfr {
namespace apps {

namespace {

// Layout [pixels].
constexpr int kWidth = 1400;
constexpr int kMargin = 28;
constexpr int kHeader = 92;

constexpr Colour kTruthColour{0.35, 0.0, 0.55}; // purple: neither scan, neither match nor contradiction
constexpr Colour kPoseColour = kInk;
constexpr Colour kPeakColour{0.0, 0.45, 0.35};

/// A white picture with its headings.
class Sheet {
public:
  Sheet(int height, const std::string& title, const std::string& subtitle)
      : height_(height), surface_(makePicture(kWidth, height)), context_(makeContext(surface_))
  {
    drawText(context(), kMargin, 38, title, 26, true);
    drawText(context(), kMargin, 66, subtitle, 16);
  }

  cairo_t*
  context() const
  {
    return context_.get();
  }
  cairo_surface_t*
  surface() const
  {
    return surface_.get();
  }
  int
  height() const
  {
    return height_;
  }
  void
  write(const std::string& path) const
  {
    writePng(path, surface_);
  }

private:
  int height_;
  SurfacePtr surface_;
  ContextPtr context_;
};

/// Draws all pictures of a model into a folder.
class PictureMaker {
public:
  PictureMaker(std::string folder, const ViewModel& model)
      : folder_(std::move(folder)), model_(model), run_(model.run()),
        T_picture_target_(pictureFrame(run_.target, model.up())), sensors_(run_.report.run.result),
        target_(makeScanLayer(run_.target,
                              T_picture_target_,
                              kTargetColour,
                              "target " + shortFileName(run_.report.target),
                              sensors_.target))
  {}

  std::vector<ViewPicture>
  drawAll()
  {
    drawBeforeAndAfter();
    drawMatches(model_.chosenPose(), "matches.png");
    if (const ViewedPose* truth = model_.truth())
      drawMatches(*truth, "matches_truth.png");
    drawCandidates();
    drawAxes(model_.chosenPose(), "axes.png");
    if (const ViewedPose* truth = model_.truth())
      drawAxes(*truth, "axes_truth.png");
    drawSpheres(model_.chosenPose());
    drawPatchPicture(true);
    drawPatchPicture(false);
    drawStages();
    return pictures_;
  }

private:
  std::string
  path(const std::string& file) const
  {
    return (std::filesystem::path(folder_) / file).string();
  }
  void
  add(const std::string& file, const std::string& title, const std::string& caption)
  {
    pictures_.push_back({file, title, caption});
  }

  /// The source in the frame of the picture under a pose between files.
  ScanLayer
  sourceLayer(const Eigen::Isometry3d& T_files, const std::string& label) const
  {
    const Eigen::Isometry3d T = T_picture_target_ * Eigen::Translation3d(-run_.target.offset) * T_files *
                                Eigen::Translation3d(run_.source.offset);
    return makeScanLayer(run_.source, T, kSourceColour, label, sensors_.source);
  }
  Eigen::Isometry3d
  picturePatches(const ViewedPose& pose, bool of_source) const
  {
    const Eigen::Isometry3d target = T_picture_target_ * Eigen::Translation3d(model_.target().origin);
    return of_source ? target * model_.toPatches(pose.candidate.T_target_source) : target;
  }

  void
  drawBeforeAndAfter()
  {
    const std::string name = "source " + shortFileName(run_.report.source);
    const ScanLayer before = sourceLayer(Eigen::Isometry3d::Identity(), name);
    drawScans(path("before.png"),
              "Before: both scans in their own coordinates",
              "What the method got. Nothing is known about how they lie to each other.",
              makeSceneViews({&target_, &before}, kScansLimits),
              {&target_, &before});
    add("before.png", "Before", "Both scans in their own coordinates, from above and from the side.");
    const ViewedPose& pose = model_.chosenPose();
    const ScanLayer after = sourceLayer(pose.candidate.T_target_source, name);
    const bool accepted = model_.result().accepted() && model_.chosen() == 0;
    drawScans(path("after.png"),
              (accepted ? "After: " : "Not accepted: ") + pose.name,
              describePose(pose),
              makeSceneViews({&target_, &after}, kScansLimits),
              {&target_, &after});
    add("after.png",
        "After: " + pose.name,
        "The source moved by the pose. Where it is right, walls lie on walls and become dark.");
    if (const ViewedPose* truth = model_.truth()) {
      const ScanLayer layer = sourceLayer(truth->candidate.T_target_source, name);
      drawScans(path("truth.png"),
                "The truth",
                describePose(*truth),
                makeSceneViews({&target_, &layer}, kScansLimits),
                {&target_, &layer});
      add("truth.png", "The truth", "The source moved by the true pose, for comparison.");
    }
  }

  /// The patches of both scans by their fates: side by side, or below each other when the scene is long.
  void
  drawMatches(const ViewedPose& pose, const std::string& file)
  {
    constexpr int kColumn = (kWidth - 3 * kMargin) / 2;
    constexpr int kLegend = 118;
    constexpr int kGap = 34;
    constexpr double kLong = 2.2; // length over depth
    const ScanLayer source = sourceLayer(pose.candidate.T_target_source, "");
    SceneViews views = makeSceneViews({&target_, &source}, {kColumn, 620, 300});
    const bool stacked = views.top.horizontal.size() > kLong * views.top.vertical.size();
    if (stacked)
      views = makeSceneViews({&target_, &source}, {kWidth - 2 * kMargin, 480, 260});
    const int block = views.top.height() + kGap + views.side.height();
    const Sheet sheet(kHeader + kLegend + (stacked ? 2 : 1) * block + (stacked ? kGap + 6 : 0) + 60,
                      "Matches and contradictions: " + pose.name,
                      describePose(pose));
    cairo_t* context = sheet.context();
    const std::array<SurfaceFates, 2> fates{{model_.fates(pose, true), model_.fates(pose, false)}};
    drawFateLegend(context, fates);
    for (const bool of_source : {true, false}) {
      const SurfaceFates& fate = fates[of_source ? 0 : 1];
      std::vector<PatchShape> shapes =
          makePatchShapes(of_source ? model_.source() : model_.target(), picturePatches(pose, of_source));
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        shapes[i].colour = fateColour(fate.each[i]);
        shapes[i].rank = fate.each[i] == SurfaceFate::Contradicted ? 1 : fate.each[i] == SurfaceFate::Unseen ? -1 : 0;
      }
      SceneViews shown = views;
      shown.top.left = shown.side.left = of_source || stacked ? kMargin : 2 * kMargin + kColumn;
      shown.top.top = kHeader + kLegend + (stacked && !of_source ? block + kGap + 6 : 0);
      shown.side.top = shown.top.top + shown.top.height() + kGap;
      const ScanLayer& other = of_source ? target_ : source;
      for (const SceneView* view : {&shown.top, &shown.side}) {
        drawPoints(sheet.surface(), *view, {&other}, 0.28);
        drawPatches(context, *view, shapes);
        drawFrame(context, *view);
        drawSensor(context, *view, target_);
        drawSensor(context, *view, source);
      }
      drawText(context,
               shown.top.left,
               shown.top.top - 9,
               std::string("Surface of the ") + (of_source ? "source" : "target") + " laid into the " +
                   (of_source ? "target" : "source") + " (pale), from above" + shown.top.remark,
               14);
      drawText(context, shown.side.left, shown.side.top - 9, "From the side", 14);
    }
    drawLegend(sheet, views.top.scale, false);
    sheet.write(path(file));
    add(file,
        "Matches and contradictions: " + pose.name,
        "Every planar patch of one scan, laid into the other. Green supports the pose. Red speaks against it: it hangs "
        "where the other sensor looked through. A right pose has hardly any red.");
  }

  static void
  drawFateLegend(cairo_t* context, const std::array<SurfaceFates, 2>& fates)
  {
    double y = kHeader + 12;
    for (const SurfaceFate fate :
         {SurfaceFate::Matched, SurfaceFate::Contradicted, SurfaceFate::Unmatched, SurfaceFate::Unseen}) {
      const auto k = static_cast<std::size_t>(fate);
      drawLegendEntry(context, kMargin, y, fateColour(fate), fateName(fate));
      for (std::size_t s = 0; s < 2; ++s)
        drawAlignedText(context,
                        s == 0 ? 720 : 1010,
                        y,
                        formatted("%.1f %% of the %s (%.1f m\u00b2)",
                                  100 * fates[s].surface[k] / std::max(fates[s].total(), 1e-9),
                                  s == 0 ? "source" : "target",
                                  fates[s].surface[k]),
                        15,
                        0);
      y += 23;
    }
  }

  void
  drawLegend(const Sheet& sheet, double scale, bool with_scans) const
  {
    cairo_t* context = sheet.context();
    double left = kMargin;
    const double baseline = sheet.height() - 22;
    if (with_scans) {
      left = drawLegendEntry(context, left, baseline, kTargetColour, target_.label);
      drawLegendEntry(context, left, baseline, kSourceColour, "source " + shortFileName(run_.report.source));
    }
    else {
      drawDot(context, left + 8, baseline - 5, 6, kTargetColour);
      drawText(context, left + 22, baseline, "sensor of the target", 15);
      drawDot(context, left + 208, baseline - 5, 6, kSourceColour);
      drawText(context, left + 222, baseline, "sensor of the source", 15);
    }
    drawScaleBar(context, kWidth - 420, baseline, scale);
  }

  // -------------------------------------------------------------------------------------------------------------------

  void
  drawCandidates()
  {
    constexpr std::size_t kRows = 12;
    constexpr std::size_t kViews = 7;
    constexpr int kPerRow = 4;
    constexpr int kGap = 16;
    constexpr int kCell = (kWidth - 2 * kMargin - (kPerRow - 1) * kGap) / kPerRow;
    constexpr int kLine = 25;
    const std::vector<ViewedPose>& poses = model_.poses();
    std::vector<const ViewedPose*> shown;
    for (const ViewedPose& pose : poses)
      if (!pose.is_truth && shown.size() < kRows)
        shown.push_back(&pose);
    if (std::find(shown.begin(), shown.end(), &model_.chosenPose()) == shown.end())
      shown.push_back(&model_.chosenPose());
    if (model_.truth())
      shown.push_back(model_.truth());
    std::vector<const ViewedPose*> viewed(shown.begin(),
                                          shown.begin() + static_cast<std::ptrdiff_t>(std::min(kViews, shown.size())));
    if (model_.truth() && viewed.back() != model_.truth())
      viewed.push_back(model_.truth());

    // One window on the scene for all, so that they can be compared.
    const ViewedPose& guide = model_.truth() ? *model_.truth() : poses.front();
    const ScanLayer guide_layer = sourceLayer(guide.candidate.T_target_source, "");
    const SceneView view = fitted(makeSceneViews({&target_, &guide_layer}, kScansLimits).top, kCell, 300);
    const int rows = (static_cast<int>(viewed.size()) + kPerRow - 1) / kPerRow;
    const int table = kHeader + 26 + kLine * (static_cast<int>(shown.size()) + 1);
    const Sheet sheet(
        table + 20 + rows * (view.height() + 40) + 50,
        "Ranked candidates",
        formatted("%zu distinct poses were considered in the end, in this order; surface as a share of all of it",
                  model_.result().candidates.size()));
    cairo_t* context = sheet.context();
    drawTable(context, shown, kHeader + 26, kLine);
    int i = 0;
    for (const ViewedPose* pose : viewed) {
      SceneView small = view;
      small.left = kMargin + (i % kPerRow) * (kCell + kGap) + (kCell - small.width()) / 2;
      small.top = table + 44 + (i / kPerRow) * (view.height() + 40);
      const ScanLayer layer = sourceLayer(pose->candidate.T_target_source, "");
      drawPoints(sheet.surface(), small, {&target_, &layer});
      drawFrame(context, small);
      drawSensor(context, small, target_);
      drawSensor(context, small, layer);
      drawText(context,
               small.left,
               small.top - 8,
               (pose->is_truth ? "truth" : "candidate " + pose->short_name) +
                   formatted(": score %.3f", pose->candidate.score) +
                   (pose->error && !pose->is_truth ? (pose->right ? ", right" : ", wrong") : ""),
               13.5,
               pose == &model_.chosenPose());
      ++i;
    }
    drawLegend(sheet, view.scale, true);
    sheet.write(path("candidates.png"));
    add("candidates.png",
        "Ranked candidates",
        "The best distinct poses with the evidence for each, and each of them from above. Rivals that look alike mean "
        "that the scene repeats itself.");
  }

  void
  drawTable(cairo_t* context, const std::vector<const ViewedPose*>& shown, int top, int line) const
  {
    const std::vector<std::pair<std::string, double>> heads{{"pose", 40},
                                                            {"score", 260},
                                                            {"matched", 370},
                                                            {"contradicted", 510},
                                                            {"in view, unlike", 650},
                                                            {"patches met", 780},
                                                            {"from candidate 1", 970},
                                                            {model_.truth() ? "from the truth" : "", 1180}};
    for (const auto& [text, x] : heads)
      drawAlignedText(context, x, top, text, 14, x > 40 ? 1 : 0, kInk, true);
    double y = top + line;
    const ViewedPose& first = model_.poses().front();
    for (const ViewedPose* pose : shown) {
      if (pose == &model_.chosenPose()) {
        cairo_rectangle(context, kMargin, y - line + 8, kWidth - 2 * kMargin, line);
        cairo_set_source_rgb(context, 0.93, 0.95, 0.99);
        cairo_fill(context);
      }
      const Candidate& c = pose->candidate;
      const PoseError apart = poseError(c.T_target_source, first.candidate.T_target_source, run_.reference);
      const auto cell = [&](double x, const std::string& text, const Colour& colour = kInk) {
        drawAlignedText(context, x, y, text, 14, 1, colour);
      };
      drawAlignedText(context,
                      40,
                      y,
                      pose->is_truth ? "truth, unrefined" : pose->short_name + (c.from_guess ? " (guess)" : ""),
                      14,
                      0);
      cell(260, formatted("%.3f", c.score));
      cell(370, formatted("%.1f %%", 100 * c.overlap));
      cell(510,
           formatted("%.2f %%", 100 * c.contradiction),
           c.contradiction > 0.01 ? fateColour(SurfaceFate::Contradicted) : kInk);
      cell(650, formatted("%.1f %%", 100 * c.evidence.unmatched));
      cell(780, formatted("%.0f %%", 100 * c.evidence.patches_matched));
      if (pose != &first)
        cell(970, formatted("%.2f deg, %.2f m", apart.rotation_deg, apart.translation_m));
      if (pose->error && !pose->is_truth) {
        cell(1180, formatted("%.2f deg, %.3f m", pose->error->rotation_deg, pose->error->translation_m));
        drawAlignedText(context,
                        1200,
                        y,
                        pose->right ? "right" : "wrong",
                        14,
                        0,
                        fateColour(pose->right ? SurfaceFate::Matched : SurfaceFate::Contradicted),
                        true);
      }
      y += line;
    }
  }

  // -------------------------------------------------------------------------------------------------------------------

  void
  drawAxes(const ViewedPose& pose, const std::string& file)
  {
    constexpr int kRow = 292;
    constexpr double kChartWidth = 262;
    constexpr double kChartHeight = 168;
    constexpr double kStep = 342;
    const std::array<AxisView, 3> axes = model_.axes(pose, true);
    const Sheet sheet(kHeader + 3 * kRow + 64,
                      "Translations along three axes: " + pose.name,
                      "The rotation of this pose is given. Along each axis, surfaces that face it are counted by where "
                      "they lie; the translation that lays them on each other is looked for.");
    cairo_t* context = sheet.context();
    for (std::size_t k = 0; k < 3; ++k) {
      const AxisView& axis = axes[k];
      const double top = kHeader + static_cast<double>(k) * kRow;
      const Eigen::Vector3d shown = T_picture_target_.linear() * axis.axis;
      drawText(context,
               kMargin,
               top + 14,
               formatted("Axis %zu: (%.2f, %.2f, %.2f) of the target, %s. ",
                         k + 1,
                         axis.axis.x(),
                         axis.axis.y(),
                         axis.axis.z(),
                         std::abs(shown.z()) > 0.9   ? "up and down"
                         : std::abs(shown.x()) > 0.9 ? "to the right in the view from above"
                         : std::abs(shown.y()) > 0.9 ? "upwards in the view from above"
                                                     : "oblique") +
                   formatted("The pose moves by %.2f m", axis.shift) +
                   (axis.true_shift && !pose.is_truth ? formatted(", the truth by %.2f m", *axis.true_shift) : ""),
               15,
               true);
      const auto chartAt = [&](int column) {
        Chart chart;
        chart.left = kMargin + 46 + column * kStep;
        chart.top = top + 48;
        chart.width = kChartWidth;
        chart.height = kChartHeight;
        return chart;
      };
      drawHistograms(context, chartAt(0), axis, 0, "Histograms as they are");
      drawHistograms(context, chartAt(1), axis, axis.shift, "Source moved by the translation");
      drawCorrelation(context, chartAt(2), axis, pose);
      drawScores(context, chartAt(3), axis, pose);
    }
    const double baseline = sheet.height() - 22;
    double left = drawLegendEntry(context, kMargin, baseline, kTargetColour, "target");
    left = drawLegendEntry(context, left, baseline, kSourceColour, "source");
    left = drawLegendEntry(context, left, baseline, kPeakColour, "peaks that are tried");
    left = drawLegendEntry(context, left, baseline, kPoseColour, "this pose");
    if (model_.truth() && !pose.is_truth)
      left = drawLegendEntry(context, left, baseline, kTruthColour, "truth (dashed)");
    left = drawLegendEntry(context, left, baseline, fateColour(SurfaceFate::Matched), "matched");
    drawLegendEntry(context, left, baseline, fateColour(SurfaceFate::Contradicted), "contradicted");
    sheet.write(path(file));
    add(file,
        "Histograms and correlations: " + pose.name,
        "One row an axis. Surfaces that face along the axis are counted upwards, those that face against it downwards. "
        "Third chart: the correlation of the two histograms over all translations, with the numbered peaks that the "
        "search "
        "tries. Fourth: what becomes of the surface when the pose is moved along this axis alone; a right pose has a "
        "clear peak of matches at 0.");
  }

  static void
  widen(Chart& chart, const AxisHistogram& histogram, double shift)
  {
    if (histogram.counts.size() == 0)
      return;
    const double low = histogram.origin + shift;
    const double high = low + static_cast<double>(histogram.counts.size()) * histogram.bin_width;
    const bool first = !(chart.x_high > chart.x_low);
    chart.x_low = first ? low : std::min(chart.x_low, low);
    chart.x_high = first ? high : std::max(chart.x_high, high);
    chart.y_high = std::max(chart.y_high, histogram.counts.maxCoeff());
  }

  static void
  noData(cairo_t* context, Chart chart, const std::string& title, const char* text)
  {
    chart.x_low = chart.y_low = 0;
    chart.x_high = chart.y_high = 1;
    drawChartFrame(context, chart, title, "", "");
    cairo_rectangle(context, chart.left + 1, chart.top + 1, chart.width - 2, chart.height - 2);
    cairo_set_source_rgb(context, 0.96, 0.96, 0.96);
    cairo_fill(context);
    drawAlignedText(context, chart.left + chart.width / 2, chart.top + chart.height / 2, text, 14, 0.5);
  }

  void
  drawHistograms(cairo_t* context, Chart chart, const AxisView& axis, double shift, const std::string& title) const
  {
    const AxisCorrelation& along = axis.correlation;
    chart.x_low = chart.x_high = chart.y_low = chart.y_high = 0;
    for (const AxisHistogram& histogram : along.target)
      widen(chart, histogram, 0);
    for (const AxisHistogram& histogram : along.source)
      widen(chart, histogram, shift);
    if (!(chart.x_high > chart.x_low) || !(chart.y_high > 0))
      return noData(context, chart, title, "no surface faces this axis");
    chart.y_high *= 1.06;
    const double margin = 0.04 * (chart.x_high - chart.x_low);
    chart.x_low -= margin;
    chart.x_high += margin;
    const bool both = along.facings.size() > 1;
    chart.y_low = both ? -chart.y_high : 0;
    drawChartFrame(context,
                   chart,
                   title,
                   "place along the axis [m]",
                   model_.isPaperProfile() ? "share of the points" : "surface, root [m]");
    for (std::size_t f = 0; f < along.facings.size(); ++f) {
      const double sign = along.facings[f] == HistogramOptions::Facing::Backward ? -1 : 1;
      const AxisHistogram& t = along.target[f];
      const AxisHistogram& s = along.source[f];
      drawChartSteps(context, chart, t.origin, t.bin_width, t.counts, kTargetColour, 0.4, sign);
      drawChartSteps(context, chart, s.origin + shift, s.bin_width, s.counts, kSourceColour, 0.25, sign);
    }
    if (both) {
      const double middle = chart.left + chart.width / 2;
      drawAlignedText(context, middle, chart.top + 14, "faces along", 11.5, 0.5);
      drawAlignedText(context, middle, chart.top + chart.height - 6, "faces against", 11.5, 0.5);
    }
  }

  void
  drawCorrelation(cairo_t* context, Chart chart, const AxisView& axis, const ViewedPose& pose) const
  {
    const Correlation& sum = axis.correlation.sum;
    const std::string title =
        axis.every_shift ? "Correlation (every translation is tried)" : "Correlation and its peaks";
    if (sum.values.size() < 2)
      return noData(context, chart, title, "nothing to correlate");
    chart.x_low = sum.shift(0);
    chart.x_high = sum.shift(sum.values.size() - 1);
    chart.y_low = std::min(0.0, sum.values.minCoeff());
    chart.y_high = 1.14 * std::max(sum.values.maxCoeff(), 1e-9);
    drawChartFrame(context, chart, title, "translation of the source [m]", "");
    drawMarks(context, chart, axis, pose, 0);
    std::vector<double> x;
    std::vector<double> y;
    for (Eigen::Index i = 0; i < sum.values.size(); ++i) {
      x.push_back(sum.shift(i));
      y.push_back(sum.values[i]);
    }
    drawChartLine(context, chart, x, y, kInk, 1.1);
    for (std::size_t p = axis.peaks.size(); p-- > 0;) {
      const Eigen::Index at = static_cast<Eigen::Index>(
          std::lround((axis.peaks[p].shift - sum.first_shift) / std::max(sum.bin_width, 1e-9)));
      const double value = sum.values[std::clamp<Eigen::Index>(at, 0, sum.values.size() - 1)];
      drawNumberedMark(context, chart.x(axis.peaks[p].shift), chart.y(value) - 9, static_cast<int>(p) + 1, kPeakColour);
    }
  }

  void
  drawMarks(cairo_t* context, const Chart& chart, const AxisView& axis, const ViewedPose& pose, double zero) const
  {
    drawChartMark(context, chart, axis.shift - zero, kPoseColour, 2, false);
    if (axis.true_shift && !pose.is_truth)
      drawChartMark(context, chart, *axis.true_shift - zero, kTruthColour, 2, true);
  }

  void
  drawScores(cairo_t* context, Chart chart, const AxisView& axis, const ViewedPose& pose) const
  {
    std::vector<double> x;
    std::vector<double> matched;
    std::vector<double> contradicted;
    double highest = 0.05;
    for (const ShiftScore& score : axis.scores) {
      x.push_back(score.offset);
      matched.push_back(score.matched);
      contradicted.push_back(score.contradicted);
      highest = std::max({highest, score.matched, score.contradicted});
    }
    chart.x_low = x.front();
    chart.x_high = x.back();
    chart.y_low = 0;
    chart.y_high = 1.08 * highest;
    drawChartFrame(context, chart, "When moved from the pose", "further translation [m]", "share of the surface", true);
    drawMarks(context, chart, axis, pose, axis.shift);
    drawChartLine(context, chart, x, contradicted, fateColour(SurfaceFate::Contradicted));
    drawChartLine(context, chart, x, matched, fateColour(SurfaceFate::Matched));
  }

  // -------------------------------------------------------------------------------------------------------------------

  void
  drawSpheres(const ViewedPose& pose)
  {
    constexpr int kRow = 410;
    constexpr double kRadius = 168;
    const std::array<SphereView, 2> spheres{{model_.sphere(false), model_.sphere(true)}};
    const Sheet sheet(kHeader + 2 * kRow + 76,
                      "Gaussian spheres: which way surfaces face",
                      "Each point is a direction; the more surface faces it, the darker. Seen from above: walls are on "
                      "the rim. The source is rotated by " +
                          pose.name + ".");
    cairo_t* context = sheet.context();
    const Eigen::Matrix3d up = T_picture_target_.linear();
    const std::array<Eigen::Matrix3d, 2> turns{{up, up * pose.candidate.T_target_source.linear()}};
    for (std::size_t s = 0; s < 2; ++s) {
      const double top = kHeader + static_cast<double>(s) * kRow;
      const Colour colour = s == 0 ? kTargetColour : kSourceColour;
      const Colour other = s == 0 ? kSourceColour : kTargetColour;
      drawText(context, kMargin, top + 16, s == 0 ? "Target" : "Source, rotated by the pose", 17, true);
      for (const bool upper : {true, false}) {
        const double x = kMargin + kRadius + (upper ? 0 : 2 * kRadius + 34);
        const double y = top + 44 + kRadius;
        drawSphere(sheet.surface(), context, spheres[s], turns[s], upper, x, y, kRadius, model_.threads());
        for (std::size_t i = spheres[1 - s].main_normals.size(); i-- > 0;)
          drawSphereMark(context,
                         turns[1 - s] * spheres[1 - s].main_normals[i].direction,
                         upper,
                         x,
                         y,
                         kRadius,
                         static_cast<int>(i) + 1,
                         other,
                         true);
        for (std::size_t i = spheres[s].main_normals.size(); i-- > 0;)
          drawSphereMark(context,
                         turns[s] * spheres[s].main_normals[i].direction,
                         upper,
                         x,
                         y,
                         kRadius,
                         static_cast<int>(i) + 1,
                         colour,
                         false);
        drawAlignedText(context,
                        x,
                        y + kRadius + 20,
                        upper ? "facing up (floor in the middle)" : "facing down (ceiling in the middle)",
                        13,
                        0.5);
      }
      drawNormalTable(context, spheres[s], turns[s], spheres[1 - s], turns[1 - s], s == 0, 778, top + 16);
    }
    const double baseline = sheet.height() - 22;
    drawDot(context, kMargin + 8, baseline - 5, 5, kTargetColour);
    drawDot(context, kMargin + 28, baseline - 5, 5, kSourceColour);
    drawText(context, kMargin + 44, baseline, "main normals", 15);
    for (const bool of_source : {false, true}) {
      cairo_new_path(context);
      cairo_arc(context, kMargin + (of_source ? 202 : 178), baseline - 5, 9, 0, 2 * kPi);
      setColour(context, of_source ? kSourceColour : kTargetColour);
      cairo_set_line_width(context, 2);
      cairo_stroke(context);
    }
    drawText(context,
             kMargin + 220,
             baseline,
             "those of the other scan: in a right pose they ring each other; thin circles: densest regions",
             15);
    drawDensityKey(context, kWidth - 380, kHeader + 2 * kRow + 2);
    sheet.write(path("spheres.png"));
    add("spheres.png",
        "Gaussian spheres",
        "Density of the directions that surfaces face, the densest regions (thin circles) and the main normals, "
        "numbered by their support. The rotation comes from pairs of main normals that enclose the same angle.");
  }

  static void
  drawNormalTable(cairo_t* context,
                  const SphereView& own,
                  const Eigen::Matrix3d& turn,
                  const SphereView& other,
                  const Eigen::Matrix3d& other_turn,
                  bool is_target,
                  double x,
                  double y)
  {
    double sum = 0;
    for (const MainNormal& normal : own.main_normals)
      sum += normal.support;
    const std::array<double, 4> columns{{x + 20, x + 110, x + 350, x + 580}};
    drawAlignedText(context, columns[0], y, "no.", 14, 1, kInk, true);
    drawAlignedText(context, columns[1], y, "weight", 14, 1, kInk, true);
    drawAlignedText(context, columns[2], y, "direction in its own frame", 14, 1, kInk, true);
    drawAlignedText(
        context, columns[3], y, is_target ? "nearest of the source" : "nearest of the target", 14, 1, kInk, true);
    for (std::size_t i = 0; i < own.main_normals.size(); ++i) {
      y += 23;
      const MainNormal& normal = own.main_normals[i];
      drawAlignedText(context, columns[0], y, std::to_string(i + 1), 14, 1);
      drawAlignedText(context, columns[1], y, formatted("%.1f %%", 100 * normal.support / std::max(sum, 1e-12)), 14, 1);
      drawAlignedText(context,
                      columns[2],
                      y,
                      formatted("(%.2f, %.2f, %.2f)", normal.direction.x(), normal.direction.y(), normal.direction.z()),
                      14,
                      1);
      double best = -1;
      std::size_t nearest = 0;
      for (std::size_t j = 0; j < other.main_normals.size(); ++j) {
        const double c = (turn * normal.direction).dot(other_turn * other.main_normals[j].direction);
        if (c > best) {
          best = c;
          nearest = j;
        }
      }
      const double degrees = std::acos(std::clamp(best, -1.0, 1.0)) * kDegreesPerRadian;
      constexpr double kNear = 8;
      drawAlignedText(context,
                      columns[3],
                      y,
                      other.main_normals.empty() ? "none" : formatted("%zu, %.1f deg away", nearest + 1, degrees),
                      14,
                      1,
                      degrees < kNear ? fateColour(SurfaceFate::Matched) : kInk);
    }
    if (own.main_normals.empty())
      drawText(context, x, y + 30, "no main normal was found", 14);
  }

  // -------------------------------------------------------------------------------------------------------------------

  void
  drawPatchPicture(bool of_source)
  {
    const ViewedPose& pose = model_.chosenPose();
    const PatchScan& scan = of_source ? model_.source() : model_.target();
    const Eigen::Isometry3d T = picturePatches(pose, of_source);
    ScanLayer layer = of_source ? sourceLayer(pose.candidate.T_target_source, "") : target_;
    SceneViews views = makeSceneViews({&layer}, {kScansLimits.width, 640, 320});
    const std::string which = of_source ? "source" : "target";
    const Sheet sheet(kHeader + 40 + views.top.height() + 34 + views.side.height() + 100,
                      "Planar patches of the " + which,
                      formatted("%zu patches, %.0f m\u00b2; %zu main normals; patches up to %.0f mm thick%s",
                                static_cast<std::size_t>(scan.patches.size()),
                                scan.patches.samples.weights.sum(),
                                scan.main_normals.size(),
                                1000 * scan.thickness,
                                scan.viewpoint_used ? "" : "; the given place of its sensor is not accepted"));
    cairo_t* context = sheet.context();
    std::vector<PatchShape> shapes = makePatchShapes(scan, T);
    for (PatchShape& shape : shapes)
      shape.colour = directionColour(shape.normal);
    views.top.left = views.side.left = (kWidth - views.top.width()) / 2;
    views.top.top = kHeader + 40;
    views.side.top = views.top.top + views.top.height() + 34;
    for (const SceneView* view : {&views.top, &views.side}) {
      drawPatches(context, *view, shapes);
      drawFrame(context, *view);
      drawSensor(context, *view, layer);
    }
    drawText(context,
             views.top.left,
             views.top.top - 9,
             "From above" + views.top.remark + (of_source ? "; rotated by " + pose.name : ""),
             14);
    drawText(context, views.side.left, views.side.top - 9, "From the side", 14);
    drawDirectionKey(context, kMargin + 40, sheet.height() - 46, 40);
    drawText(context,
             kMargin + 92,
             sheet.height() - 30,
             "colour: where the surface faces, as in the view from above; in a right pose both scans show the same "
             "colours",
             15);
    drawScaleBar(context, kWidth - 330, sheet.height() - 30, views.top.scale, 220);
    const std::string file = "patches_" + which + ".png";
    sheet.write(path(file));
    add(file,
        "Planar patches of the " + which,
        "What the default profile works on instead of points. Each patch is drawn as a rectangle and coloured by the "
        "direction that it faces.");
  }

  // -------------------------------------------------------------------------------------------------------------------

  void
  drawStages()
  {
    const Result& result = model_.result();
    const std::vector<LossStep> losses = model_.findLoss();
    const std::vector<StageReport>& stages = result.stages;
    constexpr int kLine = 24;
    const std::vector<std::string> facts = describeFacts(model_);
    const int height = kHeader + 30 + kLine * static_cast<int>(facts.size() + 2) + 40 +
                       kLine * static_cast<int>(stages.size()) + 60 +
                       (losses.empty() ? 0 : 50 + kLine * static_cast<int>(losses.size()));
    const Sheet sheet(height,
                      headlineOf(model_),
                      shortFileName(run_.report.source) + " onto " + shortFileName(run_.report.target) + ", " +
                          run_.report.method);
    cairo_t* context = sheet.context();
    double y = kHeader + 20;
    for (const std::string& fact : facts)
      y = drawParagraph(context, kMargin, y, kWidth - 2 * kMargin, fact, 15.5) + 3;
    if (!losses.empty()) {
      y += 18;
      drawText(context, kMargin, y, "Was the truth still there?", 18, true);
      for (const LossStep& loss : losses) {
        y += kLine;
        drawDot(
            context, kMargin + 8, y - 5, 7, fateColour(loss.passed ? SurfaceFate::Matched : SurfaceFate::Contradicted));
        drawText(context, kMargin + 26, y, loss.stage, 14.5, true);
        drawText(context, kMargin + 250, y, loss.finding, 14.5);
      }
      y += 14;
    }
    y += 34;
    drawText(context, kMargin, y, "Stages", 18, true);
    drawAlignedText(context, 430, y, "in", 14, 1, kInk, true);
    drawAlignedText(context, 560, y, "out", 14, 1, kInk, true);
    drawAlignedText(context, 680, y, "seconds", 14, 1, kInk, true);
    double longest = 1e-9;
    for (const StageReport& stage : stages)
      longest = std::max(longest, stage.seconds);
    for (const StageReport& stage : stages) {
      y += kLine;
      drawText(context, kMargin, y, stage.name, 14.5);
      drawAlignedText(context, 430, y, std::to_string(stage.count_in), 14.5, 1);
      drawAlignedText(context, 560, y, std::to_string(stage.count_out), 14.5, 1);
      drawAlignedText(context, 680, y, formatted("%.4f", stage.seconds), 14.5, 1);
      cairo_rectangle(context, 700, y - 12, 640 * stage.seconds / longest, 14);
      setColour(context, kTargetColour, 0.75);
      cairo_fill(context);
    }
    sheet.write(path("stages.png"));
    add("stages.png",
        "The run",
        "Status and message, and what went into and came out of each stage. With a known truth: the stages at which it "
        "was still among what was looked at (green), and where it was lost (red).");
  }

  std::string folder_;
  const ViewModel& model_;
  const ViewRun& run_;
  Eigen::Isometry3d T_picture_target_; ///< takes the points of the target without their offset
  FoundSensors sensors_;
  ScanLayer target_;
  std::vector<ViewPicture> pictures_;
};

} // namespace

std::vector<ViewPicture>
drawViewPictures(const std::string& folder, const ViewModel& model)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw io::IoError(folder + ": cannot be created: " + error.message());
  return PictureMaker(folder, model).drawAll();
}

} // namespace apps
} // namespace pcl_ssfr
