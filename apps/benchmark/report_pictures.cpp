// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/report_pictures.h>

#include "preparation/thinning.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kLeafShare = 1. / 60;    ///< edge of the voxels, of the radius
constexpr double kReach = 3;              ///< farther points are left out, in radii
constexpr std::size_t kMostPoints = 1500; ///< of a cloud in a report: 12 kB in base64
constexpr double kMostUnits = 32767;

/// A pair of a dataset, by how many runs did not solve it.
struct Candidate {
  const io::DatasetFolder* dataset;
  std::size_t pair;
  std::size_t failures;
};

std::vector<Candidate>
rankPairs(const std::vector<ResultRow>& rows, const std::vector<io::DatasetFolder>& datasets)
{
  std::map<std::pair<std::string, std::size_t>, std::size_t> failures;
  for (const ResultRow& row : rows)
    if (isDrawn(row.variation))
      failures[{row.dataset, row.pair}] += row.success ? 0 : 1;
  std::vector<Candidate> ranked;
  for (const io::DatasetFolder& dataset : datasets)
    for (std::size_t i = 0; i < dataset.pairs.size(); ++i) {
      const auto found = failures.find({dataset.name, i});
      if (found != failures.end())
        ranked.push_back({&dataset, i, found->second});
    }
  std::stable_sort(
      ranked.begin(), ranked.end(), [](const Candidate& a, const Candidate& b) { return a.failures > b.failures; });
  return ranked;
}

} // namespace

bool
isDrawn(const Variation& variation)
{
  return variation.pairs_from == PairsFrom::Listed && !(variation.origin_offset_m > 0) && !variation.merge_target &&
         !variation.mirror_source;
}

ReportCloud
makeReportCloud(const io::LoadedCloud& cloud)
{
  ReportCloud result;
  const ScanView view = viewOf(cloud);
  const ScanExtent extent = measureExtent(view);
  result.origin = cloud.offset + extent.median;
  if (extent.returns == 0)
    return result;
  // Scans of a single place have no radius; any step shows them.
  const double radius = extent.radius > 0 ? extent.radius : 1;
  result.step = kReach * radius / kMostUnits;
  const ThinnedCloud thinned = thinScan(view, kLeafShare * radius, extent.median, kReach * radius);
  const auto size = static_cast<std::size_t>(thinned.size());
  const std::size_t kept = std::min(size, kMostPoints);
  for (std::size_t i = 0; i < kept; ++i) { // in Morton order: evenly over the scan
    const auto column = static_cast<Eigen::Index>(i * size / kept);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double units = std::round(static_cast<double>(thinned.points(axis, column)) / result.step);
      result.coordinates.push_back(static_cast<std::int16_t>(std::clamp(units, -kMostUnits, kMostUnits)));
    }
  }
  return result;
}

ReportPictures
loadReportPictures(const std::vector<ResultRow>& rows,
                   const std::vector<io::DatasetFolder>& datasets,
                   std::size_t max_pairs)
{
  ReportPictures pictures;
  std::map<std::string, std::optional<std::size_t>> places; // of the clouds by path; nothing: cannot be read
  const auto load = [&](const std::string& path) {
    const auto known = places.find(path);
    if (known != places.end())
      return known->second;
    std::optional<std::size_t> place;
    try {
      pictures.clouds.push_back(makeReportCloud(io::loadCloud(path)));
      place = pictures.clouds.size() - 1;
    }
    catch (const io::IoError&) { // its rows say what is wrong with it
    }
    return places[path] = place;
  };
  for (const Candidate& candidate : rankPairs(rows, datasets)) {
    if (pictures.pairs.size() >= max_pairs)
      break;
    const io::ScanPair& pair = candidate.dataset->pairs[candidate.pair];
    const auto source = load(io::scanPath(candidate.dataset->path, pair.source));
    const auto target = load(io::scanPath(candidate.dataset->path, pair.target));
    if (source && target)
      pictures.pairs.push_back({candidate.dataset->name, candidate.pair, *source, *target, pair.T_target_source});
  }
  return pictures;
}

} // namespace apps
} // namespace pcl_ssfr
