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

/// Directions in which something is seen.
std::size_t
occupiedCells(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint)
{
  const RangeImage image(points, viewpoint, kViewpointCell);
  std::size_t occupied = 0;
  for (std::size_t c = 0; c < image.size(); ++c)
    occupied += image.nearest(c) > 0;
  return occupied;
}

} // namespace

RangeImage::RangeImage(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell)
    : resolution_(std::max(1, static_cast<int>(std::ceil(kRightAngle / cell)))),
      half_(0.5f * static_cast<float>(resolution_)), viewpoint_(viewpoint)
{
  const auto cells = static_cast<std::size_t>(6 * resolution_ * resolution_);
  nearest_.assign(cells, 0.f);
  farthest_.assign(cells, 0.f);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f d = points.col(i) - viewpoint;
    const float range = d.norm();
    if (!(range > 0 && std::isfinite(range)))
      continue;
    const std::size_t c = this->cell(d);
    if (nearest_[c] == 0 || range < nearest_[c])
      nearest_[c] = range;
    farthest_[c] = std::max(farthest_[c], range);
  }
  findFreeRanges();
}

void
RangeImage::findFreeRanges()
{
  free_.assign(nearest_.size(), 0.f);
  for (int face = 0; face < 6; ++face)
    for (int row = 0; row < resolution_; ++row)
      for (int column = 0; column < resolution_; ++column) {
        const auto at = [&](int r, int c) {
          return static_cast<std::size_t>((face * resolution_ + r) * resolution_ + c);
        };
        const float own = nearest_[at(row, column)];
        float least = own;
        if (least == 0)
          continue;
        for (int r = std::max(0, row - 1); r <= std::min(resolution_ - 1, row + 1); ++r)
          for (int c = std::max(0, column - 1); c <= std::min(resolution_ - 1, column + 1); ++c)
            if (nearest_[at(r, c)] > 0)
              least = std::min(least, own + kTowardsNeighbour * (nearest_[at(r, c)] - own));
        free_[at(row, column)] = least;
      }
}

double
twoDepthShare(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell, double margin)
{
  const RangeImage image(points, viewpoint, cell);
  std::size_t several = 0;
  std::size_t two_depths = 0;
  for (std::size_t c = 0; c < image.size(); ++c) {
    several += image.farthest(c) > image.nearest(c);
    two_depths += image.farthest(c) > kDepthRatio * image.nearest(c) + margin;
  }
  return several ? static_cast<double>(two_depths) / static_cast<double>(several) : 0;
}

bool
isPlausibleViewpoint(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double scale)
{
  if (points.cols() == 0)
    return false;
  const double margin = kDepthMargin * scale;
  // A sensor spreads its returns over the directions; from elsewhere, and more so from afar, they bunch.
  const Eigen::Vector3f centroid = points.cast<double>().rowwise().mean().cast<float>();
  if (static_cast<double>(occupiedCells(points, viewpoint)) <
      kMinSpread * static_cast<double>(occupiedCells(points, centroid)))
    return false;

  const double here = twoDepthShare(points, viewpoint, kViewpointCell, margin);
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
