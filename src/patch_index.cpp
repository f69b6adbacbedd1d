// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/patch_index.h>

#include "vector_clones.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr double kClassRadius = 0.52; // [rad] a patch counts for the direction classes within this of its normal
constexpr double kReach = 0.75;       // voxels that a patch reaches beyond itself, across and along its plane

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
  const auto reach = static_cast<float>(kReach * voxel_);
  const Eigen::Vector3f minor = plane.normal.cross(plane.major);
  const Eigen::Array3f half = plane.major.array().abs() * (plane.half_major + reach) +
                              minor.array().abs() * (plane.half_minor + reach) + plane.normal.array().abs() * reach;
  const Eigen::Array3f centre = plane.centroid.array() - origin_.array();
  const Eigen::Array3f first = ((centre - half) * inverse_voxel_).floor().max(0.f);
  const Eigen::Array3f last = ((centre + half) * inverse_voxel_).floor().min((dims_.array() - 1).cast<float>());
  if (!(first <= last).all()) // also where float has no numbers for it
    return;
  const Eigen::Array3i low = first.cast<int>();
  const Eigen::Array3i high = last.cast<int>();
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const Eigen::Vector3f d =
            (Eigen::Array3i(x, y, z).cast<float>() + 0.5f).matrix() * static_cast<float>(voxel_) - centre.matrix();
        if (std::abs(d.dot(plane.normal)) <= reach && std::abs(d.dot(plane.major)) <= plane.half_major + reach &&
            std::abs(d.dot(minor)) <= plane.half_minor + reach)
          visit(x, y, z);
      }
}

PatchIndex::PatchIndex(const PlanarPatches& patches, double voxel, std::size_t max_voxels)
{
  const Eigen::Index n = patches.size();
  if (n == 0)
    return;
  planes_.resize(static_cast<std::size_t>(n));
  Eigen::Vector3d low = patches.samples.points.rowwise().minCoeff();
  Eigen::Vector3d high = patches.samples.points.rowwise().maxCoeff();
  for (Eigen::Index i = 0; i < n; ++i) {
    Plane& plane = planes_[static_cast<std::size_t>(i)];
    plane.centroid = patches.samples.points.col(i).cast<float>();
    plane.normal = patches.samples.normals.col(i).cast<float>();
    plane.major = patches.majors.col(i).cast<float>();
    plane.half_major = static_cast<float>(patches.samples.extents[i]);
    plane.half_minor = static_cast<float>(patches.half_minors[i]);
    plane.inverse_count = 1.f / static_cast<float>(std::max(patches.counts[static_cast<std::size_t>(i)], 1u));
  }
  const double margin = voxel + patches.samples.extents.maxCoeff();
  low.array() -= margin;
  high.array() += margin;

  voxel_ = voxel;
  const auto wanted = [&] { return ((high - low) / voxel_).array().ceil().max(1).prod(); };
  while (wanted() > static_cast<double>(max_voxels))
    voxel_ *= 1.1;
  inverse_voxel_ = static_cast<float>(1 / voxel_);
  origin_ = low.cast<float>();
  dims_ = ((high - low) / voxel_).array().ceil().max(1).cast<int>();

  block_dims_ = (dims_.array() + kBlockMask) / (1 << kBlockBits);
  blocks_.assign(static_cast<std::size_t>(block_dims_.x()) * static_cast<std::size_t>(block_dims_.y()) *
                     static_cast<std::size_t>(block_dims_.z()),
                 0);

  // Voxels of all planes, in the order of the planes; blocks are numbered as they are met.
  std::vector<std::uint32_t> voxels;
  std::vector<std::size_t> ends;
  ends.reserve(planes_.size());
  std::uint32_t used = 1;
  for (const Plane& plane : planes_) {
    rasterise(plane, [&](int x, int y, int z) {
      std::uint32_t& block = blocks_[static_cast<std::size_t>(blockOf(x, y, z))];
      if (block == 0)
        block = used++;
      voxels.push_back(static_cast<std::uint32_t>(voxelOf(x, y, z)));
    });
    ends.push_back(voxels.size());
  }
  const std::size_t size = static_cast<std::size_t>(used) << (3 * kBlockBits);
  masks_.assign(size, 0);
  starts_.assign(size + 1, 0);
  std::size_t at = 0;
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    std::uint64_t bits = directionClassesNear(planes_[i].normal, kClassRadius);
    if (!patches.samples.oriented)
      bits |= directionClassesNear(-planes_[i].normal, kClassRadius);
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

PCL_SSFR_VECTOR_CLONES int
PatchIndex::countFacing(const Probes& probes, std::size_t begin, std::size_t end, const Eigen::Vector3f& t) const
{
  if (empty())
    return 0;
  constexpr std::size_t kLanes = 32;
  std::array<std::int32_t, kLanes> block;
  std::array<std::int32_t, kLanes> voxel;
  std::array<std::int32_t, kLanes> inside; // 1 or 0
  const Eigen::Array3f last = dims_.cast<float>();
  const float tx = t.x(), ty = t.y(), tz = t.z();
  const float ox = origin_.x(), oy = origin_.y(), oz = origin_.z();
  const float lx = last.x(), ly = last.y(), lz = last.z();
  const float inverse = inverse_voxel_;
  int facing = 0;
  for (std::size_t first = begin; first < end; first += kLanes) {
    const std::size_t n = std::min(kLanes, end - first);
    const float* const px = probes.x.data() + first;
    const float* const py = probes.y.data() + first;
    const float* const pz = probes.z.data() + first;
    for (std::size_t i = 0; i < n; ++i) {
      const float x = (px[i] + tx - ox) * inverse;
      const float y = (py[i] + ty - oy) * inverse;
      const float z = (pz[i] + tz - oz) * inverse;
      inside[i] = static_cast<int>(x >= 0) & static_cast<int>(x < lx) & static_cast<int>(y >= 0) &
                  static_cast<int>(y < ly) & static_cast<int>(z >= 0) & static_cast<int>(z < lz);
      const int u = inside[i] ? static_cast<int>(x) : 0;
      const int v = inside[i] ? static_cast<int>(y) : 0;
      const int w = inside[i] ? static_cast<int>(z) : 0;
      block[i] = blockOf(u, v, w);
      voxel[i] = voxelInBlock(u, v, w);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t v =
          (static_cast<std::size_t>(blocks_[static_cast<std::size_t>(block[i])]) << (3 * kBlockBits)) |
          static_cast<std::size_t>(voxel[i]);
      facing += static_cast<int>((masks_[v] & probes.direction[first + i]) != 0) & inside[i];
    }
  }
  return facing;
}

int
PatchIndex::find(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const Tolerance& tolerance) const
{
  const std::int64_t v = voxelAt(p);
  if (v < 0)
    return -1;
  int best = -1;
  float best_distance = tolerance.distance;
  const auto u = static_cast<std::size_t>(v);
  for (std::uint32_t e = starts_[u]; e < starts_[u + 1]; ++e) {
    const Plane& plane = planes_[entries_[e]];
    const float cosine = n.dot(plane.normal);
    if ((tolerance.either_side ? std::abs(cosine) : cosine) < tolerance.min_cos)
      continue;
    const Eigen::Vector3f d = p - plane.centroid;
    const float across = d.dot(plane.normal);
    if (std::abs(across) >= best_distance)
      continue;
    const float along = std::abs(d.dot(plane.major));
    if (along > plane.half_major + tolerance.lateral)
      continue;
    const float beside = std::abs(d.dot(plane.normal.cross(plane.major)));
    if (beside > plane.half_minor + tolerance.lateral)
      continue;
    best = static_cast<int>(entries_[e]);
    best_distance = std::abs(across);
  }
  return best;
}

} // namespace pcl_ssfr
