// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/align/pictures.h>

#include <apps/common/degrees.h>
#include <apps/drawing/scene_drawing.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace pcl_ssfr {
namespace apps {

std::string
subtitleAfter(const Report& report)
{
  const Result& result = report.run.result;
  const double angle = Eigen::AngleAxisd(result.T_target_source.linear()).angle() * kDegreesPerRadian;
  const double moved = (result.T_target_source * report.reference - report.reference).norm();
  std::array<char, 200> text{};
  if (report.run.judged)
    std::snprintf(text.data(),
                  text.size(),
                  "%s: rotated by %.1f\u00b0, moved by %.2f m, overlap %.0f %%, confidence %.2f, %.2f s",
                  report.method.c_str(),
                  angle,
                  moved,
                  100 * result.overlap,
                  result.confidence,
                  report.run.seconds);
  else
    std::snprintf(text.data(),
                  text.size(),
                  "%s: rotated by %.1f\u00b0, moved by %.2f m, overlap %.0f %%, %.2f s",
                  report.method.c_str(),
                  angle,
                  moved,
                  100 * result.overlap,
                  report.run.seconds);
  return text.data();
}

void
drawPair(const std::string& folder,
         const io::LoadedCloud& source,
         const io::LoadedCloud& target,
         const Report& report,
         const Options& options)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw io::IoError(folder + ": cannot be created: " + error.message());

  const Eigen::Isometry3d T_picture_target =
      pictureFrame(target, options.gravity ? options.gravity->up_target : Eigen::Vector3d::UnitZ());
  const ScanLayer still =
      makeScanLayer(target, T_picture_target, kTargetColour, "target " + shortFileName(report.target));
  const auto moved = [&](const Eigen::Isometry3d& T_target_source, const std::string& label) {
    const Eigen::Isometry3d T =
        T_picture_target * Eigen::Translation3d(-target.offset) * T_target_source * Eigen::Translation3d(source.offset);
    return makeScanLayer(source, T, kSourceColour, label);
  };
  const std::string name = "source " + shortFileName(report.source);
  const ScanLayer before = moved(Eigen::Isometry3d::Identity(), name + " as it is");
  const Result& result = report.run.result;
  const ScanLayer after = moved(result.T_target_source, name + (result.accepted() ? " aligned" : " at the best pose"));

  const SceneViews views = makeSceneViews({&still, &before, &after}, kScansLimits);
  drawScans((std::filesystem::path(folder) / "before.png").string(),
            "Before",
            "both scans in their own coordinates",
            views,
            {&still, &before});
  drawScans((std::filesystem::path(folder) / "after.png").string(),
            result.accepted() ? "After" : "Not aligned: best pose that was considered",
            subtitleAfter(report),
            views,
            {&still, &after});
}

} // namespace apps
} // namespace pcl_ssfr
