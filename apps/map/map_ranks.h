// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/cluster/mpi_ranks.h>
#include <apps/map/tile_linker.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/** \brief Rank 0: let the other ranks link pairs.
 * \param[in] paths of all scans, by their numbers; every rank reads them there
 * \throw what \p on_link throws, std::runtime_error when a rank failed, with what it says
 */
void
dealPairs(MpiRanks& ranks,
          const std::vector<PairTask>& tasks,
          const std::vector<std::string>& paths,
          const OnLink& on_link);

/// The other ranks: link what is dealt, until the map is made.
void
linkDealtPairs(MpiRanks& ranks, const MultiwayOptions& options, const TileLinker::Load& load);

} // namespace apps
} // namespace pcl_ssfr
