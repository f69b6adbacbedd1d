// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/pair_tiles.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

std::string
toBytes(const PairTile& tile)
{
  // The length of a path is said: it may hold anything.
  std::string bytes = std::to_string(tile.paths.size()) + '\n';
  for (const auto& [scan, path] : tile.paths)
    bytes += std::to_string(scan) + ' ' + std::to_string(path.size()) + '\n' + path;
  return bytes + pcl_ssfr::toBytes(tile.tasks);
}

PairTile
tileFromBytes(const std::string& bytes)
{
  PairTile tile;
  std::istringstream in(bytes);
  std::size_t count = 0;
  in >> count;
  in.get();
  for (; in && count > 0; --count) {
    int scan = 0;
    std::size_t size = 0;
    in >> scan >> size;
    in.get();
    if (!in || size > bytes.size())
      break;
    std::string& path = tile.paths[scan];
    path.resize(size);
    in.read(path.data(), static_cast<std::streamsize>(size));
  }
  if (!in || count > 0)
    throw std::runtime_error("a message between ranks is damaged, or of another version");
  tile.tasks = tasksFromBytes(bytes.substr(static_cast<std::size_t>(in.tellg())));
  return tile;
}

PairTiles::PairTiles(const std::vector<PairTask>& tasks,
                     const std::vector<std::string>& paths,
                     int ranks,
                     const DealConfig& config)
    : paths_(paths), config_(config)
{
  const double pairs_of_tile = static_cast<double>(tasks.size()) / (config.tiles_per_rank * ranks);
  side_ = std::clamp(static_cast<int>(std::sqrt(pairs_of_tile)), 1, config.largest_side);
  std::map<std::pair<int, int>, std::vector<PairTask>> tiles;
  for (const PairTask& task : tasks)
    tiles[{task.source / side_, task.target / side_}].push_back(task);
  for (auto& [place, pairs] : tiles)
    tiles_.push_back({place.first, place.second, std::move(pairs)});
}

PairTile
PairTiles::next(int rank)
{
  std::list<int>& kept = kept_[rank];
  const auto has = [&](int run) { return std::find(kept.begin(), kept.end(), run) != kept.end() ? 1 : 0; };
  auto best = tiles_.begin();
  int most = -1;
  std::size_t looked_at = 0;
  for (auto tile = tiles_.begin(); tile != tiles_.end() && looked_at < config_.looked_at && most < 2;
       ++tile, ++looked_at)
    if (const int shared = has(tile->row) + has(tile->column); shared > most) {
      most = shared;
      best = tile;
    }
  for (const int run : {best->column, best->row}) {
    kept.remove(run);
    kept.push_front(run);
  }
  kept.resize(std::min(kept.size(), std::max<std::size_t>(2, config_.kept_scans / static_cast<std::size_t>(side_))));
  PairTile tile;
  tile.tasks = std::move(best->tasks);
  tiles_.erase(best);
  for (const PairTask& task : tile.tasks)
    for (const int scan : {task.source, task.target})
      tile.paths.emplace(scan, paths_[static_cast<std::size_t>(scan)]);
  return tile;
}

} // namespace apps
} // namespace pcl_ssfr
