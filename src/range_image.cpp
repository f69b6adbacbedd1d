// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/range_image.h>

#include <algorithm>

namespace pcl_ssfr {

namespace {

constexpr float kTowardsNeighbour = 0.5f; // a surface within a cell comes as near as half-way to its neighbour
constexpr double kRightAngle = 1.5707963267948966;
constexpr double kViewpointCell = 0.01745; // [rad]
constexpr double kDepthRatio = 1.5;
constexpr double kDepthMargin = 0.3; // [m] at scale 1
constexpr double kDisplacement = 3;  // [m] at scale 1
constexpr double kMinSpread = 0.35;  // occupied directions, relative to those seen from the centroid
// Measured on 80 single scans (gain 1.46 and more, 1.9 in the median of the worst set) and on merged ones (up to 1.5).
constexpr double kCleanShare = 0.01;
constexpr double kMinMixedShare = 0.03;
constexpr double kMaxMixing = 0.95;
constexpr double kClearGain = 1.8;
constexpr double kWeakGain = 1.4;
constexpr double kMaxFineShareAtWeakGain = 0.08;

/// Ranges of the nearest and the farthest return of a cell [m]; zeros when there was none.
struct DepthSpan {
  float nearest = 0;
  float farthest = 0;
};

std::vector<DepthSpan>
depthSpans(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, const DirectionGrid& grid)
{
  std::vector<DepthSpan> spans(grid.size());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f d = points.col(i) - viewpoint;
    const float range = d.norm();
    if (!(range > 0 && std::isfinite(range)))
      continue;
    DepthSpan& span = spans[grid.cell(d)];
    if (span.nearest == 0 || range < span.nearest)
      span.nearest = range;
    span.farthest = std::max(span.farthest, range);
  }
  return spans;
}

/// Directions in which something is seen.
double
occupiedCells(const std::vector<DepthSpan>& spans)
{
  return static_cast<double>(
      std::count_if(spans.begin(), spans.end(), [](const DepthSpan& span) { return span.nearest > 0; }));
}

double
twoDepthShare(const std::vector<DepthSpan>& spans, double margin)
{
  std::size_t several = 0;
  std::size_t two_depths = 0;
  for (const DepthSpan& span : spans) {
    several += span.farthest > span.nearest;
    two_depths += span.farthest > kDepthRatio * span.nearest + margin;
  }
  return several ? static_cast<double>(two_depths) / static_cast<double>(several) : 0;
}

} // namespace

DirectionGrid::DirectionGrid(double cell)
    : resolution_(std::max(1, static_cast<int>(std::ceil(kRightAngle / cell)))),
      half_(0.5f * static_cast<float>(resolution_))
{}

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
        float least = own;
        if (least == 0)
          continue;
        for (int r = std::max(0, row - 1); r <= std::min(resolution - 1, row + 1); ++r)
          for (int c = std::max(0, column - 1); c <= std::min(resolution - 1, column + 1); ++c)
            if (nearest_[at(r, c)] > 0)
              least = std::min(least, own + kTowardsNeighbour * (nearest_[at(r, c)] - own));
        free_[at(row, column)] = least;
      }
}

double
twoDepthShare(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell, double margin)
{
  return twoDepthShare(depthSpans(points, viewpoint, DirectionGrid(cell)), margin);
}

bool
isPlausibleViewpoint(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double scale)
{
  if (points.cols() == 0)
    return false;
  const double margin = kDepthMargin * scale;
  // A sensor spreads its returns over the directions; from elsewhere, and more so from afar, they bunch.
  const Eigen::Vector3f centroid = points.cast<double>().rowwise().mean().cast<float>();
  const DirectionGrid grid(kViewpointCell);
  const std::vector<DepthSpan> spans = depthSpans(points, viewpoint, grid);
  if (occupiedCells(spans) < kMinSpread * occupiedCells(depthSpans(points, centroid, grid)))
    return false;

  const double here = twoDepthShare(spans, margin);
  if (here <= kCleanShare)
    return true;
  // In one scan two depths meet at the edges of things only, and fewer in finer cells; where scans were merged they
  // meet all over.
  const double finer = twoDepthShare(points, viewpoint, 0.5 * kViewpointCell, margin);
  if (here > kMinMixedShare && finer > kMaxMixing * here)
    return false;
  double elsewhere = 0;
  for (int k = 0; k < 6; ++k) {
    Eigen::Vector3f place = viewpoint;
    place[k / 2] += static_cast<float>((k % 2 ? 1 : -1) * kDisplacement * scale);
    elsewhere += twoDepthShare(points, place, kViewpointCell, margin) / 6;
  }
  const double gain = elsewhere / here;
  return gain >= kClearGain || (gain >= kWeakGain && finer < kMaxFineShareAtWeakGain);
}

} // namespace pcl_ssfr
