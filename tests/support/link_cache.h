// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_registration.h>
#include <pcl_ssfr/multiway/pair_linking.h>

#include <cstdint>
#include <map>
#include <utility>

namespace pcl_ssfr {
namespace testing {

/// Links a pair of scans once for all maps that are made of them with the same options for pairs and no guess.
class LinkCache {
public:
  /// The link of a pair of scans of \p registration.
  const PairLink&
  link(const MultiwayRegistration& registration, const PairTask& task, const MultiwayOptions& options)
  {
    const auto [entry, is_new] = links_.try_emplace({task.source_hash, task.target_hash});
    PairLink& link = entry->second;
    if (is_new)
      link = linkPair(task, registration.preparedScan(task.source), registration.preparedScan(task.target), options);
    link.source = task.source;
    link.target = task.target;
    return link;
  }

  /// Have \p registration, which this outlives, take its links from here.
  void
  serve(MultiwayRegistration& registration, const MultiwayOptions& options = MultiwayOptions())
  {
    registration.setLinker([this, &registration, options](const std::vector<PairTask>& tasks, const OnLink& on_link) {
      for (const PairTask& task : tasks)
        on_link(link(registration, task, options));
    });
  }

  void
  clear()
  {
    links_.clear();
  }

private:
  std::map<std::pair<std::uint64_t, std::uint64_t>, PairLink> links_; ///< by the hashes of source and target
};

} // namespace testing
} // namespace pcl_ssfr
