// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/report.h>

#include "judgement/scored_pose.h"

#include <pcl_ssfr/version.h>

#include <apps/common/degrees.h>
#include <apps/common/format_text.h>
#include <apps/common/json_values.h>
#include <apps/methods/options_json.h>

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kAlternatives = 4; ///< listed for people

/// Where a file is found from any folder; empty for no file.
std::string
absolutePath(const std::string& path)
{
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  return path.empty() || error ? path : absolute.lexically_normal().string();
}

/// Angle of a rotation [deg].
double
angleDegrees(const Eigen::Matrix3d& R)
{
  return Eigen::AngleAxisd(R).angle() * kDegreesPerRadian;
}

std::string
describePose(const Eigen::Isometry3d& T)
{
  const Eigen::AngleAxisd rotation(T.linear());
  const Eigen::Vector3d& axis = rotation.axis();
  const Eigen::Matrix3d& R = T.linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0)) * kDegreesPerRadian;
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0)) * kDegreesPerRadian;
  const double roll = std::atan2(R(2, 1), R(2, 2)) * kDegreesPerRadian;
  const Eigen::Vector3d t = T.translation();
  std::string text = format("  rotation     %.3f deg about (%.3f, %.3f, %.3f); yaw %.3f, pitch %.3f, roll %.3f deg\n",
                            rotation.angle() * kDegreesPerRadian,
                            axis.x(),
                            axis.y(),
                            axis.z(),
                            yaw,
                            pitch,
                            roll);
  text += format("  translation  (%.4f, %.4f, %.4f) m, length %.3f m\n", t.x(), t.y(), t.z(), t.norm());
  text += "  T_target_source (a point of TARGET is T times a point of SOURCE)\n";
  for (Eigen::Index row = 0; row < 4; ++row)
    text += format("    %12.9f %12.9f %12.9f %14.6f\n",
                   T.matrix()(row, 0),
                   T.matrix()(row, 1),
                   T.matrix()(row, 2),
                   T.matrix()(row, 3));
  return text;
}

std::string
describeAlternatives(const Report& report)
{
  const Result& result = report.run.result;
  if (result.candidates.size() < 2)
    return {};
  const Candidate& best = result.candidates.front();
  std::string text = "Other poses that were considered, seen from the first:\n";
  for (std::size_t i = 1; i < result.candidates.size() && i <= kAlternatives; ++i) {
    const Candidate& other = result.candidates[i];
    const Eigen::Isometry3d apart = best.T_target_source.inverse() * other.T_target_source;
    text += format("  %zu. score %.2f of the best, overlap %.0f %%, contradicted %.1f %%: %.1f deg and %.2f m away%s\n",
                   i + 1,
                   best.score != 0 ? other.score / best.score : 0.0,
                   100 * other.overlap,
                   100 * other.contradiction,
                   angleDegrees(apart.linear()),
                   translationBetween(other.T_target_source, best.T_target_source, report.reference),
                   other.from_guess ? " (the guess)" : "");
  }
  if (result.candidates.size() > kAlternatives + 1)
    text += format("  and %zu more, see --json\n", result.candidates.size() - kAlternatives - 1);
  return text + "\n";
}

Json
viewpointOrNull(bool used, const Eigen::Vector3d& viewpoint)
{
  return used ? Json{viewpoint.x(), viewpoint.y(), viewpoint.z()} : Json(nullptr);
}

std::string
describeSensor(bool used, bool found, const Eigen::Vector3d& viewpoint)
{
  if (!used)
    return "place unknown, free space not used";
  if (!found)
    return "at its given place";
  return format("found in the points at (%.1f, %.1f, %.1f) m", viewpoint.x(), viewpoint.y(), viewpoint.z());
}

std::string
describeUnobservable(const Result& result)
{
  std::string text;
  for (const UnobservableDirection& direction : result.unobservable)
    text += format("  %s (%.3f, %.3f, %.3f) of TARGET: %.2f %% of the evidence of the best direction\n",
                   direction.rotation ? "rotation about" : "translation along",
                   direction.direction.x(),
                   direction.direction.y(),
                   direction.direction.z(),
                   100 * direction.strength);
  return text.empty() ? text : "Hardly determined by these scans:\n" + text + "\n";
}

std::string
describeTimes(const Report& report)
{
  std::string text = format("Time %.3f s (loading %.3f s not counted), peak memory %.0f MiB\n",
                            report.run.seconds,
                            report.loading_seconds,
                            report.peak_rss_mib);
  for (const StageReport& stage : report.run.result.stages)
    text += format("  %-24s %8.3f s %10llu -> %llu\n",
                   stage.name.c_str(),
                   stage.seconds,
                   static_cast<unsigned long long>(stage.count_in),
                   static_cast<unsigned long long>(stage.count_out));
  return text;
}

} // namespace

std::string
describeSensors(const Result& result)
{
  const std::string source =
      describeSensor(result.source_viewpoint_used, result.source_viewpoint_found, result.source_viewpoint);
  const std::string target =
      describeSensor(result.target_viewpoint_used, result.target_viewpoint_found, result.target_viewpoint);
  return source == target ? source + " in both scans" : source + " in SOURCE, " + target + " in TARGET";
}

double
peakRssMib()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024; // Linux counts in KiB
}

Json
toJson(const Report& report)
{
  const Result& result = report.run.result;
  Json json;
  json["method"] = report.method;
  json["status"] = toString(result.status);
  json["converged"] = result.accepted();
  json["message"] = result.message;
  json["T_target_source"] = matrixJson(result.T_target_source);
  json["overlap"] = numberOrNull(result.overlap);
  json["confidence"] = report.run.judged ? numberOrNull(result.confidence) : Json(nullptr);
  json["contradiction"] = report.run.judged ? numberOrNull(result.contradiction) : Json(nullptr);
  json["rmse_m"] = numberOrNull(result.rmse);
  json["correspondence_distance_m"] = report.run.judged ? numberOrNull(result.correspondence_distance) : Json(nullptr);
  json["time_s"] = report.run.seconds;
  json["loading_s"] = report.loading_seconds;
  json["peak_rss_mib"] = report.peak_rss_mib;
  json["probability_of_none"] = report.run.judged ? numberOrNull(result.probability_of_none) : Json(nullptr);
  json["candidates"] = Json::array();
  for (const Candidate& candidate : result.candidates)
    json["candidates"].push_back({{"T_target_source", matrixJson(candidate.T_target_source)},
                                  {"probability", numberOrNull(candidate.probability)},
                                  {"score", numberOrNull(candidate.score)},
                                  {"overlap", numberOrNull(candidate.overlap)},
                                  {"contradiction", numberOrNull(candidate.contradiction)},
                                  {"rmse_m", numberOrNull(candidate.rmse)},
                                  {"from_guess", candidate.from_guess}});
  json["unobservable"] = Json::array();
  for (const UnobservableDirection& direction : result.unobservable)
    json["unobservable"].push_back({{"kind", direction.rotation ? "rotation" : "translation"},
                                    {"direction", vectorJson(direction.direction)},
                                    {"strength", numberOrNull(direction.strength)}});
  json["information"] = Json::array();
  for (Eigen::Index row = 0; row < 6; ++row) {
    Json values = Json::array();
    for (Eigen::Index column = 0; column < 6; ++column)
      values.push_back(numberOrNull(result.information(row, column)));
    json["information"].push_back(values);
  }
  json["source_viewpoint_used"] = result.source_viewpoint_used;
  json["target_viewpoint_used"] = result.target_viewpoint_used;
  json["source_viewpoint_found"] = result.source_viewpoint_found;
  json["target_viewpoint_found"] = result.target_viewpoint_found;
  json["source_viewpoint_m"] = viewpointOrNull(result.source_viewpoint_used, result.source_viewpoint);
  json["target_viewpoint_m"] = viewpointOrNull(result.target_viewpoint_used, result.target_viewpoint);
  json["stages"] = Json::array();
  for (const StageReport& stage : result.stages)
    json["stages"].push_back(
        {{"name", stage.name}, {"seconds", stage.seconds}, {"in", stage.count_in}, {"out", stage.count_out}});
  json["source"] = report.source;
  json["target"] = report.target;
  json["source_path"] = absolutePath(report.source);
  json["target_path"] = absolutePath(report.target);
  json["options"] = optionsJson(report.options);
  json["guess"] = report.guess ? matrixJson(*report.guess) : Json(nullptr);
  json["version"] = PCL_SSFR_VERSION;
  return json;
}

std::string
toJsonText(const Report& report)
{
  return toJson(report).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string
headline(const Report& report)
{
  const Result& result = report.run.result;
  if (result.accepted())
    return "Aligned " + report.source + " onto " + report.target + " (" + report.method + ")";
  return std::string("Not aligned, ") + toString(result.status) + ": " + result.message;
}

std::string
toText(const Report& report)
{
  const Result& result = report.run.result;
  std::string text = headline(report) + "\n\n";
  if (!result.accepted() && result.candidates.empty())
    return text + describeTimes(report);
  if (!result.accepted())
    text += "Best pose that was considered, not to be used unchecked:\n";
  text += describePose(result.T_target_source);
  if (report.run.judged)
    text += format("  confidence   %.2f; overlap %.0f %%, contradicted %.1f %%, point-to-plane rms %.1f mm\n",
                   result.confidence,
                   100 * result.overlap,
                   100 * result.contradiction,
                   1000 * result.rmse);
  else
    text += format("  confidence   unknown to this method; overlap %.0f %%, point-to-point rms %.1f mm\n",
                   100 * result.overlap,
                   1000 * result.rmse);
  if (result.accepted() && !result.message.empty())
    text += "  " + result.message + "\n";
  if (report.run.judged)
    text += "  sensor       " + describeSensors(result) + "\n";
  return text + "\n" + describeAlternatives(report) + describeUnobservable(result) + describeTimes(report);
}

} // namespace apps
} // namespace pcl_ssfr
