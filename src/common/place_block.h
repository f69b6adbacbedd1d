// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/vector_clones.h"
#include "preparation/patch_index.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>

namespace pcl_ssfr {

/** \brief Some places with normals, moved by a pose, and the patches that they meet: arrays, so that the compiler can
 * handle several places at once.
 */
struct PlaceBlock {
  static constexpr std::size_t kSize = kBlockSize;
  using Doubles = std::array<double, kSize>;
  using Floats = std::array<float, kSize>;

  Doubles x, y, z;    ///< places after the motion [m]
  Doubles nx, ny, nz; ///< their normals
  std::size_t count = 0;

  /// Fill with \p n places and normals, at most kSize, x, y and z of each side by side, moved by \p T.
  void
  move(const double* places, const double* normals, Eigen::Index n, const Eigen::Isometry3d& T);
  void
  move(const float* places, const float* normals, Eigen::Index n, const Eigen::Isometry3d& T);

  Eigen::Vector3d
  place(std::size_t i) const
  {
    return {x[i], y[i], z[i]};
  }
  Eigen::Vector3d
  normal(std::size_t i) const
  {
    return {nx[i], ny[i], nz[i]};
  }

  /// The patches that the places meet, into the \p count elements of \p found; -1: none.
  void
  find(const PatchIndex& index, const PatchIndex::Tolerance& tolerance, int* found) const;
};

} // namespace pcl_ssfr
