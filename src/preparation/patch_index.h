// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/vector_clones.h"
#include "preparation/planar_patches.h"

#include <pcl_ssfr/patch_config.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// Number of classes that directions are quantised to: 3 x 3 cells on each face of a cube.
constexpr int kDirectionClasses = 54;

/// Class of a direction of any length > 0, [0, kDirectionClasses).
int
directionClass(const Eigen::Vector3f& d);

/// Bit set of the classes whose centre is within \p angle [rad] of unit vector \p d.
std::uint64_t
directionClassesNear(const Eigen::Vector3f& d, double angle);

/// Shifts at equal distances.
struct ShiftLine {
  Eigen::Vector3f start; ///< [m]
  Eigen::Vector3f step;  ///< [m]
  std::size_t count = 0;

  Eigen::Vector3f
  operator[](std::size_t i) const
  {
    return start + static_cast<float>(i) * step;
  }
  /// The first of them, the third, and so on.
  ShiftLine
  everySecond() const
  {
    return {start, 2 * step, (count + 1) / 2};
  }
};

/** \brief Planar patches in a voxel grid: which patches pass near a place, and which way they face.
 *
 * A lookup reads the one voxel that holds the place. It lists every patch that comes within reach() of any place in the
 * voxel, so find() and mask() miss none that is within reach() of theirs, wherever the grid lies. Patches farther off,
 * up to a wider tolerance, are found where they are listed all the same: most of those within half a voxel. The reach
 * is of the scan: that the other scan of a pair is larger or noisier, and tolerances wider, does not widen it.
 *
 * Voxels come in blocks of 8 x 8 x 8; all blocks that no patch reaches share one, as surfaces leave most of space
 * empty. Two answers of different cost: mask(p), the directions of all patches near p as one load, for the search over
 * thousands of poses; and find(p, n), the best compatible patch, for scoring and refinement.
 */
class PatchIndex {
public:
  /// When a place on a patch of one scan meets a patch of the other.
  struct Tolerance {
    float min_cos = 0.9f;     ///< of the angle between the normals
    float distance = 0.3f;    ///< to the plane [m]
    float lateral = 0.3f;     ///< beyond the edge of the patch [m]
    bool either_side = false; ///< the signs of the normals carry no information
  };

  /// Places with directions, as countFacing() reads them: arrays, so that the compiler can handle several at once.
  struct Probes {
    std::vector<float> x, y, z;           ///< [m]
    std::vector<std::uint64_t> direction; ///< the bit of the class

    void
    add(const Eigen::Vector3f& p, const Eigen::Vector3f& n)
    {
      x.push_back(p.x());
      y.push_back(p.y());
      z.push_back(p.z());
      direction.push_back(std::uint64_t{1} << directionClass(n));
    }
  };

  PatchIndex() = default;

  /** \param[in] patches the patches
   * \param[in] voxel wanted edge of a voxel [m]; grows where the grid would have more than \p max_voxels
   * \param[in] reach see reach() [m], >= 0
   * \param[in] facing [rad] angle up to which countFacing() takes a patch for one that faces the same way
   */
  PatchIndex(const PlanarPatches& patches,
             double voxel,
             double reach = PreparationConfig{}.match,
             double facing = PreparationConfig{}.loose_facing,
             std::size_t max_voxels = std::size_t{1} << 21);

  bool
  empty() const
  {
    return entries_.empty();
  }
  double
  voxel() const
  {
    return voxel_;
  }

  /// Memory that it takes [bytes].
  std::size_t
  bytes() const
  {
    return planes_.size() * sizeof(Plane) + masks_.size() * sizeof(std::uint64_t) +
           (blocks_.size() + starts_.size() + entries_.size()) * sizeof(std::uint32_t);
  }

  /// Patches within this of a place, across their plane and beyond their edges, are found for sure [m].
  double
  reach() const
  {
    return reach_;
  }

  /// Direction classes of the patches within about half a voxel of \p p, and of all within reach(); 0 outside of the
  /// grid.
  std::uint64_t
  mask(const Eigen::Vector3f& p) const
  {
    const std::int64_t v = voxelAt(p);
    return v < 0 ? 0 : masks_[static_cast<std::size_t>(v)];
  }

  /// How many of the probes [\p begin, \p end), moved by \p t, have patches near them that face their way: mask() of
  /// many.
  int
  countFacing(const Probes& probes, std::size_t begin, std::size_t end, const Eigen::Vector3f& t) const;

  /// The same for each shift of a line. Shifts that move a probe out of the grid cost next to nothing.
  std::vector<int>
  countFacingAlong(const ShiftLine& line, const Probes& probes, std::size_t begin, std::size_t end) const;

  /// Whether each of the probes [\p begin, \p end), moved by \p t, has patches near it that face its way: 1 or 0 into
  /// as many elements of \p facing.
  void
  findFacing(
      const Probes& probes, std::size_t begin, std::size_t end, const Eigen::Vector3f& t, std::int32_t* facing) const;

  /// The compatible patch with the smallest plane distance at place \p p with unit normal \p n, of those that are
  /// listed there; -1 when there is none. What is found is within \p tolerance.
  int
  find(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const Tolerance& tolerance) const;

  /// find() for \p count places and normals, whose coordinates are in arrays; \p found has \p count elements.
  void
  findAll(const std::array<const float*, 3>& places,
          const std::array<const float*, 3>& normals,
          std::size_t count,
          const Tolerance& tolerance,
          int* found) const;

  /// How a place lies to the plane of a patch.
  struct Meeting {
    Eigen::Vector3d normal; ///< of the plane
    double distance;        ///< of the place from the plane, along the normal [m]
    /// Of that distance, in units of the variance of one point across the plane: that of the point itself, and of a
    /// plane fitted to that many points, which grows away from its centroid.
    double variance;
  };

  /// Place \p p and patch \p i.
  Meeting
  meet(int i, const Eigen::Vector3d& p) const
  {
    const Plane& plane = planes_[static_cast<std::size_t>(i)];
    const Eigen::Vector3d normal = plane.column(0).cast<double>();
    const Eigen::Vector3d d = p - plane.column(3).cast<double>();
    const float along = static_cast<float>(d.dot(plane.column(1).cast<double>())) / plane.halves[1];
    const float across = static_cast<float>(d.dot(plane.column(2).cast<double>())) / plane.halves[2];
    const float off = plane.halves[3] * (1 + 3 * (along * along + across * across)); // half width^2 = 3 variances
    return {normal, d.dot(normal), 1 + static_cast<double>(off)};
  }

private:
  /// A patch as find() needs it, in one cache line: its frame by rows, for all coordinates of a place at once.
  struct alignas(64) Plane {
    /// x, y and z of the unit normal, the direction of the largest extent and the one across it, and of the centroid
    /// [m].
    Eigen::Array4f x, y, z;
    Eigen::Array4f halves; ///< 0, half of the largest extent, half of the one across it [m]; 1 / thinned points

    Eigen::Vector3f
    column(int k) const
    {
      return {x[k], y[k], z[k]};
    }
    /// Of \p p along the normal and the two extents, from the centroid [m]; the fourth has no meaning.
    Eigen::Array4f
    coordinates(const Eigen::Vector3f& p) const
    {
      return (p.x() - x[3]) * x + (p.y() - y[3]) * y + (p.z() - z[3]) * z;
    }
  };

  /// Where some places are in the grid.
  struct Located {
    static constexpr std::size_t kSize = kBatchSize;
    std::array<std::int32_t, kSize> block;
    std::array<std::int32_t, kSize> voxel;  ///< within the block
    std::array<std::int32_t, kSize> inside; ///< 1 or 0: then block and voxel are 0
  };

  /// The first and the last shift of a line that may leave a place in the grid; the last is less than the first when
  /// there is none.
  std::pair<float, float>
  shiftsWithin(const ShiftLine& line, const Eigen::Vector3f& place) const;

  /// Places whose coordinates are in arrays, moved by \p t, at most Located::kSize.
  void
  locate(
      const float* x, const float* y, const float* z, std::size_t n, const Eigen::Vector3f& t, Located& located) const;

  std::size_t
  voxelOf(const Located& located, std::size_t i) const
  {
    return joined(blocks_[static_cast<std::size_t>(located.block[i])], located.voxel[i]);
  }

  int
  findIn(std::size_t voxel, const Eigen::Vector3f& p, const Eigen::Vector3f& n, const Tolerance& tolerance) const;

  /// The voxel of the grid that has a number within a block.
  static std::size_t
  joined(std::uint32_t block, int voxel_in_block)
  {
    return (static_cast<std::size_t>(block) << (3 * kBlockBits)) | static_cast<std::size_t>(voxel_in_block);
  }
  /// -1: outside of the grid.
  std::int64_t
  voxelAt(const Eigen::Vector3f& p) const
  {
    const Eigen::Array3f v = (p.array() - origin_.array()) * inverse_voxel_;
    if (!((v >= 0.f).all() && (v < dims_.cast<float>().array()).all()))
      return -1;
    const Eigen::Array3i i = v.cast<int>();
    return static_cast<std::int64_t>(
        joined(blocks_[static_cast<std::size_t>(blockOf(i.x(), i.y(), i.z()))], voxelInBlock(i.x(), i.y(), i.z())));
  }
  int
  blockOf(int x, int y, int z) const
  {
    return ((z >> kBlockBits) * block_dims_.y() + (y >> kBlockBits)) * block_dims_.x() + (x >> kBlockBits);
  }
  static int
  voxelInBlock(int x, int y, int z)
  {
    return ((z & kBlockMask) << (2 * kBlockBits)) | ((y & kBlockMask) << kBlockBits) | (x & kBlockMask);
  }
  /// Where all patches are, with a margin [m].
  struct Box {
    Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array3d high = Eigen::Array3d::Constant(-std::numeric_limits<double>::infinity());
  };
  Box
  addPlanes(const PlanarPatches& patches, double margin);
  /// The grid over the box, of wider voxels where it would have more than \p max_voxels.
  void
  layOut(const Box& box, double voxel, std::size_t max_voxels);
  /// Patches of each voxel, and the directions within \p facing of theirs; both sides where they are not \p oriented.
  void
  fill(bool oriented, double facing);
  /// Visit the rows of voxels that hold a place within reach of the plane.
  template <typename Visit>
  void
  rasterise(const Plane& plane, const Visit& visit) const;

  static constexpr int kBlockBits = 3;
  static constexpr int kBlockMask = (1 << kBlockBits) - 1;

  float inverse_voxel_ = 0;
  double voxel_ = 0;
  double reach_ = 0;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  Eigen::Vector3i dims_ = Eigen::Vector3i::Zero();
  Eigen::Vector3i block_dims_ = Eigen::Vector3i::Zero();
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> blocks_; ///< number of each block of the grid; 0: empty
  std::vector<std::uint64_t> masks_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> entries_;
};

} // namespace pcl_ssfr
