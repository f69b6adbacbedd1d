// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/patch_index.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>

namespace pcl_ssfr {

/** \brief Some places with normals, moved by a pose, and the patches that they meet: arrays, so that the compiler can
 * handle several places at once.
 */
struct PlaceBlock {
  static constexpr std::size_t kSize = 256;
  using Doubles = std::array<double, kSize>;
  using Floats = std::array<float, kSize>;

  Doubles x, y, z;    ///< places after the motion [m]
  Doubles nx, ny, nz; ///< their normals
  std::size_t count = 0;

  /** \brief Fill from columns [\p first, \p first + \p n) of places and normals, \p n at most kSize. */
  void
  move(const Eigen::Matrix3Xd& places,
       const Eigen::Matrix3Xd& normals,
       Eigen::Index first,
       Eigen::Index n,
       const Eigen::Isometry3d& T);
  void
  move(const Eigen::Matrix3Xf& places,
       const Eigen::Matrix3Xf& normals,
       Eigen::Index first,
       Eigen::Index n,
       const Eigen::Isometry3d& T);

  /// The patches that the places meet, into the \p count elements of \p found; -1: none.
  void
  find(const PatchIndex& index, const PatchIndex::Tolerance& tolerance, int* found) const;
};

} // namespace pcl_ssfr
