// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/patch_index.h"

#include "common/vector_clones.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr float kRounding = 1e-5f; // of coordinates, generously

std::array<Eigen::Vector3f, kDirectionClasses>
makeClassCentres()
{
  std::array<Eigen::Vector3f, kDirectionClasses> centres;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) {
        Eigen::Vector3f d;
        d[axis] = face % 2 ? -1.f : 1.f;
        d[axis == 0 ? 1 : 0] = static_cast<float>(column - 1) * (2.f / 3.f);
        d[axis == 2 ? 1 : 2] = static_cast<float>(row - 1) * (2.f / 3.f);
        centres[static_cast<std::size_t>(9 * face + 3 * row + column)] = d.normalized();
      }
  }
  return centres;
}

} // namespace

int
directionClass(const Eigen::Vector3f& d)
{
  const Eigen::Array3f a = d.array().abs();
  int axis = a.y() > a.x() ? 1 : 0;
  axis = a.z() > a[axis] ? 2 : axis;
  const float scale = 1.5f / a[axis];
  // The order of the arguments makes NaN 0.
  const int column = static_cast<int>(std::max(0.f, std::min(d[axis == 0 ? 1 : 0] * scale + 1.5f, 2.f)));
  const int row = static_cast<int>(std::max(0.f, std::min(d[axis == 2 ? 1 : 2] * scale + 1.5f, 2.f)));
  return 9 * (2 * axis + (d[axis] < 0 ? 1 : 0)) + 3 * row + column;
}

std::uint64_t
directionClassesNear(const Eigen::Vector3f& d, double angle)
{
  static const std::array<Eigen::Vector3f, kDirectionClasses> centres = makeClassCentres();
  const auto min_cos = static_cast<float>(std::cos(angle));
  std::uint64_t bits = std::uint64_t{1} << directionClass(d);
  for (std::size_t c = 0; c < centres.size(); ++c)
    if (centres[c].dot(d) >= min_cos)
      bits |= std::uint64_t{1} << c;
  return bits;
}

template <typename Visit>
void
PatchIndex::rasterise(const Plane& plane, const Visit& visit) const
{
  const auto edge = static_cast<float>(voxel_);
  // Along the axes of the patch: how far the centre of a voxel may lie that holds a place within reach.
  const Eigen::Array4f most =
      plane.halves + (static_cast<float>(reach_) + 0.5f * edge * (plane.x.abs() + plane.y.abs() + plane.z.abs()));
  Eigen::Array3f half; // of the box around it
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Array4f& row = axis == 0 ? plane.x : axis == 1 ? plane.y : plane.z;
    half[axis] = (row.abs() * most).head<3>().sum();
  }
  const Eigen::Array3f centre = plane.column(3).array() - origin_.array();
  const Eigen::Array3f first = ((centre - half) * inverse_voxel_).floor().max(0.f);
  const Eigen::Array3f last = ((centre + half) * inverse_voxel_).floor().min((dims_.array() - 1).cast<float>());
  if (!(first <= last).all()) // also where float has no numbers for it
    return;
  const Eigen::Array3i low = first.cast<int>();
  const Eigen::Array3i high = last.cast<int>();
  // Along a row of voxels, each axis of the patch bounds an interval of them.
  const Eigen::Array4f inverse_slope = (edge * plane.x).inverse();
  const float x = 0.5f * edge - centre.x();
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y) {
      const Eigen::Array4f start = x * plane.x + ((static_cast<float>(y) + 0.5f) * edge - centre.y()) * plane.y +
                                   ((static_cast<float>(z) + 0.5f) * edge - centre.z()) * plane.z;
      const Eigen::Array4f one = (-most - start) * inverse_slope;
      const Eigen::Array4f other = (most - start) * inverse_slope;
      float from = first.x();
      float to = last.x();
      for (int k = 0; k < 3; ++k) {
        // Where an axis is across the row and its bound is met exactly there is no number, and no bound.
        const float lower = std::min(one[k], other[k]);
        const float upper = std::max(one[k], other[k]);
        from = lower > from ? lower : from;
        to = upper < to ? upper : to;
      }
      if (from <= to)
        visit(static_cast<int>(std::ceil(from)), static_cast<int>(std::floor(to)), y, z);
    }
}

PatchIndex::PatchIndex(const PlanarPatches& patches, double voxel, double reach, double facing, std::size_t max_voxels)
    : reach_(reach)
{
  if (patches.size() == 0)
    return;
  layOut(addPlanes(patches, std::max(voxel, reach)), voxel, max_voxels);
  fill(patches.samples.oriented, facing);
}

PatchIndex::Box
PatchIndex::addPlanes(const PlanarPatches& patches, double margin)
{
  planes_.resize(static_cast<std::size_t>(patches.size()));
  Box box;
  for (Eigen::Index i = 0; i < patches.size(); ++i) {
    Plane& plane = planes_[static_cast<std::size_t>(i)];
    Eigen::Matrix3f frame;
    frame.col(0) = patches.samples.normals.col(i).cast<float>();
    frame.col(1) = patches.majors.col(i).cast<float>();
    frame.col(2) = frame.col(0).cross(frame.col(1));
    const Eigen::Vector3f centroid = patches.samples.points.col(i).cast<float>();
    plane.x << frame.row(0).transpose(), centroid.x();
    plane.y << frame.row(1).transpose(), centroid.y();
    plane.z << frame.row(2).transpose(), centroid.z();
    plane.halves << 0.f, static_cast<float>(patches.samples.extents[i]), static_cast<float>(patches.half_minors[i]),
        1.f / static_cast<float>(std::max(patches.counts[static_cast<std::size_t>(i)], 1u));
    const Eigen::Array3d half = (frame.col(1).cwiseAbs().cast<double>() * patches.samples.extents[i] +
                                 frame.col(2).cwiseAbs().cast<double>() * patches.half_minors[i])
                                    .array() +
                                margin;
    box.low = box.low.min(patches.samples.points.col(i).array() - half);
    box.high = box.high.max(patches.samples.points.col(i).array() + half);
  }
  return box;
}

void
PatchIndex::layOut(const Box& box, double voxel, std::size_t max_voxels)
{
  const Eigen::Array3d size = box.high - box.low;
  voxel_ = voxel;
  while ((size / voxel_).ceil().max(1).prod() > static_cast<double>(max_voxels))
    voxel_ *= 1.1;
  inverse_voxel_ = static_cast<float>(1 / voxel_);
  origin_ = box.low.matrix().cast<float>();
  dims_ = (size / voxel_).ceil().max(1).cast<int>();

  block_dims_ = (dims_.array() + kBlockMask) / (1 << kBlockBits);
  blocks_.assign(static_cast<std::size_t>(block_dims_.x()) * static_cast<std::size_t>(block_dims_.y()) *
                     static_cast<std::size_t>(block_dims_.z()),
                 0);
}

void
PatchIndex::fill(bool oriented, double facing)
{
  // Voxels of all planes, in the order of the planes; blocks are numbered as they are met.
  std::vector<std::uint32_t> voxels;
  std::vector<std::size_t> ends;
  ends.reserve(planes_.size());
  std::uint32_t used = 1;
  for (const Plane& plane : planes_) {
    rasterise(plane, [&](int x_first, int x_last, int y, int z) {
      for (int x = x_first; x <= x_last; ++x) {
        std::uint32_t& block = blocks_[static_cast<std::size_t>(blockOf(x, y, z))];
        if (block == 0)
          block = used++;
        voxels.push_back(static_cast<std::uint32_t>(joined(block, voxelInBlock(x, y, z))));
      }
    });
    ends.push_back(voxels.size());
  }
  const std::size_t size = static_cast<std::size_t>(used) << (3 * kBlockBits);
  masks_.assign(size, 0);
  starts_.assign(size + 1, 0);
  std::size_t at = 0;
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    std::uint64_t bits = directionClassesNear(planes_[i].column(0), facing);
    if (!oriented)
      bits |= directionClassesNear(-planes_[i].column(0), facing);
    for (; at < ends[i]; ++at) {
      masks_[voxels[at]] |= bits;
      ++starts_[voxels[at] + 1];
    }
  }
  for (std::size_t v = 0; v < size; ++v)
    starts_[v + 1] += starts_[v];
  entries_.resize(starts_[size]);
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  at = 0;
  for (std::size_t i = 0; i < planes_.size(); ++i)
    for (; at < ends[i]; ++at)
      entries_[next[voxels[at]]++] = static_cast<std::uint32_t>(i);
}

inline void
PatchIndex::locate(
    const float* x, const float* y, const float* z, std::size_t n, const Eigen::Vector3f& t, Located& located) const
{
  const Eigen::Array3f last = dims_.cast<float>();
  const float tx = t.x(), ty = t.y(), tz = t.z();
  const float ox = origin_.x(), oy = origin_.y(), oz = origin_.z();
  const float lx = last.x(), ly = last.y(), lz = last.z();
  const float inverse = inverse_voxel_;
  for (std::size_t i = 0; i < n; ++i) {
    const float u = (x[i] + tx - ox) * inverse;
    const float v = (y[i] + ty - oy) * inverse;
    const float w = (z[i] + tz - oz) * inverse;
    const int inside = static_cast<int>(u >= 0) & static_cast<int>(u < lx) & static_cast<int>(v >= 0) &
                       static_cast<int>(v < ly) & static_cast<int>(w >= 0) & static_cast<int>(w < lz);
    const int a = inside ? static_cast<int>(u) : 0;
    const int b = inside ? static_cast<int>(v) : 0;
    const int c = inside ? static_cast<int>(w) : 0;
    located.inside[i] = inside;
    located.block[i] = blockOf(a, b, c);
    located.voxel[i] = voxelInBlock(a, b, c);
  }
}

PCL_SSFR_VECTOR_CLONES int
PatchIndex::countFacing(const Probes& probes, std::size_t begin, std::size_t end, const Eigen::Vector3f& t) const
{
  if (empty())
    return 0;
  Located located;
  int facing = 0;
  for (std::size_t first = begin; first < end; first += Located::kSize) {
    const std::size_t n = std::min(Located::kSize, end - first);
    locate(probes.x.data() + first, probes.y.data() + first, probes.z.data() + first, n, t, located);
    for (std::size_t i = 0; i < n; ++i)
      facing += static_cast<int>((masks_[voxelOf(located, i)] & probes.direction[first + i]) != 0) & located.inside[i];
  }
  return facing;
}

PCL_SSFR_VECTOR_CLONES void
PatchIndex::findFacing(
    const Probes& probes, std::size_t begin, std::size_t end, const Eigen::Vector3f& t, std::int32_t* facing) const
{
  if (empty()) {
    std::fill(facing, facing + (end - begin), 0);
    return;
  }
  Located located;
  for (std::size_t first = begin; first < end; first += Located::kSize) {
    const std::size_t n = std::min(Located::kSize, end - first);
    locate(probes.x.data() + first, probes.y.data() + first, probes.z.data() + first, n, t, located);
    for (std::size_t i = 0; i < n; ++i)
      facing[first - begin + i] =
          static_cast<int>((masks_[voxelOf(located, i)] & probes.direction[first + i]) != 0) & located.inside[i];
  }
}

std::pair<float, float>
PatchIndex::shiftsWithin(const ShiftLine& line, const Eigen::Vector3f& place) const
{
  float from = 0;
  float to = static_cast<float>(line.count) - 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto edge = static_cast<float>(voxel_) * static_cast<float>(dims_[axis]);
    const float start = place[axis] + line.start[axis] - origin_[axis];
    const float margin = kRounding * (edge + std::abs(origin_[axis]) + std::abs(place[axis]) +
                                      std::abs(line.start[axis]) + std::abs(to * line.step[axis]));
    const float one = (-margin - start) / line.step[axis];
    const float other = (edge + margin - start) / line.step[axis];
    // Where the line runs across the axis, these are infinite, or no numbers and no bounds.
    const float lower = std::min(one, other);
    const float upper = std::max(one, other);
    from = lower > from ? lower : from;
    to = upper < to ? upper : to;
  }
  return {from, to};
}

PCL_SSFR_VECTOR_CLONES std::vector<int>
PatchIndex::countFacingAlong(const ShiftLine& line, const Probes& probes, std::size_t begin, std::size_t end) const
{
  std::vector<int> facing(line.count, 0);
  if (empty())
    return facing;
  Located located;
  std::array<float, Located::kSize> x, y, z;
  for (std::size_t k = begin; k < end; ++k) {
    const Eigen::Vector3f place(probes.x[k], probes.y[k], probes.z[k]);
    const std::uint64_t direction = probes.direction[k];
    const auto [from, to] = shiftsWithin(line, place);
    if (!(from <= to))
      continue;
    const std::size_t last = std::min(static_cast<std::size_t>(to) + 1, line.count); // a float rounds large counts
    for (auto first = static_cast<std::size_t>(from); first < last; first += Located::kSize) {
      const std::size_t n = std::min(Located::kSize, last - first);
      for (std::size_t i = 0; i < n; ++i) {
        const auto s = static_cast<float>(static_cast<int>(first + i));
        x[i] = place.x() + (line.start.x() + s * line.step.x());
        y[i] = place.y() + (line.start.y() + s * line.step.y());
        z[i] = place.z() + (line.start.z() + s * line.step.z());
      }
      locate(x.data(), y.data(), z.data(), n, Eigen::Vector3f::Zero(), located);
      for (std::size_t i = 0; i < n; ++i)
        facing[first + i] += static_cast<int>((masks_[voxelOf(located, i)] & direction) != 0) & located.inside[i];
    }
  }
  return facing;
}

[[gnu::always_inline]] inline int
PatchIndex::findIn(std::size_t voxel,
                   const Eigen::Vector3f& p,
                   const Eigen::Vector3f& n,
                   const Tolerance& tolerance) const
{
  int best = -1;
  float best_distance = tolerance.distance;
  const Eigen::Array4f lateral(0, tolerance.lateral, tolerance.lateral, 0);
  const std::uint32_t end = starts_[voxel + 1];
  for (std::uint32_t e = starts_[voxel]; e < end; ++e) {
    const Plane& plane = planes_[entries_[e]];
    const Eigen::Array4f off = plane.coordinates(p).abs();
    const Eigen::Array4f most = plane.halves + lateral;
    const float cosine = n.x() * plane.x[0] + n.y() * plane.y[0] + n.z() * plane.z[0];
    // No branch before the end: which of the conditions fails is hard to foretell.
    const bool meets = static_cast<int>((tolerance.either_side ? std::abs(cosine) : cosine) >= tolerance.min_cos) &
                       static_cast<int>(off[0] < best_distance) & static_cast<int>(off[1] <= most[1]) &
                       static_cast<int>(off[2] <= most[2]);
    best = meets ? static_cast<int>(entries_[e]) : best;
    best_distance = meets ? off[0] : best_distance;
  }
  return best;
}

int
PatchIndex::find(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const Tolerance& tolerance) const
{
  const std::int64_t v = voxelAt(p);
  return v < 0 ? -1 : findIn(static_cast<std::size_t>(v), p, n, tolerance);
}

PCL_SSFR_VECTOR_CLONES void
PatchIndex::findAll(const std::array<const float*, 3>& places,
                    const std::array<const float*, 3>& normals,
                    std::size_t count,
                    const Tolerance& tolerance,
                    int* found) const
{
  if (empty()) {
    std::fill(found, found + count, -1);
    return;
  }
  Located located;
  std::array<std::size_t, Located::kSize> voxels;
  for (std::size_t first = 0; first < count; first += Located::kSize) {
    const std::size_t n = std::min(Located::kSize, count - first);
    locate(places[0] + first, places[1] + first, places[2] + first, n, Eigen::Vector3f::Zero(), located);
    for (std::size_t i = 0; i < n; ++i) {
      voxels[i] = voxelOf(located, i);
      __builtin_prefetch(&starts_[voxels[i]]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = first + i;
      found[k] = located.inside[i] == 0 ? -1
                                        : findIn(voxels[i],
                                                 {places[0][k], places[1][k], places[2][k]},
                                                 {normals[0][k], normals[1][k], normals[2][k]},
                                                 tolerance);
    }
  }
}

} // namespace pcl_ssfr
