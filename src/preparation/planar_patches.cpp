// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/planar_patches.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace pcl_ssfr {

namespace {

CellMoments&
operator+=(CellMoments& moments, const CellMoments& other)
{
  moments.n += other.n;
  moments.sum += other.sum;
  moments.outer += other.outer;
  return moments;
}

struct Plane {
  Eigen::Vector3d mean;
  Eigen::Vector3d normal;
  Eigen::Vector3d major;      ///< direction of the largest extent
  Eigen::Vector3d deviations; ///< standard deviations, ascending [m]
};

Plane
fitPlane(const CellMoments& moments)
{
  Plane plane;
  plane.mean = moments.sum / moments.n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.outer / moments.n - plane.mean * plane.mean.transpose());
  plane.normal = solver.eigenvectors().col(0).normalized();
  plane.major = solver.eigenvectors().col(2).normalized();
  plane.deviations = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  return plane;
}

/// Recursive subdivision over ranges of fine cells.
class PatchExtractor {
public:
  PatchExtractor(const ThinnedCloud& cloud,
                 const std::vector<FineCell>& cells,
                 const Eigen::Vector3d* viewpoint,
                 double thickness,
                 const PatchConfig& config)
      : cloud_(cloud), cells_(cells), viewpoint_(viewpoint), thickness_(thickness), config_(config)
  {}

  PlanarPatches
  run()
  {
    const int levels = config_.coarsest_level - config_.finest_level;
    forEachCell(0, cells_.size(), levels, [&](std::size_t b, std::size_t e) { subdivide(b, e, levels); });
    return pack();
  }

private:
  /// Call \p visit(begin, end) for every cell \p level levels above the finest within [begin, end).
  template <typename Visit>
  void
  forEachCell(std::size_t begin, std::size_t end, int level, const Visit& visit) const
  {
    const int shift = 3 * level;
    while (begin < end) {
      std::size_t next = begin + 1;
      while (next < end && (cells_[next].code >> shift) == (cells_[begin].code >> shift))
        ++next;
      visit(begin, next);
      begin = next;
    }
  }

  std::uint32_t
  endPoint(std::size_t cell_end) const
  {
    return cell_end < cells_.size() ? cells_[cell_end].first : static_cast<std::uint32_t>(cloud_.size());
  }

  void
  subdivide(std::size_t begin, std::size_t end, int level)
  {
    CellMoments total;
    for (std::size_t c = begin; c < end; ++c)
      total += cells_[c].moments;
    const std::uint32_t first = cells_[begin].first;
    const std::uint32_t count = endPoint(end) - first;
    if (count >= static_cast<std::uint32_t>(config_.min_points)) {
      const Plane plane = fitPlane(total);
      if (isPatch(plane)) {
        planes_.push_back(plane);
        patches_.first_point.push_back(first);
        patches_.counts.push_back(count);
        return;
      }
    }
    if (level == 0 || count < static_cast<std::uint32_t>(config_.min_points)) {
      for (std::uint32_t i = first; i < first + count; ++i)
        patches_.clutter.push_back(i);
      return;
    }
    forEachCell(begin, end, level - 1, [&](std::size_t b, std::size_t e) { subdivide(b, e, level - 1); });
  }

  bool
  isPatch(const Plane& plane) const
  {
    const double range = viewpoint_ ? (plane.mean - *viewpoint_).norm() : plane.mean.norm();
    const double bound = thickness_ + config_.range_noise * range;
    // Of variances of floats: points that spread less across are a line, which has no normal.
    const double rounding = std::sqrt(static_cast<double>(std::numeric_limits<float>::epsilon()));
    return plane.deviations[0] <= bound && plane.deviations[0] < config_.max_flatness * plane.deviations[1] &&
           plane.deviations[1] > rounding * plane.deviations[2];
  }

  /// The side of the plane that was seen, +1 or -1; 0 when nothing determines it.
  double
  facing(const Plane& plane, std::size_t patch) const
  {
    if (viewpoint_)
      return (*viewpoint_ - plane.mean).dot(plane.normal) >= 0 ? 1 : -1;
    if (cloud_.normals.cols() > 0) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero(); // of the normals of the points before thinning
      double points = 0;
      const std::uint32_t first = patches_.first_point[patch], end = first + patches_.counts[patch];
      for (std::uint32_t i = first; i < end; ++i) {
        sum += cloud_.normals.col(i);
        points += cloud_.counts[i];
      }
      const double along = sum.cast<double>().dot(plane.normal);
      if (std::abs(along) > 0.5 * points)
        return along > 0 ? 1 : -1;
    }
    return 0;
  }

  PlanarPatches
  pack()
  {
    const auto n = static_cast<Eigen::Index>(planes_.size());
    OrientedSamples& samples = patches_.samples;
    samples.points.resize(3, n);
    samples.normals.resize(3, n);
    samples.weights.resize(n);
    samples.extents.resize(n);
    samples.facing.resize(n);
    patches_.majors.resize(3, n);
    patches_.half_minors.resize(n);
    patches_.thickness.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto u = static_cast<std::size_t>(i);
      const Plane& plane = planes_[u];
      const double side = facing(plane, u);
      samples.oriented = samples.oriented && side != 0;
      samples.points.col(i) = plane.mean;
      samples.normals.col(i) = side < 0 ? Eigen::Vector3d(-plane.normal) : plane.normal;
      // A uniformly covered rectangle of sides a, b has variances a^2/12, b^2/12.
      samples.weights[i] = 12 * plane.deviations[1] * plane.deviations[2];
      samples.extents[i] = kHalfWidth * plane.deviations[2];
      patches_.half_minors[i] = kHalfWidth * plane.deviations[1];
      patches_.majors.col(i) = plane.major;
      patches_.thickness[i] = plane.deviations[0];
      samples.facing[i] = viewpoint_ ? std::abs((plane.mean - *viewpoint_).normalized().dot(plane.normal)) : 1;
    }
    return std::move(patches_);
  }

  const ThinnedCloud& cloud_;
  const std::vector<FineCell>& cells_;
  const Eigen::Vector3d* viewpoint_;
  double thickness_;
  const PatchConfig& config_;
  std::vector<Plane> planes_;
  PlanarPatches patches_;
};

} // namespace

std::vector<FineCell>
accumulateFineCells(const ThinnedCloud& cloud, int level)
{
  const int shift = 3 * level;
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.codes.size(); ++i)
    count += static_cast<std::size_t>(i == 0 || (cloud.codes[i] >> shift) != (cloud.codes[i - 1] >> shift));
  std::vector<FineCell> cells;
  cells.reserve(count);
  for (Eigen::Index i = 0; i < cloud.size(); ++i) {
    const std::uint64_t code = cloud.codes[static_cast<std::size_t>(i)] >> shift;
    if (cells.empty() || cells.back().code != code)
      cells.push_back({code, static_cast<std::uint32_t>(i), {}});
    CellMoments& m = cells.back().moments;
    const Eigen::Vector3d p = cloud.points.col(i).cast<double>();
    m.n += 1;
    m.sum += p;
    m.outer.noalias() += p * p.transpose();
  }
  return cells;
}

PlanarPatches
extractPatches(const ThinnedCloud& cloud,
               const std::vector<FineCell>& cells,
               const Eigen::Vector3d* viewpoint,
               double thickness,
               const PatchConfig& config)
{
  return PatchExtractor(cloud, cells, viewpoint, thickness, config).run();
}

PlanarPatches
extractPatches(const ThinnedCloud& cloud, const Eigen::Vector3d* viewpoint, double thickness, const PatchConfig& config)
{
  return extractPatches(cloud, accumulateFineCells(cloud, config.finest_level), viewpoint, thickness, config);
}

PlanarPatches
selectPatches(const PlanarPatches& patches, const std::vector<Eigen::Index>& indices)
{
  const auto n = static_cast<Eigen::Index>(indices.size());
  PlanarPatches some;
  some.samples.oriented = patches.samples.oriented;
  some.samples.points.resize(3, n);
  some.samples.normals.resize(3, n);
  some.samples.weights.resize(n);
  some.samples.extents.resize(n);
  some.samples.facing.resize(patches.samples.facing.size() > 0 ? n : 0);
  some.majors.resize(3, n);
  some.half_minors.resize(n);
  some.thickness.resize(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = indices[static_cast<std::size_t>(k)];
    if (i < 0 || i >= patches.size())
      throw std::out_of_range("selectPatches: there is no patch " + std::to_string(i));
    some.samples.points.col(k) = patches.samples.points.col(i);
    some.samples.normals.col(k) = patches.samples.normals.col(i);
    some.samples.weights[k] = patches.samples.weights[i];
    some.samples.extents[k] = patches.samples.extents[i];
    if (some.samples.facing.size() > 0)
      some.samples.facing[k] = patches.samples.facing[i];
    some.majors.col(k) = patches.majors.col(i);
    some.half_minors[k] = patches.half_minors[i];
    some.thickness[k] = patches.thickness[i];
    some.counts.push_back(patches.counts[static_cast<std::size_t>(i)]);
    some.first_point.push_back(patches.first_point[static_cast<std::size_t>(i)]);
  }
  return some;
}

} // namespace pcl_ssfr
