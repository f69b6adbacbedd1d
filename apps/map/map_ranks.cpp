// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_ranks.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr std::chrono::milliseconds kLook(50); // for a word of rank 0 while nothing was linked

/// Link a tile in threads of its own, and send what comes from this one: MPI is for one thread.
void
linkAndSend(TileLinker& linker, const PairTile& tile, const MpiRanks& ranks, const MpiRanks::Send& send)
{
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<PairLink> links;
  bool is_done = false;
  std::exception_ptr failure;
  std::atomic<bool> stop{false};
  std::thread work([&] {
    try {
      linker.link(
          tile,
          [&](const PairLink& link) {
            const std::lock_guard<std::mutex> lock(mutex);
            links.push_back(link);
            changed.notify_one();
          },
          stop);
    }
    catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(mutex);
    is_done = true;
    changed.notify_one();
  });
  for (bool goes_on = true; goes_on;) {
    std::vector<PairLink> found;
    {
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait_for(lock, kLook, [&] { return is_done || !links.empty(); });
      found.swap(links);
      goes_on = !is_done;
    }
    if (!found.empty() && !stop)
      send(toBytes(found));
    stop = stop || ranks.isStopped();
  }
  work.join();
  if (failure)
    std::rethrow_exception(failure);
}

} // namespace

void
dealPairs(MpiRanks& ranks,
          const std::vector<PairTask>& tasks,
          const std::vector<std::string>& paths,
          const OnLink& on_link)
{
  PairTiles tiles(tasks, paths, ranks.count() - 1);
  ranks.deal([&](int rank) { return tiles.empty() ? std::nullopt : std::optional(toBytes(tiles.next(rank))); },
             [&](const std::string& message) {
               for (const PairLink& link : linksFromBytes(message))
                 on_link(link);
             },
             [] {});
}

void
linkDealtPairs(MpiRanks& ranks, const MultiwayOptions& options, const TileLinker::Load& load)
{
  TileLinker linker(options, load);
  ranks.work([&](const std::string& task, const MpiRanks::Send& send) {
    linkAndSend(linker, tileFromBytes(task), ranks, send);
  });
}

} // namespace apps
} // namespace pcl_ssfr
