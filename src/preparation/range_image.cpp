// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/range_image.h"

#include "common/angles.h"
#include "common/vector_clones.h"
#include "preparation/sight_block.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace pcl_ssfr {

namespace {

/// \p count of \p points from column \p first on.
PCL_SSFR_VECTOR_CLONES void
lookAt(const Eigen::Matrix3Xf& points,
       std::size_t first,
       std::size_t count,
       const Eigen::Vector3f& place,
       const DirectionGrid& grid,
       SightBlock& block)
{
  const float* const coordinates = points.data() + 3 * first;
  block.look(std::array{coordinates, coordinates + 1, coordinates + 2}, 3, count, place, grid);
}

} // namespace

DirectionGrid::DirectionGrid(double cell)
    : resolution_(std::max(1, static_cast<int>(std::ceil(90 * kDegree / cell)))),
      half_(0.5f * static_cast<float>(resolution_))
{}

std::vector<DepthSpan>
depthSpans(const Eigen::Matrix3Xf& points,
           const Eigen::Vector3f& viewpoint,
           const DirectionGrid& grid,
           const Deadline& deadline)
{
  const auto n = static_cast<std::size_t>(points.cols());
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  std::vector<DepthSpan> spans(grid.size(), DepthSpan{kNothing, 0});
  SightBlock block;
  for (std::size_t first = 0; first < n; first += SightBlock::kSize) {
    if (first % kPointsPerLook == 0 && deadline.hasPassed())
      break;
    const std::size_t count = std::min(SightBlock::kSize, n - first);
    lookAt(points, first, count, viewpoint, grid, block);
    for (std::size_t i = 0; i < count; ++i) {
      const float range = block.range[i];
      if (!(range > 0 && range < kNothing))
        continue;
      DepthSpan& span = spans[static_cast<std::size_t>(block.cells[i])];
      span.nearest = std::min(span.nearest, range);
      span.farthest = std::max(span.farthest, range);
    }
  }
  for (DepthSpan& span : spans)
    span.nearest = span.farthest > 0 ? span.nearest : 0;
  return spans;
}

RangeImage::RangeImage(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell)
    : grid_(cell), viewpoint_(viewpoint)
{
  nearest_.reserve(grid_.size());
  farthest_.reserve(grid_.size());
  for (const DepthSpan& span : depthSpans(points, viewpoint, grid_)) {
    nearest_.push_back(span.nearest);
    farthest_.push_back(span.farthest);
  }
  findFreeRanges();
}

void
RangeImage::findFreeRanges()
{
  free_.assign(nearest_.size(), 0.f);
  const int resolution = grid_.resolution();
  for (int face = 0; face < 6; ++face)
    for (int row = 0; row < resolution; ++row)
      for (int column = 0; column < resolution; ++column) {
        const auto at = [&](int r, int c) {
          return static_cast<std::size_t>((face * resolution + r) * resolution + c);
        };
        const float own = nearest_[at(row, column)];
        if (own == 0)
          continue;
        float least = own;
        for (int r = std::max(0, row - 1); r <= std::min(resolution - 1, row + 1); ++r)
          for (int c = std::max(0, column - 1); c <= std::min(resolution - 1, column + 1); ++c)
            if (nearest_[at(r, c)] > 0)
              least = std::min(least, nearest_[at(r, c)]);
        free_[at(row, column)] = least;
      }
}

PCL_SSFR_VECTOR_CLONES void
RangeImage::findFree(
    const std::array<const float*, 3>& places, std::size_t count, float ratio, float margin, std::int32_t* free) const
{
  if (empty()) {
    std::fill(free, free + count, 0);
    return;
  }
  SightBlock block;
  for (std::size_t first = 0; first < count; first += SightBlock::kSize) {
    const std::size_t n = std::min(SightBlock::kSize, count - first);
    block.look(std::array{places[0] + first, places[1] + first, places[2] + first}, 1, n, viewpoint_, grid_);
    for (std::size_t i = 0; i < n; ++i) {
      const float reach = free_[static_cast<std::size_t>(block.cells[i])];
      free[first + i] = static_cast<int>(reach > 0) & static_cast<int>(block.range[i] < ratio * reach - margin);
    }
  }
}

} // namespace pcl_ssfr
