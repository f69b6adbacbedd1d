// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_files.h>

#include <pcl_ssfr/version.h>

#include <apps/common/degrees.h>
#include <apps/common/format_text.h>
#include <apps/common/json_values.h>
#include <apps/io/csv_line.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kMegabyte = 1e6;
constexpr std::size_t kPrinted = 12; // scans or links of a kind

std::string
matrixFields(const Eigen::Isometry3d& T)
{
  std::string text;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      text += format(",%.17g", T.matrix()(r, c));
  return text;
}

std::string
matrixNames()
{
  std::string text;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      text += format(",T%d%d", r, c);
  return text;
}

const std::string&
nameOf(const MultiwayMap& map, int scan)
{
  return map.scans[static_cast<std::size_t>(scan)].name;
}

std::vector<std::size_t>
componentSizes(const MultiwayMap& map)
{
  std::vector<std::size_t> sizes(static_cast<std::size_t>(std::max(0, map.components)));
  for (const MapScan& scan : map.scans)
    ++sizes[static_cast<std::size_t>(scan.component)];
  return sizes;
}

/// The band of the Royal Institution of Chartered Surveyors (measured surveys of land, buildings and utilities, 3rd
/// ed.) that twice the bundle error keeps.
const char*
surveyBand(double bundle_error)
{
  constexpr double kBandA = 0.025, kBandB = 0.05; // [m]
  return 2 * bundle_error <= kBandA ? "A" : 2 * bundle_error <= kBandB ? "B" : "none";
}

} // namespace

std::string
posesCsv(const MultiwayMap& map)
{
  std::string text = "scan,component" + matrixNames() + ",sigma_rotation_deg,sigma_translation_m,links,reason\n";
  for (const MapScan& scan : map.scans)
    text += io::csvField(scan.name) + format(",%d", scan.component) + matrixFields(scan.T_map_scan) +
            format(",%.6g,%.6g,%d,", scan.sigma_rotation * kDegreesPerRadian, scan.sigma_translation, scan.links) +
            io::csvField(scan.reason) + "\n";
  return text;
}

std::string
linksCsv(const MultiwayMap& map)
{
  std::string text = "source,target,status,confidence,overlap,rmse_m,strength_x,strength_y,strength_z,below_6mm,"
                     "residual_rotation_deg,residual_translation_m,reason" +
                     matrixNames() + "\n";
  for (const MapLink& link : map.links)
    text += io::csvField(nameOf(map, link.source)) + "," + io::csvField(nameOf(map, link.target)) + "," +
            toString(link.status) +
            format(",%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,",
                   link.confidence,
                   link.overlap,
                   link.rmse,
                   link.strength.x(),
                   link.strength.y(),
                   link.strength.z(),
                   link.below_6mm,
                   link.residual_rotation * kDegreesPerRadian,
                   link.residual_translation) +
            io::csvField(link.reason) + matrixFields(link.T_target_source) + "\n";
  return text;
}

std::string
posesTum(const MultiwayMap& map)
{
  std::string text = "# number of the scan, position [m], quaternion x y z w; T_map_scan of component 0\n";
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    if (map.scans[i].component != 0)
      continue;
    const Eigen::Quaterniond q(map.scans[i].T_map_scan.linear());
    const Eigen::Vector3d t = map.scans[i].T_map_scan.translation();
    text += format("%zu", i);
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
      text += format(" %.15g", value);
    text += "\n";
  }
  return text;
}

std::vector<std::size_t>
outsideOfLargest(const MultiwayMap& map)
{
  std::vector<std::size_t> outside;
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    if (map.scans[i].component != 0 || map.placed == 0)
      outside.push_back(i);
  return outside;
}

nlohmann::ordered_json
mapJson(const MapOutput& output)
{
  const MultiwayMap& map = output.map;
  const std::vector<std::size_t> sizes = componentSizes(map);
  std::size_t bytes = 0, largest = 0;
  for (const MapScan& scan : map.scans) {
    bytes += scan.bytes;
    largest = std::max(largest, scan.bytes);
  }
  std::vector<std::size_t> statuses(4);
  for (const MapLink& link : map.links)
    ++statuses[static_cast<std::size_t>(link.status)];
  nlohmann::ordered_json json;
  json["program"] = "ssfr_map";
  json["version"] = PCL_SSFR_VERSION;
  json["command"] = output.command;
  json["scans"] = map.scans.size();
  json["placed"] = map.placed;
  json["components"] = map.components;
  json["component_sizes"] = sizes;
  for (const LinkStatus status : {LinkStatus::Used, LinkStatus::Rejected, LinkStatus::Ambiguous, LinkStatus::None})
    json["links"][toString(status)] = statuses[static_cast<std::size_t>(status)];
  json["bundle_error_m"] = numberOrNull(map.bundle_error);
  json["pose_graph_error_m"] = numberOrNull(map.graph_error);
  json["survey_band"] = map.placed > 0 ? surveyBand(map.bundle_error) : "none";
  json["loops"]["median_misclosure_m"] = numberOrNull(map.median_misclosure);
  json["loops"]["largest_misclosure_m"] = numberOrNull(map.largest_misclosure);
  json["loops"]["worst"] = nlohmann::ordered_json::array();
  for (const LoopClosure& loop : map.loops) {
    nlohmann::ordered_json row;
    for (const int scan : loop.scans)
      row["scans"].push_back(nameOf(map, scan));
    row["translation_m"] = loop.translation;
    row["rotation_deg"] = loop.rotation * kDegreesPerRadian;
    json["loops"]["worst"].push_back(row);
  }
  json["bridges"] = nlohmann::ordered_json::array();
  for (const MapLink& link : map.links)
    if (link.bridge)
      json["bridges"].push_back({nameOf(map, link.source), nameOf(map, link.target)});
  json["notes"] = map.notes;
  if (!output.control.empty())
    for (const ControlResidual& c : output.control)
      json["control"].push_back({{"point", c.label},
                                 {"residual_m", c.residual.norm()},
                                 {"dx_m", c.residual.x()},
                                 {"dy_m", c.residual.y()},
                                 {"dz_m", c.residual.z()}});
  if (output.errors) {
    const MapErrors& e = *output.errors;
    nlohmann::ordered_json& truth = json["truth"];
    truth["placed"] = e.placed;
    truth["wrong"] = e.wrong;
    truth["wrong_5deg_2m"] = e.wrong_coarsely;
    truth["median_translation_m"] = numberOrNull(e.median_translation_m);
    truth["largest_translation_m"] = numberOrNull(e.largest_translation_m);
    truth["median_rotation_deg"] = numberOrNull(e.median_rotation_deg);
    truth["largest_rotation_deg"] = numberOrNull(e.largest_rotation_deg);
    truth["pose_graph_median_m"] = numberOrNull(e.graph_median_m);
    truth["chain_median_m"] = numberOrNull(e.chain_median_m);
    truth["pairs_median_m"] = numberOrNull(e.pairs_median_m);
    truth["normalised_error_squared"] = numberOrNull(e.consistency);
    for (std::size_t i = 0; i < e.scans.size(); ++i)
      if (e.scans[i])
        truth["scans"].push_back({{"scan", map.scans[i].name},
                                  {"rotation_deg", e.scans[i]->rotation_deg},
                                  {"translation_m", e.scans[i]->translation_m},
                                  {"wrong", e.scans[i]->wrong}});
  }
  json["memory"]["scans_mb"] = static_cast<double>(bytes) / kMegabyte;
  json["memory"]["largest_scan_mb"] = static_cast<double>(largest) / kMegabyte;
  json["memory"]["peak_rss_mib"] = output.peak_rss_mib;
  json["time_s"] = output.seconds;
  json["stages"] = nlohmann::ordered_json::array();
  for (const StageReport& stage : map.stages)
    json["stages"].push_back(
        {{"name", stage.name}, {"seconds", stage.seconds}, {"in", stage.count_in}, {"out", stage.count_out}});
  return json;
}

std::string
mapText(const MapOutput& output)
{
  const MultiwayMap& map = output.map;
  const std::vector<std::size_t> sizes = componentSizes(map);
  std::string text = format("%zu scans, %zu placed, %d component%s",
                            map.scans.size(),
                            map.placed,
                            map.components,
                            map.components == 1 ? "" : "s");
  if (map.components > 1) {
    text += " (";
    for (std::size_t c = 0; c < std::min(sizes.size(), kPrinted); ++c)
      text += format("%s%zu", c > 0 ? ", " : "", sizes[c]);
    text += sizes.size() > kPrinted ? ", ...)" : ")";
  }
  text += "\n";
  if (map.placed > 0) {
    text += format("bundle error %.1f mm", 1e3 * map.bundle_error);
    if (map.largest_misclosure > 0)
      text += format("; loops close to %.1f mm in the median, %.0f mm at worst",
                     1e3 * map.median_misclosure,
                     1e3 * map.largest_misclosure);
    text += "\n";
  }
  for (const std::string& note : map.notes)
    text += "note: " + note + "\n";
  std::size_t printed = 0;
  for (const MapLink& link : map.links)
    if (link.bridge && printed++ < kPrinted)
      text += "bridge: " + nameOf(map, link.source) + " - " + nameOf(map, link.target) +
              format(" alone joins two parts (confidence %.2f)\n", link.confidence);
  printed = 0;
  for (const std::size_t i : outsideOfLargest(map)) {
    if (map.scans[i].reason.empty())
      continue;
    if (printed++ == kPrinted) {
      text += "... more in poses.csv\n";
      break;
    }
    text += map.scans[i].name + ": " + map.scans[i].reason + "\n";
  }
  for (const ControlResidual& c : output.control)
    text += "control " + c.label +
            format(": %.3f m (%.3f, %.3f, %.3f)\n", c.residual.norm(), c.residual.x(), c.residual.y(), c.residual.z());
  if (output.errors) {
    const MapErrors& e = *output.errors;
    for (std::size_t i = 0; i < e.scans.size(); ++i)
      if (e.scans[i])
        text += format("truth: %s %.3f deg %.4f m%s\n",
                       map.scans[i].name.c_str(),
                       e.scans[i]->rotation_deg,
                       e.scans[i]->translation_m,
                       e.scans[i]->wrong ? " WRONG" : "");
    text += format("truth: %zu of %zu placed scans are wrong", e.wrong, e.placed);
    if (e.placed > 0)
      text += format("; of the right ones median %.1f mm (largest %.1f), %.3f deg (largest %.3f)\n"
                     "truth: medians of pairs %.1f mm, chain %.1f mm, pose graph %.1f mm, joint %.1f mm; normalised "
                     "error squared %s",
                     1e3 * e.median_translation_m,
                     1e3 * e.largest_translation_m,
                     e.median_rotation_deg,
                     e.largest_rotation_deg,
                     1e3 * e.pairs_median_m,
                     1e3 * e.chain_median_m,
                     1e3 * e.graph_median_m,
                     1e3 * e.median_translation_m,
                     std::isnan(e.consistency) ? "unknown" : format("%.2f", e.consistency).c_str());
    text += "\n";
  }
  text += format("%.1f s:", output.seconds);
  for (const StageReport& stage : map.stages)
    text += format(" %s %.1f s", stage.name.c_str(), stage.seconds);
  return text + "\n";
}

} // namespace apps
} // namespace pcl_ssfr
