// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/pair_linking.h>

#include <cstddef>
#include <list>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How the pairs of a job are dealt to ranks.
struct DealConfig {
  /// At the end ranks wait for the last tile, for half of one each in the mean: 6 % of the time with so many.
  double tiles_per_rank = 8;
  /// Side of a tile, scans: beyond, a scan is prepared for 32 pairs or more, which costs a hundredth of linking them.
  int largest_side = 32;
  std::size_t kept_scans = 128;   ///< prepared scans that a rank keeps: 1 to 2 MB each
  std::size_t looked_at = 10'000; ///< tiles, for the one that shares most scans with what a rank keeps
};

/// Pairs that are dealt as one piece: of two short runs of scans.
struct PairTile {
  std::map<int, std::string> paths; ///< of the scans in it, by their numbers
  std::vector<PairTask> tasks;
};

/// A tile as the bytes of a message.
std::string
toBytes(const PairTile& tile);
/// \throw std::runtime_error when these are not the bytes of a tile
PairTile
tileFromBytes(const std::string& bytes);

/** \brief The matrix of all pairs, cut into square tiles that are dealt one by one.
 *
 * A rank needs two sides of scans for a tile of side times side pairs; it gets tiles whose scans it has already, as far
 * as there are. Which rank gets which tile depends on who is free; what becomes of a pair does not.
 */
class PairTiles {
public:
  /// \param[in] paths of all scans, by their numbers
  /// \param[in] ranks that work, > 0; numbered from 1
  PairTiles(const std::vector<PairTask>& tasks,
            const std::vector<std::string>& paths,
            int ranks,
            const DealConfig& config = {});

  bool
  empty() const
  {
    return tiles_.empty();
  }
  /// A tile for a rank; must not be empty().
  PairTile
  next(int rank);

private:
  struct Tile {
    int row; ///< runs of scans, counted from 0
    int column;
    std::vector<PairTask> tasks;
  };

  const std::vector<std::string>& paths_;
  DealConfig config_;
  int side_ = 1;
  std::list<Tile> tiles_;
  std::map<int, std::list<int>> kept_; ///< runs that each rank has prepared, used last first
};

} // namespace apps
} // namespace pcl_ssfr
