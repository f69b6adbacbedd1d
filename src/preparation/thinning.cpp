// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/thinning.h"

#include "common/parallel.h"
#include "common/types.h"
#include "common/vector_clones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr double kHalfRange = 1 << (kMortonBits - 1); // voxels on each side of the origin
constexpr std::size_t kExtentSamples = 20000;         // points looked at for the percentile
constexpr std::size_t kPointsPerThread = 65536;       // for fewer it does not pay to start one more

// Voxels are sorted cell by cell: what happens within a cell stays in the cache.
constexpr int kCellBits = 4; // of the edge of a cell, in voxels
constexpr unsigned kCellMask = (1U << kCellBits) - 1;
constexpr std::size_t kCellVoxels = std::size_t{1} << (3 * kCellBits);
constexpr int kCellCodeBits = kMortonBits - kCellBits;

/// Spread the low 21 bits of \p v so that two zero bits follow each of them.
constexpr std::uint64_t
spreadBits(std::uint64_t v)
{
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

/// spreadBits() of a place within a cell.
constexpr std::array<std::uint16_t, kCellMask + 1>
makeSpreadTable()
{
  std::array<std::uint16_t, kCellMask + 1> table{};
  for (std::size_t v = 0; v < table.size(); ++v)
    table[v] = static_cast<std::uint16_t>(spreadBits(v));
  return table;
}
constexpr std::array<std::uint16_t, kCellMask + 1> kSpread = makeSpreadTable();

/// Number of the voxel of coordinate \p x [voxels] along an axis; |x| < kHalfRange.
unsigned
voxelOf(double x)
{
  const auto truncated = static_cast<int>(x);
  return static_cast<unsigned>(truncated - (x < truncated ? 1 : 0) + static_cast<int>(kHalfRange));
}

/// The points of a cell: a chain through PointChains::next, in the order of the scan.
struct CellChain {
  std::uint64_t code; ///< Morton code of the cell
  std::uint32_t first;
  std::uint32_t last;
};

/// For each point that is used: the next one in its cell, and the Morton code of its voxel within the cell.
struct PointChains {
  explicit PointChains(std::size_t size)
      : next(new std::uint32_t[size]),
        voxel(new std::uint16_t[size]) // not filled: pages that are not used cost nothing
  {}

  std::unique_ptr<std::uint32_t[]> next;
  std::unique_ptr<std::uint16_t[]> voxel;
};

/// Chains by cell, found by open addressing.
class CellTable {
public:
  /// Number of the chain of the cell (\p x, \p y, \p z); a new one begins at \p point.
  std::uint32_t
  chainOf(std::uint64_t x, std::uint64_t y, std::uint64_t z, std::uint32_t point)
  {
    if (2 * chains_.size() >= slots_.size())
      grow();
    const std::uint64_t code = spreadBits(x) | spreadBits(y) << 1 | spreadBits(z) << 2;
    std::size_t slot = slotOf(code);
    while (slots_[slot] != kEmpty && chains_[slots_[slot]].code != code)
      slot = (slot + 1) & (slots_.size() - 1);
    if (slots_[slot] == kEmpty) {
      slots_[slot] = static_cast<std::uint32_t>(chains_.size());
      chains_.push_back({code, point, point});
    }
    return slots_[slot];
  }
  std::vector<CellChain>&
  chains()
  {
    return chains_;
  }

private:
  std::size_t
  slotOf(std::uint64_t code) const
  {
    return static_cast<std::size_t>((code * 0x9e3779b97f4a7c15) >> shift_);
  }
  void
  grow()
  {
    --shift_;
    slots_.assign(std::size_t{1} << (64 - shift_), kEmpty);
    for (std::uint32_t i = 0; i < chains_.size(); ++i) {
      std::size_t slot = slotOf(chains_[i].code);
      while (slots_[slot] != kEmpty)
        slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = i;
    }
  }

  static constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();
  int shift_ = 54;
  std::vector<std::uint32_t> slots_;
  std::vector<CellChain> chains_;
};

/// Thins one scan.
class Thinner {
public:
  Thinner(const ScanView& scan,
          double leaf,
          const Eigen::Vector3d& origin,
          double max_distance,
          unsigned threads,
          const Deadline& deadline)
      : scan_(scan), origin_(origin),
        limit_(std::min(max_distance > 0 ? max_distance : std::numeric_limits<double>::max(), thinningReach(leaf))),
        inverse_leaf_(1.0 / std::max(leaf, std::numeric_limits<double>::min())), // finite
        threads_(static_cast<int>(
            std::clamp<std::size_t>(scan.count() / kPointsPerThread, 1, std::max<std::size_t>(threads, 1)))),
        deadline_(deadline), chains_(scan.count())
  {
    thinned_.leaf = leaf;
    thinned_.origin = origin;
  }

  ThinnedCloud
  run()
  {
    chainPoints();
    countVoxels();
    if (deadline_.hasPassed()) // then what follows may not be whole
      return {};
    fillVoxels();
    return deadline_.hasPassed() ? ThinnedCloud() : std::move(thinned_);
  }

private:
  /// Sums over the points of a voxel.
  struct Voxel {
    Eigen::Vector3d sum;
    std::uint32_t count;
  };

  /// The voxels of a cell that hold points, to be listed in the order of their codes.
  class Occupancy {
  public:
    /// Whether \p voxel was not yet there.
    bool
    add(std::size_t voxel)
    {
      std::uint64_t& word = words_[voxel / 64];
      const std::uint64_t bit = std::uint64_t{1} << (voxel % 64);
      const bool is_new = (word & bit) == 0;
      word |= bit;
      used_ |= std::uint64_t{1} << (voxel / 64);
      return is_new;
    }
    /// Call \p visit(voxel) in ascending order, and forget them all.
    template <typename Visit>
    void
    drain(const Visit& visit)
    {
      for (; used_ != 0; used_ &= used_ - 1) {
        const auto w = static_cast<std::size_t>(__builtin_ctzll(used_));
        for (std::uint64_t word = words_[w]; word != 0; word &= word - 1)
          visit(64 * w + static_cast<std::size_t>(__builtin_ctzll(word)));
        words_[w] = 0;
      }
    }

  private:
    static_assert(kCellVoxels == 64 * 64, "one bit of used_ for each word");
    std::array<std::uint64_t, 64> words_{};
    std::uint64_t used_ = 0;
  };

  /// Sort the points into cells: each thread a part of the scan, then the parts of a cell are joined.
  void
  chainPoints()
  {
    const std::size_t n = scan_.count();
    const auto parts = static_cast<std::size_t>(threads_);
    std::vector<CellTable> tables(parts);
    forEachInParallel(threads_, 1, threads_, [&](std::int64_t i) {
      const auto part = static_cast<std::size_t>(i);
      chainPoints(part * n / parts, (part + 1) * n / parts, tables[part]);
    });
    for (CellTable& table : tables) {
      cells_.insert(cells_.end(), table.chains().begin(), table.chains().end());
      table = CellTable();
    }
    std::sort(cells_.begin(), cells_.end(), [](const CellChain& a, const CellChain& b) {
      return std::tie(a.code, a.first) < std::tie(b.code, b.first);
    });
    std::size_t joined = 0;
    for (const CellChain& cell : cells_) {
      if (joined > 0 && cells_[joined - 1].code == cell.code) {
        chains_.next[cells_[joined - 1].last] = cell.first;
        cells_[joined - 1].last = cell.last;
      }
      else {
        cells_[joined++] = cell;
      }
    }
    cells_.resize(joined);
  }

  void
  chainPoints(std::size_t begin, std::size_t end, CellTable& table)
  {
    std::uint64_t cell_of_last = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t chain = 0;
    while (begin < end && !deadline_.hasPassed()) {
      const std::size_t pause = std::min(end, begin + kPointsPerLook);
      for (; begin < pause; ++begin) {
        const Eigen::Vector3d p = scan_.point(begin).cast<double>() - origin_;
        if (!scan_.isReturn(begin) || !(p.array().abs() < limit_).all())
          continue;
        const unsigned x = voxelOf(p.x() * inverse_leaf_);
        const unsigned y = voxelOf(p.y() * inverse_leaf_);
        const unsigned z = voxelOf(p.z() * inverse_leaf_);
        chains_.voxel[begin] = static_cast<std::uint16_t>(kSpread[x & kCellMask] | kSpread[y & kCellMask] << 1 |
                                                          kSpread[z & kCellMask] << 2);
        const std::uint64_t cell = std::uint64_t{x >> kCellBits} | std::uint64_t{y >> kCellBits} << kCellCodeBits |
                                   std::uint64_t{z >> kCellBits} << (2 * kCellCodeBits);
        const auto point = static_cast<std::uint32_t>(begin);
        if (cell != cell_of_last) {
          cell_of_last = cell;
          chain = table.chainOf(x >> kCellBits, y >> kCellBits, z >> kCellBits, point);
        }
        std::uint32_t& last = table.chains()[chain].last;
        chains_.next[last] = point; // of a new chain: overwritten by the next point, or not read
        last = point;
      }
    }
  }

  /// Call \p visit(workspace, cell) for every cell, in parallel, each part of them with a workspace of its own.
  template <typename Workspace, typename Visit>
  void
  forEachCell(const Workspace& empty, const Visit& visit) const
  {
    const auto parts = static_cast<std::size_t>(threads_ > 1 ? kTasksPerThread * threads_ : 1);
    forEachInParallel(static_cast<std::int64_t>(parts), 1, threads_, [&](std::int64_t i) {
      const auto part = static_cast<std::size_t>(i);
      const std::size_t end = (part + 1) * cells_.size() / parts;
      Workspace workspace = empty;
      for (std::size_t cell = part * cells_.size() / parts; cell < end; ++cell) {
        if (deadline_.hasPassed())
          return;
        visit(workspace, cell);
      }
    });
  }

  /// Call \p visit(point) for the points of a cell in the order of the scan.
  template <typename Visit>
  void
  forEachPoint(const CellChain& cell, const Visit& visit) const
  {
    for (std::uint32_t point = cell.first; point != cell.last; point = chains_.next[point])
      visit(point);
    visit(cell.last);
  }

  /// Find where in the result each cell begins.
  void
  countVoxels()
  {
    starts_.assign(cells_.size() + 1, 0);
    forEachCell(Occupancy(), [this](Occupancy& occupancy, std::size_t cell) {
      std::size_t count = 0;
      forEachPoint(cells_[cell], [&](std::uint32_t point) { count += occupancy.add(chains_.voxel[point]); });
      occupancy.drain([](std::size_t) {});
      starts_[cell + 1] = count;
    });
    for (std::size_t cell = 0; cell < cells_.size(); ++cell)
      starts_[cell + 1] += starts_[cell];
  }

  void
  fillVoxels()
  {
    const std::size_t size = starts_.back();
    thinned_.points.resize(3, static_cast<Eigen::Index>(size));
    if (scan_.normals)
      thinned_.normals.resize(3, static_cast<Eigen::Index>(size));
    thinned_.codes.resize(size);
    thinned_.counts.resize(size);
    Sums empty;
    empty.voxels.resize(kCellVoxels);
    if (scan_.normals)
      empty.normals.resize(kCellVoxels);
    forEachCell(empty, [this](Sums& sums, std::size_t cell) { fillVoxels(sums, cell); });
  }

  struct Sums {
    Occupancy occupancy;
    std::vector<Voxel> voxels;
    std::vector<Eigen::Vector3f> normals; ///< empty when none were given
  };

  void
  fillVoxels(Sums& sums, std::size_t cell)
  {
    forEachPoint(cells_[cell], [&](std::uint32_t point) {
      const std::size_t v = chains_.voxel[point];
      const bool is_new = sums.occupancy.add(v);
      Voxel& voxel = sums.voxels[v];
      if (is_new)
        voxel = {Eigen::Vector3d::Zero(), 0};
      voxel.sum += scan_.point(point).cast<double>();
      ++voxel.count;
      if (!sums.normals.empty()) {
        if (is_new)
          sums.normals[v].setZero();
        const Eigen::Vector3f normal = scan_.normal(point);
        if (std::abs(normal.squaredNorm() - 1.f) < 1e-2f) // false for NaN
          sums.normals[v] += normal;
      }
    });
    std::size_t place = starts_[cell];
    sums.occupancy.drain([&](std::size_t v) {
      const Voxel& voxel = sums.voxels[v];
      const auto column = static_cast<Eigen::Index>(place);
      const Eigen::Vector3d mean = voxel.sum / static_cast<double>(voxel.count);
      thinned_.points.col(column) = (mean - origin_).cast<float>();
      if (!sums.normals.empty())
        thinned_.normals.col(column) = sums.normals[v];
      thinned_.codes[place] = cells_[cell].code << (3 * kCellBits) | v;
      thinned_.counts[place] = voxel.count;
      ++place;
    });
  }

  const ScanView& scan_;
  Eigen::Vector3d origin_;
  double limit_;        ///< of the coordinates, about the origin [m]
  double inverse_leaf_; ///< [1/m]
  int threads_;
  const Deadline& deadline_;
  PointChains chains_;
  std::vector<CellChain> cells_;    ///< ascending by code
  std::vector<std::size_t> starts_; ///< first voxel of each cell in the result, and the end
  ThinnedCloud thinned_;
};

} // namespace

ScanExtent
measureExtent(const ScanView& scan, const Deadline& deadline)
{
  ScanExtent extent;
  const std::size_t n = scan.count();
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = Eigen::Vector3f::Constant(std::numeric_limits<float>::lowest());
  for (std::size_t i = 0; i < n; ++i) {
    if (i % kPointsPerLook == 0 && deadline.hasPassed())
      return extent;
    if (!scan.isReturn(i))
      continue;
    const Eigen::Vector3f p = scan.point(i);
    ++extent.returns;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (extent.returns == 0)
    return extent;
  extent.min = low.cast<double>();
  extent.max = high.cast<double>();

  // A few far returns (drivers write the largest float for "none") move the mean anywhere, but not the median.
  const std::size_t step = std::max<std::size_t>(1, extent.returns / kExtentSamples);
  std::vector<Eigen::Vector3d> sample;
  sample.reserve(extent.returns / step + 1);
  if (extent.returns == n) {
    for (std::size_t i = 0; i < n; i += step)
      sample.emplace_back(scan.point(i).cast<double>());
  }
  else {
    for (std::size_t i = 0, number = 0; i < n; ++i)
      if (scan.isReturn(i) && number++ % step == 0)
        sample.emplace_back(scan.point(i).cast<double>());
  }
  std::vector<double> values(sample.size());
  const auto quantile = [&values](double q) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(sample.begin(), sample.end(), values.begin(), [axis](const Eigen::Vector3d& p) { return p[axis]; });
    extent.median[axis] = quantile(0.5);
  }
  std::transform(sample.begin(), sample.end(), values.begin(), [&extent](const Eigen::Vector3d& p) {
    return (p - extent.median).norm();
  });
  extent.radius = quantile(0.9);
  return extent;
}

double
thinningReach(double leaf)
{
  return std::min<double>((kHalfRange - 1) * leaf, std::numeric_limits<float>::max());
}

ThinnedCloud
thinScan(const ScanView& scan,
         double leaf,
         const Eigen::Vector3d& origin,
         double max_distance,
         unsigned threads,
         const Deadline& deadline)
{
  return Thinner(scan, leaf, origin, max_distance, threads, deadline).run();
}

} // namespace pcl_ssfr
