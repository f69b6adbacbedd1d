// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace pcl_ssfr {

/// Cells of directions: a square grid on each face of a cube around the viewpoint.
class DirectionGrid {
public:
  DirectionGrid() = default;

  /// \param[in] cell nominal width of a cell [rad], (0, pi/2]
  explicit DirectionGrid(double cell);

  /// Number of cells.
  std::size_t
  size() const
  {
    return static_cast<std::size_t>(6 * resolution_ * resolution_);
  }
  /// Cells along the edge of a face.
  int
  resolution() const
  {
    return resolution_;
  }
  /// Index of the cell in which direction \p d (from the viewpoint, any length > 0) lies; some cell when d is no
  /// direction (zero, not finite).
  std::size_t
  cell(const Eigen::Vector3f& d) const
  {
    return static_cast<std::size_t>(cell(d.x(), d.y(), d.z()));
  }
  /// The same of a direction (\p x, \p y, \p z): without branches, for loops over many.
  int
  cell(float x, float y, float z) const
  {
    const float xy = std::abs(y) > std::abs(x) ? y : x; // the larger component ...
    const float yx = std::abs(y) > std::abs(x) ? x : y; // ... and the other
    const bool along_z = std::abs(z) > std::abs(xy);
    const bool along_y = std::abs(y) > std::abs(x);
    const float major = along_z ? z : xy;
    const float u = along_z ? x : yx;
    const float v = along_z ? y : z;
    const float scale = half_ / std::abs(major);
    const auto last = static_cast<float>(resolution_ - 1);
    // The order of the arguments makes NaN 0.
    const auto column = static_cast<int>(std::max(0.f, std::min(u * scale + half_, last)));
    const auto row = static_cast<int>(std::max(0.f, std::min(v * scale + half_, last)));
    const int face = (along_z ? 4 : along_y ? 2 : 0) + (major < 0 ? 1 : 0);
    return (face * resolution_ + row) * resolution_ + column;
  }

private:
  int resolution_ = 0;
  float half_ = 0;
};

/// Ranges of the nearest and the farthest return of a cell [m]; zeros when there was none.
struct DepthSpan {
  float nearest = 0;
  float farthest = 0;
};

/** \brief What is seen of some points from a place in each cell of a grid.
 *
 * Points at the place itself or that are not finite are no returns.
 * \param[in] points 3 x N, in one frame with \p viewpoint [m]
 * \param[in] deadline when it passes meanwhile, the result is unspecified
 */
std::vector<DepthSpan>
depthSpans(const Eigen::Matrix3Xf& points,
           const Eigen::Vector3f& viewpoint,
           const DirectionGrid& grid,
           const Deadline& deadline = Deadline());

/** \brief What a sensor saw in each direction: the nearest and farthest return of each cell of a cube map.
 *
 * A cube map has no poles and needs no trigonometry; its cells are 0.5 to 1 times the nominal angle wide.
 */
class RangeImage {
public:
  RangeImage() = default;

  /** \param[in] points 3 x N, in one frame with \p viewpoint [m]
   * \param[in] viewpoint the sensor
   * \param[in] cell nominal width of a cell [rad], (0, pi/2]
   */
  RangeImage(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell);

  bool
  empty() const
  {
    return nearest_.empty();
  }
  const Eigen::Vector3f&
  viewpoint() const
  {
    return viewpoint_;
  }
  std::size_t
  size() const
  {
    return nearest_.size();
  }
  /// Memory that it takes [bytes].
  std::size_t
  bytes() const
  {
    return (nearest_.size() + farthest_.size() + free_.size()) * sizeof(float);
  }
  const DirectionGrid&
  grid() const
  {
    return grid_;
  }
  /// DirectionGrid::cell().
  std::size_t
  cell(const Eigen::Vector3f& d) const
  {
    return grid_.cell(d);
  }
  /// Range of the nearest return in a cell [m]; 0 when there was none.
  float
  nearest(std::size_t cell) const
  {
    return nearest_[cell];
  }
  /// Range up to which a cell is free [m]; 0 when it has no return. The nearest return of it and of the eight cells
  /// around it: the rays of a cell may all pass by the edge of a thing that reaches into it, and a surface seen at a
  /// grazing angle spans many ranges.
  float
  freeRange(std::size_t cell) const
  {
    return free_[cell];
  }
  /// Which of \p count places, whose coordinates [m] are in arrays, lie in free space: nearer than \p ratio of the free
  /// range of their direction, less \p margin [m]. 1 or 0 into the \p count elements of \p free.
  void
  findFree(const std::array<const float*, 3>& places, std::size_t count, float ratio, float margin, std::int32_t* free)
      const;
  /// Range of the farthest return in a cell [m]; 0 when there was none.
  float
  farthest(std::size_t cell) const
  {
    return farthest_[cell];
  }

private:
  void
  findFreeRanges();

  DirectionGrid grid_;
  Eigen::Vector3f viewpoint_ = Eigen::Vector3f::Zero();
  std::vector<float> nearest_;
  std::vector<float> farthest_;
  std::vector<float> free_;
};

} // namespace pcl_ssfr
