// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/voxel_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>

namespace pcl_ssfr {

namespace {

/// Bound on voxel numbers, beyond which a double has no more whole steps.
const double kLargestVoxel = std::ldexp(1, std::numeric_limits<double>::digits);

struct Entry {
  std::array<std::int64_t, 3> voxel;
  double squared_distance; ///< to the centre of the voxel [m^2]
  Eigen::Index column;
};

} // namespace

std::vector<Eigen::Index>
samplePerVoxel(const Points3& points, double leaf)
{
  std::vector<Eigen::Index> columns;
  if (!(leaf > 0)) {
    columns.resize(static_cast<std::size_t>(points.cols()));
    std::iota(columns.begin(), columns.end(), Eigen::Index(0));
    return columns;
  }
  std::vector<Entry> entries(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Array3d voxel = (points.col(i).array() / leaf).floor().max(-kLargestVoxel).min(kLargestVoxel);
    Entry& entry = entries[static_cast<std::size_t>(i)];
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      entry.voxel[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(voxel[axis]);
    entry.squared_distance = (points.col(i).array() - (voxel + 0.5) * leaf).matrix().squaredNorm();
    entry.column = i;
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.voxel, a.squared_distance, a.column) < std::tie(b.voxel, b.squared_distance, b.column);
  });
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (i == 0 || entries[i].voxel != entries[i - 1].voxel)
      columns.push_back(entries[i].column);
  std::sort(columns.begin(), columns.end());
  return columns;
}

} // namespace pcl_ssfr
