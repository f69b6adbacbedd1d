// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_page.h>

#include <apps/common/degrees.h>
#include <apps/common/json_values.h>

#include <cmath>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kDigits = 1e3; // coordinates are drawn to a millimetre

double
rounded(double value)
{
  return std::round(kDigits * value) / kDigits;
}

/// \p text with every \p what replaced.
std::string
replaced(std::string text, const std::string& what, std::string_view by)
{
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

/// JSON that may stand within a script element: no "</script>" and no "<!--" in it ends or changes the element.
std::string
scriptJson(const nlohmann::ordered_json& json)
{
  return replaced(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), "<", "\\u003c");
}

/// For each component the motion that draws it upright and near the origin, where drawing is exact.
std::vector<Eigen::Isometry3d>
viewsOf(const MultiwayMap& map, const std::vector<ScanOutline>& outlines)
{
  std::vector<Eigen::Isometry3d> views;
  for (int component = 0; component < map.components; ++component) {
    std::vector<Eigen::Vector3d> points, normals, axes;
    std::vector<double> weights;
    for (std::size_t i = 0; i < map.scans.size(); ++i) {
      if (map.scans[i].component != component)
        continue;
      const Eigen::Isometry3d& T = map.scans[i].T_map_scan;
      axes.emplace_back(T.linear().col(2));
      for (Eigen::Index k = 0; k < outlines[i].points.cols(); ++k)
        points.emplace_back(T * outlines[i].points.col(k));
      for (const Eigen::Vector3d& normal : outlines[i].normals)
        normals.emplace_back(T.linear() * normal);
      weights.insert(weights.end(), outlines[i].weights.begin(), outlines[i].weights.end());
    }
    const Eigen::Vector3d centre =
        points.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : points[points.size() / 2];
    views.push_back(Eigen::Isometry3d(uprightView(points, normals, weights, axes)) * Eigen::Translation3d(-centre));
  }
  return views;
}

} // namespace

std::string
mapPage(const MapOutput& output, const std::vector<ScanOutline>& outlines)
{
  const MultiwayMap& map = output.map;
  const std::vector<Eigen::Isometry3d> views = viewsOf(map, outlines);
  nlohmann::ordered_json data;
  data["summary"] = mapJson(output);
  data["scans"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    const MapScan& scan = map.scans[i];
    nlohmann::ordered_json row;
    row["name"] = scan.name;
    row["component"] = scan.component;
    const Eigen::Isometry3d& view = views[static_cast<std::size_t>(scan.component)];
    const Eigen::Vector3d place = view * (scan.T_map_scan * outlines[i].place);
    row["usable"] = scan.usable;
    row["place"] = {rounded(place.x()), rounded(place.y()), rounded(place.z())};
    row["links"] = scan.links;
    row["sigma_mm"] = numberOrNull(1e3 * scan.sigma_translation);
    row["sigma_deg"] = numberOrNull(kDegreesPerRadian * scan.sigma_rotation);
    row["reason"] = scan.reason;
    if (output.errors && output.errors->scans[i])
      row["error_mm"] = 1e3 * output.errors->scans[i]->translation_m;
    row["points"] = nlohmann::ordered_json::array();
    for (Eigen::Index k = 0; k < outlines[i].points.cols(); ++k) {
      const Eigen::Vector3d p = view * (scan.T_map_scan * outlines[i].points.col(k));
      for (int axis = 0; axis < 3; ++axis)
        row["points"].push_back(rounded(p[axis]));
    }
    data["scans"].push_back(row);
  }
  data["links"] = nlohmann::ordered_json::array();
  for (const MapLink& link : map.links) {
    if (link.status == LinkStatus::None)
      continue;
    data["links"].push_back({{"source", link.source},
                             {"target", link.target},
                             {"status", toString(link.status)},
                             {"confidence", numberOrNull(link.confidence)},
                             {"overlap", numberOrNull(link.overlap)},
                             {"rmse_mm", numberOrNull(1e3 * link.rmse)},
                             {"strength", {link.strength.x(), link.strength.y(), link.strength.z()}},
                             {"below_6mm", numberOrNull(link.below_6mm)},
                             {"residual_mm", numberOrNull(1e3 * link.residual_translation)},
                             {"residual_deg", numberOrNull(kDegreesPerRadian * link.residual_rotation)},
                             {"bridge", link.bridge},
                             {"reason", link.reason}});
  }
  std::string page(mapAsset("report.html"));
  page = replaced(page, "/*STYLE*/", mapAsset("report.css"));
  page = replaced(page, "/*SCRIPT*/", mapAsset("report.js"));
  return replaced(page, "/*DATA*/", scriptJson(data));
}

} // namespace apps
} // namespace pcl_ssfr
