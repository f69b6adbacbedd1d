// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_ssfr::baselines {

/** \brief Euclidean distance transform of a point set on a grid of cubic voxels over its bounding box.
 *
 * Every voxel holds the distance from its centre to the nearest centre of a voxel with a point in it, exact
 * (Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", 2012, one axis after the other). It
 * answers for any place: outside the grid by the distance to the grid and the value at the nearest voxel.
 */
class DistanceTransform {
public:
  static constexpr int kMaxVoxels = 512; ///< along the longest side: 512 MiB

  /// Without points: every distance is 0.
  DistanceTransform() = default;
  /** \brief Transform \p points, all finite.
   * \param[in] voxels number of voxels along the longest side of the bounding box, 2 to kMaxVoxels
   * \param[in] threads at least 1; the result does not depend on it
   * \throw std::invalid_argument for points that are not finite or another number of voxels
   */
  DistanceTransform(const Points3& points, int voxels, unsigned threads);

  /// Number of voxels along each axis.
  const std::array<int, 3>&
  size() const
  {
    return size_;
  }
  /// Edge of a voxel, in the unit of the points.
  double
  voxelSize() const
  {
    return voxel_size_;
  }
  /// Centre of the voxel (i, j, k).
  Eigen::Vector3d
  centre(int i, int j, int k) const
  {
    return first_centre_ + voxel_size_ * Eigen::Vector3d(i, j, k);
  }
  /// Distance from the centre of the voxel to the nearest centre of an occupied one [voxels].
  float
  inVoxels(int i, int j, int k) const
  {
    return distances_[index(i, j, k)];
  }
  /// What a voxel's distance may exceed the distance of a place in it to the points by, in the unit of the points.
  double
  slack() const
  {
    return slack_;
  }
  /// Distance from \p x to the nearest point, within slack() when \p x is in the grid.
  double
  estimate(const Eigen::Vector3d& x) const;
  /// Never more than the distance from \p x to the nearest point, wherever \p x is.
  double
  lowerBound(const Eigen::Vector3d& x) const;

  /// \p x in voxels: voxel (i, j, k) is [i, i+1) x [j, j+1) x [k, k+1).
  Eigen::Vector3d
  toGrid(const Eigen::Vector3d& x) const
  {
    return (x - first_centre_) / voxel_size_ + Eigen::Vector3d::Constant(0.5);
  }
  /// All distances [voxels], the first axis fastest.
  const std::vector<float>&
  distances() const
  {
    return distances_;
  }

private:
  std::size_t
  index(int i, int j, int k) const
  {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size_[0]) *
               (static_cast<std::size_t>(j) + static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(k));
  }
  /// Voxel value at the place of the grid nearest to \p x, and the squared distance from \p x to the grid.
  void
  lookUp(const Eigen::Vector3d& x, double& value, double& squared_outside) const;

  std::array<int, 3> size_ = {1, 1, 1};
  double voxel_size_ = 1;
  double slack_ = 0;
  Eigen::Vector3d first_centre_ = Eigen::Vector3d::Zero(); ///< of voxel (0, 0, 0)
  std::vector<float> distances_ = {0.0F};                  ///< [voxels]
};

} // namespace pcl_ssfr::baselines
