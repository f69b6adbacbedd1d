// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/tile_linker.h>

#include "common/parallel.h"

#include <apps/io/io_error.h>

#include <algorithm>
#include <mutex>
#include <utility>

namespace pcl_ssfr {
namespace apps {

TileLinker::TileLinker(const MultiwayOptions& options, Load load, const DealConfig& config)
    : options_(options), load_(std::move(load)), config_(config)
{}

void
TileLinker::link(const PairTile& tile, const OnLink& on_link, const std::atomic<bool>& stop)
{
  prepare(tile, stop);
  if (stop)
    return;
  for (const PairTask& task : tile.tasks)
    for (const auto& [scan, hash] : {std::pair(task.source, task.source_hash), {task.target, task.target_hash}})
      if (find(tile, scan).hash != hash)
        throw io::IoError(tile.paths.at(scan) + ": holds other points here than where the map is made");
  std::mutex mutex;
  forEachInParallel(
      static_cast<std::int64_t>(tile.tasks.size()), 1, static_cast<int>(options_.threads), [&](std::int64_t index) {
        if (stop)
          return;
        const PairTask& task = tile.tasks[static_cast<std::size_t>(index)];
        const PairLink link =
            linkPair(task, find(tile, task.source).prepared, find(tile, task.target).prepared, options_);
        const std::lock_guard<std::mutex> lock(mutex);
        on_link(link);
      });
}

void
TileLinker::prepare(const PairTile& tile, const std::atomic<bool>& stop)
{
  ++tiles_;
  std::vector<std::pair<const std::string*, Scan>> missing;
  for (const auto& [scan, path] : tile.paths)
    if (const auto found = scans_.find(path); found != scans_.end())
      found->second.used = tiles_;
    else
      missing.emplace_back(&path, Scan());
  // Those that were not needed for longest make room.
  std::vector<std::pair<std::size_t, std::string>> unused;
  for (const auto& [path, scan] : scans_)
    if (scan.used != tiles_)
      unused.emplace_back(scan.used, path);
  std::sort(unused.begin(), unused.end());
  for (const auto& [used, path] : unused)
    if (scans_.size() + missing.size() > config_.kept_scans)
      scans_.erase(path);
  Options options = options_.registration;
  options.threads = 1;
  forEachInParallel(
      static_cast<std::int64_t>(missing.size()), 1, static_cast<int>(options_.threads), [&](std::int64_t index) {
        if (stop)
          return;
        auto& [path, scan] = missing[static_cast<std::size_t>(index)];
        const ScanSource source = load_(*path);
        scan.hash = hashOfScan(source.view);
        scan.prepared = prepareScan(source.view, options);
        scan.used = tiles_;
      });
  if (!stop)
    for (auto& [path, scan] : missing)
      scans_.emplace(*path, std::move(scan));
}

const TileLinker::Scan&
TileLinker::find(const PairTile& tile, int scan) const
{
  return scans_.at(tile.paths.at(scan));
}

} // namespace apps
} // namespace pcl_ssfr
