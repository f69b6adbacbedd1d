// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <Eigen/Geometry>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief A matrix as a rigid motion. Rotations written with few digits are made exact.
 * \throw std::invalid_argument saying why the matrix is none ("is not finite", "is not a rigid motion (...)")
 */
Eigen::Isometry3d
toRigidMotion(const Eigen::Matrix4d& matrix);

/** \brief Read a rigid motion: 4 x 4 numbers as text, row major. Rotations written with few digits are made exact.
 * \throw IoError when it is not 16 numbers, not finite, or not a rigid motion
 */
Eigen::Isometry3d
readTransform(const std::string& path);

/// A rigid motion as four lines of four numbers, of \p digits significant digits: with 17 they read back to the same
/// bits.
std::string
formatTransform(const Eigen::Isometry3d& T, int digits = 17);

} // namespace io
} // namespace pcl_ssfr
