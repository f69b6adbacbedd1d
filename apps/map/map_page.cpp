// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_page.h>

#include "common/angles.h"

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

/// JSON that may stand within a script element.
std::string
scriptJson(const nlohmann::ordered_json& json)
{
  return replaced(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), "</", "<\\/");
}

} // namespace

std::string
mapPage(const MapOutput& output,
        const std::vector<Eigen::Matrix3Xf>& outlines,
        const std::vector<Eigen::Vector3d>& places)
{
  const MultiwayMap& map = output.map;
  nlohmann::ordered_json data;
  data["summary"] = mapJson(output);
  data["scans"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    const MapScan& scan = map.scans[i];
    nlohmann::ordered_json row;
    row["name"] = scan.name;
    row["component"] = scan.component;
    const Eigen::Vector3d place = scan.T_map_scan * places[i];
    row["place"] = {rounded(place.x()), rounded(place.y()), rounded(place.z())};
    row["links"] = scan.links;
    row["sigma_mm"] = numberOrNull(1e3 * scan.sigma_translation);
    row["sigma_deg"] = numberOrNull(kDegreesPerRadian * scan.sigma_rotation);
    row["reason"] = scan.reason;
    if (output.errors && output.errors->scans[i])
      row["error_mm"] = 1e3 * output.errors->scans[i]->translation_m;
    row["points"] = nlohmann::ordered_json::array();
    for (Eigen::Index k = 0; k < outlines[i].cols(); ++k) {
      const Eigen::Vector3d p = scan.T_map_scan * outlines[i].col(k).cast<double>();
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
