// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pair_variants.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::benchmarks {

namespace {

constexpr double kDegrees = 57.29577951308232;

void
require(bool holds, const char* name, double value, const char* range)
{
  if (!holds)
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + ", but must be " + range);
}

} // namespace

pcl::PointCloud<pcl::PointXYZ>::Ptr
spoiled(const pcl::PointCloud<pcl::PointXYZ>& scan, const Spoil& spoil, std::uint64_t seed)
{
  require(spoil.every >= 1, "every", static_cast<double>(spoil.every), "at least 1");
  require(spoil.sector_degrees >= 0 && spoil.sector_degrees <= 360, "sector", spoil.sector_degrees, "0 to 360");
  require(spoil.nearest >= 0 && spoil.nearest <= 1, "nearest", spoil.nearest, "0 to 1");
  std::mt19937_64 rng(seed);
  const double begin = 360 * static_cast<double>(rng() >> 11) * 0x1.0p-53;
  std::vector<bool> kept(scan.size(), true);
  const auto remaining = [&kept] {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (kept[i])
        indices.push_back(i);
    return indices;
  };
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double angle = kDegrees * std::atan2(scan[i].y, scan[i].x) - begin;
    kept[i] = spoil.sector_degrees >= 360 || angle - 360 * std::floor(angle / 360) < spoil.sector_degrees;
  }
  if (spoil.nearest < 1) {
    std::vector<std::size_t> by_range = remaining();
    const auto range = [&scan](std::size_t i) { return scan[i].getVector3fMap().squaredNorm(); };
    std::stable_sort(
        by_range.begin(), by_range.end(), [&range](std::size_t a, std::size_t b) { return range(a) < range(b); });
    const auto near = static_cast<std::size_t>(std::ceil(spoil.nearest * static_cast<double>(by_range.size())));
    for (std::size_t k = near; k < by_range.size(); ++k)
      kept[by_range[k]] = false;
  }
  auto out = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  std::size_t number = 0;
  for (const std::size_t i : remaining())
    if (number++ % spoil.every == 0)
      out->push_back(scan[i]);
  return out;
}

std::vector<io::ScanPair>
otherPairs(const std::vector<io::ScanPair>& pairs)
{
  struct Link {
    std::string target;
    Eigen::Isometry3d T_target_source;
  };
  std::map<std::string, std::vector<Link>> links;
  std::set<std::pair<std::string, std::string>> given;
  for (const io::ScanPair& pair : pairs) {
    links[pair.source].push_back({pair.target, pair.T_target_source});
    links[pair.target].push_back({pair.source, pair.T_target_source.inverse()});
    given.emplace(pair.source, pair.target);
  }
  std::vector<io::ScanPair> others;
  for (const auto& [source, first] : links) {
    std::map<std::string, Eigen::Isometry3d> found = {{source, Eigen::Isometry3d::Identity()}};
    std::deque<std::string> open = {source};
    while (!open.empty()) {
      const std::string scan = open.front();
      open.pop_front();
      for (const Link& link : links[scan])
        if (found.emplace(link.target, link.T_target_source * found.at(scan)).second)
          open.push_back(link.target);
    }
    for (const auto& [target, T_target_source] : found)
      if (target != source && given.count({source, target}) == 0)
        others.push_back({source, target, T_target_source});
  }
  return others;
}

} // namespace pcl_ssfr::benchmarks
