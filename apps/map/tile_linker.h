// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <apps/map/pair_tiles.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace pcl_ssfr {
namespace apps {

/** \brief Links tiles of pairs far from where the map is made: prepares the scans of a tile that it has not kept.
 *
 * No more prepared scans are in memory than are kept, or are in one tile; of scans that are read, as many as there are
 * threads.
 */
class TileLinker {
public:
  /// Reads a scan. \throw std::exception naming the file
  using Load = std::function<ScanSource(const std::string& path)>;

  /// \param[in] options those of the map, with the threads to use, > 0
  TileLinker(const MultiwayOptions& options, Load load, const DealConfig& config = {});

  /** \brief Link the pairs of a tile.
   * \param[in] on_link called from one thread at a time
   * \param[in] stop what is not begun when it is set is left out
   * \throw std::exception when a scan cannot be read, or holds other points than the tile was made for; each names the
   * file
   */
  void
  link(const PairTile& tile, const OnLink& on_link, const std::atomic<bool>& stop);

  /// Prepared scans in memory.
  std::size_t
  kept() const
  {
    return scans_.size();
  }

private:
  struct Scan {
    PreparedScan prepared;
    std::uint64_t hash = 0; ///< of its points
    std::size_t used = 0;   ///< number of the last tile that needed it
  };

  void
  prepare(const PairTile& tile, const std::atomic<bool>& stop);
  const Scan&
  find(const PairTile& tile, int scan) const;

  MultiwayOptions options_;
  Load load_;
  DealConfig config_;
  std::map<std::string, Scan> scans_; ///< by path
  std::size_t tiles_ = 0;
};

} // namespace apps
} // namespace pcl_ssfr
