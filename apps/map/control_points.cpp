// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/control_points.h>

#include <apps/common/degrees.h>
#include <apps/common/format_text.h>
#include <apps/io/io_error.h>
#include <apps/map/csv_table.h>
#include <apps/map/pose_list.h>

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kLine = 0.05;  // [m] places nearer to a line than this (root of the sum of squares) are on it
constexpr double kKnown = 0.01; // [m] control points of a site are not better known than this
constexpr double kMisfit = 5;   // times what the others disagree, from which on a point contradicts them
constexpr double kUnit = 2;     // times, by which all distances differ, from which on they are in another unit

ControlFit
fitPoints(const std::vector<Eigen::Vector3d>& map, const std::vector<Eigen::Vector3d>& site)
{
  ControlFit fit;
  fit.T_site_map = fitPlaces(map, site);
  for (std::size_t i = 0; i < map.size(); ++i)
    fit.residuals.emplace_back(fit.T_site_map * map[i] - site[i]);
  return fit;
}

constexpr std::array<const char*, 3> kInScan = {"sx", "sy", "sz"};

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

/// How many times as long distances in the site are as in the map, where all say that they are in another unit.
std::optional<double>
otherUnit(const ControlledPlaces& places)
{
  double least = std::numeric_limits<double>::infinity(), most = 0, map = 0, site = 0;
  for (std::size_t i = 0; i < places.map.size(); ++i)
    for (std::size_t k = i + 1; k < places.map.size(); ++k) {
      const double in_map = (places.map[i] - places.map[k]).norm(), in_site = (places.site[i] - places.site[k]).norm();
      least = std::min(least, in_site / in_map);
      most = std::max(most, in_site / in_map);
      map += in_map;
      site += in_site;
    }
  return least > kUnit || most < 1 / kUnit ? std::optional<double>(site / map) : std::nullopt;
}

/// Angle of the vertical of the map to that of the site [rad].
double
tiltAt(const Eigen::Isometry3d& T_site_map, const MapVertical& vertical)
{
  const double z = (T_site_map.linear() * vertical.up).z();
  return std::acos(std::clamp(vertical.is_signed ? z : std::abs(z), -1.0, 1.0));
}

/// Whether the control fits upright, and as well, with its first two coordinates swapped.
bool
fitsSwapped(const ControlledPlaces& places, double residual, const MapVertical& vertical, double tolerance)
{
  std::vector<Eigen::Vector3d> swapped = places.site;
  for (Eigen::Vector3d& place : swapped)
    std::swap(place.x(), place.y());
  const ControlFit fit = fitControl(places.map, swapped);
  return tiltAt(fit.T_site_map, vertical) <= tolerance && rootMeanSquare(fit.residuals) <= std::max(residual, kKnown);
}

} // namespace

std::vector<ControlPoint>
readControl(const std::string& path)
{
  CsvTable table(path);
  std::vector<ControlPoint> points;
  std::vector<Eigen::Vector3d> places;
  std::set<std::pair<std::string, std::string>> names;
  while (table.next()) {
    ControlPoint point;
    point.scan = table.field("scan");
    if (table.has("point"))
      point.point = table.field("point");
    point.site = readPlace(table, {"x", "y", "z"});
    const bool is_in_scan = std::any_of(kInScan.begin(), kInScan.end(), [&](const char* column) {
      return table.has(column) && !table.field(column).empty();
    });
    if (is_in_scan) // all three of them then
      point.in_scan = readPlace(table, kInScan);
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
      fit.T_site_map_of_others = rest.T_site_map;
    }
  }
  return fit;
}

std::vector<std::string>
doubtsOfControl(const ControlledPlaces& places,
                const ControlFit& fit,
                const std::optional<MapVertical>& vertical,
                double tolerance)
{
  std::vector<std::string> doubts;
  if (fit.misfit)
    doubts.push_back(format("control %s is %.3f m from where the other control puts it, which agrees to %.3f m",
                            places.labels[*fit.misfit].c_str(),
                            fit.misfit_distance,
                            fit.others));
  else {
    const auto norm = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.norm() < b.norm(); };
    const auto most = std::max_element(fit.residuals.begin(), fit.residuals.end(), norm);
    const auto i = static_cast<std::size_t>(most - fit.residuals.begin());
    if (most->norm() > kMisfit * std::max(places.sigma[i], kKnown))
      doubts.push_back(format("control does not fit: %s is off by %.3f m, the most of %zu places",
                              places.labels[i].c_str(),
                              most->norm(),
                              places.labels.size()));
    if (const std::optional<double> times = otherUnit(places))
      doubts.push_back(format("distances between the control are %.4g times those in the map: coordinates of a site "
                              "are in metres",
                              *times));
  }
  if (!vertical)
    return doubts;
  const Eigen::Isometry3d& T_site_map = fit.misfit ? fit.T_site_map_of_others : fit.T_site_map;
  const double tilt = tiltAt(T_site_map, *vertical);
  if (tilt > tolerance)
    doubts.push_back(format("control tilts the map by %.1f degrees against its vertical, which is z in a site%s",
                            tilt * kDegreesPerRadian,
                            fitsSwapped(places, rootMeanSquare(fit.residuals), *vertical, tolerance)
                                ? "; with x and y swapped it would be upright"
                                : ""));
  return doubts;
}

} // namespace apps
} // namespace pcl_ssfr
