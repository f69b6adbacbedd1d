// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/storeys.h"

#include "common/angles.h"
#include "multiway/scan_pair.h"
#include "profiles/prepared_data.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Mean square of the cosine to its axis, below which a view goes around it: 1/3 of a view to all sides or to one half
/// of them, 0.2 of a dome of 60 degrees.
constexpr double kLooksAround = 0.28;

/// Call \p visit(normal, way from the sensor [m], area [m^2]) for each patch of a scan, in the frame of the map.
template <typename Visit>
void
forEachPatch(const StoreyScan& scan, const Visit& visit)
{
  const OrientedSamples& surface = *scan.surface;
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Eigen::Vector3d normal = scan.T_map_surface.linear() * surface.normals.col(i);
    const Eigen::Vector3d way = scan.T_map_surface * surface.points.col(i) - scan.place;
    visit(normal, way, surface.weights[i]);
  }
}

/// Distance of the surface below a sensor that faces up, the lower half of what is seen within reach: the median by
/// area; NaN when hardly anything faces there.
double
floorDistance(const StoreyScan& scan, const Eigen::Vector3d& up, const AliasConfig& config)
{
  std::vector<std::pair<double, double>> below; // distance, area
  double sum = 0;
  forEachPatch(scan, [&](const Eigen::Vector3d& n, const Eigen::Vector3d& d, double area) {
    const double height = -d.dot(up);
    const double lateral = (d + height * up).norm();
    if (n.dot(up) < config.level_normal || height <= 0 || height > config.most_floor || lateral > config.most_floor)
      return;
    below.emplace_back(height, area);
    sum += area;
  });
  if (!(sum > 0))
    return std::numeric_limits<double>::quiet_NaN();
  std::sort(below.begin(), below.end());
  double lower = 0;
  for (const auto& [height, area] : below)
    if (2 * (lower += area) >= sum)
      return height;
  return below.back().first;
}

/// Height of the surface below a sensor along \p up, in the map [m]; NaN as floorDistance().
double
floorHeight(const StoreyScan& scan, const Eigen::Vector3d& up, const AliasConfig& config)
{
  return scan.place.dot(up) - floorDistance(scan, up, config);
}

/// Median of them over some scans [m]; NaN where none has one.
double
floorHeight(const std::vector<StoreyScan>& scans,
            const std::vector<std::size_t>& some,
            const Eigen::Vector3d& up,
            const AliasConfig& config)
{
  std::vector<double> heights;
  for (const std::size_t i : some)
    if (const double height = floorHeight(scans[i], up, config); !std::isnan(height))
      heights.push_back(height);
  if (heights.empty())
    return std::numeric_limits<double>::quiet_NaN();
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

/// Share of the scans whose floor is as far below as that of the most.
double
levelShare(const std::vector<StoreyScan>& scans, const Eigen::Vector3d& up, const AliasConfig& config)
{
  std::vector<double> distances;
  for (const StoreyScan& scan : scans) {
    const double distance = floorDistance(scan, up, config);
    if (!std::isnan(distance))
      distances.push_back(distance);
  }
  std::sort(distances.begin(), distances.end());
  std::size_t most = 0;
  for (std::size_t first = 0, last = 0; last < distances.size(); ++last) {
    while (distances[last] - distances[first] > config.same_level)
      ++first;
    most = std::max(most, last - first + 1);
  }
  return static_cast<double>(most) / static_cast<double>(scans.size());
}

/// Directions that most surface of a part faces, by area, distinct, both signs.
std::vector<Eigen::Vector3d>
mainDirections(const std::vector<StoreyScan>& scans, const AliasConfig& config)
{
  std::vector<std::pair<double, Eigen::Vector3d>> directions;
  for (const StoreyScan& scan : scans)
    forEachPatch(scan, [&](const Eigen::Vector3d& n, const Eigen::Vector3d&, double area) {
      const auto found = std::find_if(directions.begin(), directions.end(), [&](const auto& d) {
        return std::abs(d.second.normalized().dot(n)) > config.level_normal;
      });
      if (found == directions.end())
        directions.emplace_back(area, area * n);
      else {
        found->first += area;
        found->second += area * (found->second.dot(n) < 0 ? -n : n);
      }
    });
  std::stable_sort(
      directions.begin(), directions.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr std::size_t kMost = 6; // three of a Manhattan room, and some more
  directions.resize(std::min(directions.size(), kMost));
  std::vector<Eigen::Vector3d> both;
  for (const auto& [weight, sum] : directions) {
    both.emplace_back(sum.normalized());
    both.emplace_back(-sum.normalized());
  }
  return both;
}

/// Whether a scan sees a floor and a ceiling, in whichever direction \p up points.
bool
isIndoors(const StoreyScan& scan, const Eigen::Vector3d& up, const AliasConfig& config)
{
  double floor = 0, ceiling = 0; // [m^2]
  forEachPatch(scan, [&](const Eigen::Vector3d& n, const Eigen::Vector3d& d, double area) {
    const double facing = n.dot(up);
    const double height = d.dot(up);
    const bool is_near = std::abs(height) < config.storey && (d - height * up).norm() < config.storey;
    if (std::abs(facing) < config.level_normal || facing * height > 0 || !is_near)
      return; // upright, or it turns its back
    (height < 0 ? floor : ceiling) += area;
  });
  return floor > 0 && ceiling > 0;
}

/// The directions in which a sensor sees something, map frame. Each patch counts by the solid angle that it fills, so
/// that in a room this is the field of view, whatever stands near.
struct FieldOfView {
  Eigen::Matrix3d about_zero = Eigen::Matrix3d::Zero(); ///< mean of d d^T over the directions d
  Eigen::Matrix3d about_mean = Eigen::Matrix3d::Zero(); ///< the same of what d differs from its mean
};

FieldOfView
fieldOfView(const StoreyScan& scan)
{
  FieldOfView view;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double all = 0; // [sr]
  forEachPatch(scan, [&](const Eigen::Vector3d& normal, const Eigen::Vector3d& ray, double area) {
    const Eigen::Vector3d d = ray.normalized();
    const double angle = area * std::abs(normal.dot(d)) / (ray.squaredNorm() + area / kPi); // never above pi
    if (!std::isfinite(angle))
      return; // at the sensor
    all += angle;
    sum += angle * d;
    view.about_zero += angle * d * d.transpose();
  });
  if (all > 0) {
    view.about_zero /= all;
    view.about_mean = view.about_zero - sum * sum.transpose() / (all * all);
  }
  return view;
}

/// The direction that level surfaces face near \p axis: they are level to a fraction of a degree, which the axis of a
/// view is not. The axis itself where there are none.
Eigen::Vector3d
levelDirection(const std::vector<StoreyScan>& scans, const Eigen::Vector3d& axis, const AliasConfig& config)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const StoreyScan& scan : scans)
    forEachPatch(scan, [&](const Eigen::Vector3d& n, const Eigen::Vector3d&, double area) {
      if (std::abs(n.dot(axis)) > config.level_normal)
        sum += area * (n.dot(axis) < 0 ? -n : n);
    });
  return sum.norm() > 0 ? sum.normalized() : axis;
}

/// The vertical by sensors that look all around, but not all the way up and down: rings, or a dome. The spread of what
/// they see is flat. None where they look everywhere or one way only, or where the axes of the scans differ.
std::optional<Eigen::Vector3d>
verticalByView(const std::vector<StoreyScan>& scans, const AliasConfig& config)
{
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Vector3d> axes;
  for (const StoreyScan& scan : scans) {
    const FieldOfView view = fieldOfView(scan);
    sum += view.about_mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(view.about_mean);
    const Eigen::Vector3d axis = solver.eigenvectors().col(0);
    const bool is_flat = solver.eigenvalues()[0] < config.flat_view * solver.eigenvalues()[1];
    const bool looks_around = axis.dot(view.about_zero * axis) < kLooksAround;
    if (is_flat && looks_around)
      axes.push_back(axis);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
  const Eigen::Vector3d axis = solver.eigenvectors().col(0);
  const auto alike = std::count_if(
      axes.begin(), axes.end(), [&](const Eigen::Vector3d& a) { return std::abs(a.dot(axis)) > config.level_normal; });
  if (static_cast<double>(alike) < config.least_level_share * static_cast<double>(scans.size()))
    return std::nullopt;
  return levelDirection(scans, axis, config);
}

/// Whether at least \p least of some scans stand at places of their own.
bool
haveManyPlaces(const std::vector<StoreyScan>& scans,
               const std::vector<std::size_t>& some,
               std::size_t least,
               double same_place)
{
  std::vector<Eigen::Vector3d> places;
  for (const std::size_t i : some) {
    const bool is_known = std::any_of(places.begin(), places.end(), [&](const Eigen::Vector3d& place) {
      return (place - scans[i].place).norm() < same_place;
    });
    if (!is_known)
      places.push_back(scans[i].place);
    if (places.size() >= least)
      return true;
  }
  return false;
}

} // namespace

StoreyScan
storeyScan(const PreparedScan& scan, const Eigen::Isometry3d& T_map_scan)
{
  const PatchScan& patches = patchesOf(scan);
  return {&patches.patches.samples, T_map_scan * Eigen::Translation3d(patches.origin), T_map_scan * placeOf(scan)};
}

std::optional<Eigen::Vector3d>
findUp(const std::vector<StoreyScan>& scans, const std::optional<Eigen::Vector3d>& gravity, const AliasConfig& config)
{
  if (!gravity)
    return findUp(scans, config);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const StoreyScan& scan : scans)
    sum += scan.T_map_surface.linear() * gravity->normalized();
  return sum.norm() > 0 ? std::optional<Eigen::Vector3d>(sum.normalized()) : std::nullopt;
}

std::optional<Eigen::Vector3d>
findUp(const std::vector<StoreyScan>& scans, const AliasConfig& config)
{
  if (scans.empty())
    return std::nullopt;
  if (std::optional<Eigen::Vector3d> up = verticalByView(scans, config))
    return up;
  std::optional<Eigen::Vector3d> best;
  double most = config.least_level_share;
  for (const Eigen::Vector3d& up : mainDirections(scans, config)) {
    const double share = levelShare(scans, up, config);
    if (share > most) {
      most = share;
      best = up;
    }
  }
  return best;
}

std::optional<StoreyDoubt>
findStoreyDoubt(const std::vector<StoreyScan>& scans,
                const Eigen::Vector3d& up,
                bool others,
                double same_place,
                const AliasConfig& config)
{
  std::vector<std::pair<double, std::size_t>> heights;
  for (std::size_t i = 0; i < scans.size(); ++i)
    heights.emplace_back(scans[i].place.dot(up), i);
  std::sort(heights.begin(), heights.end());
  // Levels: scans at one height and several places, the fullest first; what is left is between levels. Scans at one
  // height and one place are of stairs that lie on one another.
  std::vector<char> is_taken(scans.size(), 0), is_level(scans.size(), 0);
  std::vector<std::pair<double, std::vector<std::size_t>>> levels;
  while (true) {
    std::vector<std::size_t> fullest;
    for (std::size_t first = 0; first < heights.size(); ++first) {
      std::vector<std::size_t> level;
      for (std::size_t k = first; k < heights.size() && heights[k].first - heights[first].first <= config.same_level;
           ++k)
        if (!is_taken[heights[k].second])
          level.push_back(heights[k].second);
      if (level.size() > fullest.size())
        fullest = level;
    }
    if (fullest.size() < config.least_scans)
      break;
    for (const std::size_t i : fullest)
      is_taken[i] = 1;
    if (!haveManyPlaces(scans, fullest, config.least_scans, same_place))
      continue;
    double mean = 0;
    for (const std::size_t i : fullest) {
      is_level[i] = 1;
      mean += scans[i].place.dot(up) / static_cast<double>(fullest.size());
    }
    levels.emplace_back(mean, fullest);
  }
  for (const auto& [height, level] : levels) {
    const auto indoors =
        std::count_if(level.begin(), level.end(), [&](std::size_t i) { return isIndoors(scans[i], up, config); });
    if (2 * static_cast<std::size_t>(indoors) < level.size())
      continue; // a road, not a storey
    StoreyDoubt doubt;
    doubt.level = level;
    bool leads_up = false, leads_down = false; // to another level
    for (const auto& other : levels) {
      leads_up = leads_up || other.first > height + config.same_level;
      leads_down = leads_down || other.first < height - config.same_level;
    }
    const double floor = floorHeight(scans, level, up, config);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      // On the floor of the level all the same: a higher tripod, or a sensor whose place was estimated.
      if (is_level[i] || std::abs(floorHeight(scans[i], up, config) - floor) <= config.same_level)
        continue;
      const double above = scans[i].place.dot(up) - height;
      if (above > config.same_level && above < config.storey && !leads_up)
        doubt.above.push_back(i);
      if (-above > config.same_level && -above < config.storey && !leads_down)
        doubt.below.push_back(i);
    }
    const bool both = !doubt.above.empty() && !doubt.below.empty();
    const bool either = !doubt.above.empty() || !doubt.below.empty();
    if (both || (either && others))
      return doubt;
  }
  return std::nullopt;
}

std::vector<std::size_t>
scansInDoubt(const std::vector<StoreyScan>& scans, const StoreyDoubt& doubt, double same_place)
{
  std::set<std::size_t> in_doubt(doubt.level.begin(), doubt.level.end());
  if (doubt.above.size() <= doubt.below.size())
    in_doubt.insert(doubt.above.begin(), doubt.above.end());
  if (doubt.below.size() <= doubt.above.size())
    in_doubt.insert(doubt.below.begin(), doubt.below.end());
  for (const std::vector<std::size_t>* way : {&doubt.above, &doubt.below})
    for (const std::size_t i : *way)
      for (const std::size_t j : *way)
        if (i != j && (scans[i].place - scans[j].place).norm() < same_place)
          in_doubt.insert(i);
  return {in_doubt.begin(), in_doubt.end()};
}

} // namespace pcl_ssfr
