// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/control_points.h>

#include <apps/io/io_error.h>
#include <apps/map/csv_table.h>
#include <apps/map/pose_list.h>

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kLine = 0.05;  // [m] places nearer to a line than this (root of the sum of squares) are on it
constexpr double kKnown = 0.01; // [m] control points of a site are not better known than this
constexpr double kMisfit = 5;   // times what the others disagree, from which on a point contradicts them

ControlFit
fitPoints(const std::vector<Eigen::Vector3d>& map, const std::vector<Eigen::Vector3d>& site)
{
  ControlFit fit;
  fit.T_site_map = fitPlaces(map, site);
  for (std::size_t i = 0; i < map.size(); ++i)
    fit.residuals.emplace_back(fit.T_site_map * map[i] - site[i]);
  return fit;
}

Eigen::Vector3d
readPlace(const CsvTable& table, const std::array<const char*, 3>& columns)
{
  Eigen::Vector3d place;
  for (int k = 0; k < 3; ++k)
    place[k] = table.number(columns[static_cast<std::size_t>(k)]);
  return place;
}

/// Whatever else is wrong with them: a false figure among them is named later.
bool
lieOnALine(const std::vector<Eigen::Vector3d>& places)
{
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i)
    all.col(static_cast<Eigen::Index>(i)) = places[i] - places.front();
  const Eigen::Matrix3Xd centred = all.colwise() - all.rowwise().mean();
  return !(Eigen::JacobiSVD<Eigen::Matrix3Xd>(centred).singularValues()[1] > kLine);
}

double
rootMeanSquare(const std::vector<Eigen::Vector3d>& residuals)
{
  double sum = 0;
  for (const Eigen::Vector3d& r : residuals)
    sum += r.squaredNorm();
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

} // namespace

std::vector<ControlPoint>
readControl(const std::string& path)
{
  CsvTable table(path);
  std::vector<ControlPoint> points;
  std::vector<Eigen::Vector3d> places;
  std::set<std::pair<std::string, std::string>> names;
  const bool has_points = table.has("sx");
  while (table.next()) {
    ControlPoint point;
    point.scan = table.field("scan");
    if (table.has("point"))
      point.point = table.field("point");
    point.site = readPlace(table, {"x", "y", "z"});
    if (has_points && !table.field("sx").empty())
      point.in_scan = readPlace(table, {"sx", "sy", "sz"});
    if (!names.insert({point.scan, point.point}).second)
      throw table.error("a second place of " + io::inQuotes(point.label()));
    places.push_back(point.site);
    points.push_back(point);
  }
  if (places.size() < 3 || lieOnALine(places))
    throw io::IoError(path + ": holds " + std::to_string(points.size()) +
                      " places: it takes three places or more that are not on a line");
  return points;
}

ControlFit
fitControl(const std::vector<Eigen::Vector3d>& map, const std::vector<Eigen::Vector3d>& site)
{
  ControlFit fit = fitPoints(map, site);
  for (std::size_t left_out = 0; left_out < map.size() && map.size() > 3; ++left_out) {
    std::vector<Eigen::Vector3d> map_rest = map, site_rest = site;
    map_rest.erase(map_rest.begin() + static_cast<std::ptrdiff_t>(left_out));
    site_rest.erase(site_rest.begin() + static_cast<std::ptrdiff_t>(left_out));
    ControlFit rest;
    try {
      rest = fitPoints(map_rest, site_rest);
    }
    catch (const std::invalid_argument&) {
      continue; // the others are on a line: they say nothing of it
    }
    const double others = rootMeanSquare(rest.residuals);
    const double distance = (rest.T_site_map * map[left_out] - site[left_out]).norm();
    if (distance > kMisfit * std::max(others, kKnown) && (!fit.misfit || others < fit.others)) {
      fit.misfit = left_out;
      fit.misfit_distance = distance;
      fit.others = others;
    }
  }
  return fit;
}

} // namespace apps
} // namespace pcl_ssfr
