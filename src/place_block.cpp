// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "place_block.h"

#include "vector_clones.h"

namespace pcl_ssfr {

namespace {

template <typename Scalar>
[[gnu::always_inline]] inline void
moveInto(PlaceBlock& block, const Scalar* places, const Scalar* normals, std::size_t n, const Eigen::Isometry3d& T)
{
  std::array<double, 12> m; // rows of the rotation with the translation
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      m[static_cast<std::size_t>(4 * row + column)] = T.matrix()(row, column);
  block.count = n;
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = static_cast<double>(places[3 * i]);
    const auto y = static_cast<double>(places[3 * i + 1]);
    const auto z = static_cast<double>(places[3 * i + 2]);
    block.x[i] = m[0] * x + m[1] * y + m[2] * z + m[3];
    block.y[i] = m[4] * x + m[5] * y + m[6] * z + m[7];
    block.z[i] = m[8] * x + m[9] * y + m[10] * z + m[11];
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = static_cast<double>(normals[3 * i]);
    const auto y = static_cast<double>(normals[3 * i + 1]);
    const auto z = static_cast<double>(normals[3 * i + 2]);
    block.nx[i] = m[0] * x + m[1] * y + m[2] * z;
    block.ny[i] = m[4] * x + m[5] * y + m[6] * z;
    block.nz[i] = m[8] * x + m[9] * y + m[10] * z;
  }
}

PCL_SSFR_VECTOR_CLONES void
moveDoubles(PlaceBlock& block, const double* places, const double* normals, std::size_t n, const Eigen::Isometry3d& T)
{
  moveInto(block, places, normals, n, T);
}

PCL_SSFR_VECTOR_CLONES void
moveFloats(PlaceBlock& block, const float* places, const float* normals, std::size_t n, const Eigen::Isometry3d& T)
{
  moveInto(block, places, normals, n, T);
}

} // namespace

void
PlaceBlock::move(const Eigen::Matrix3Xd& places,
                 const Eigen::Matrix3Xd& normals,
                 Eigen::Index first,
                 Eigen::Index n,
                 const Eigen::Isometry3d& T)
{
  moveDoubles(*this, places.data() + 3 * first, normals.data() + 3 * first, static_cast<std::size_t>(n), T);
}

void
PlaceBlock::move(const Eigen::Matrix3Xf& places,
                 const Eigen::Matrix3Xf& normals,
                 Eigen::Index first,
                 Eigen::Index n,
                 const Eigen::Isometry3d& T)
{
  moveFloats(*this, places.data() + 3 * first, normals.data() + 3 * first, static_cast<std::size_t>(n), T);
}

void
PlaceBlock::find(const PatchIndex& index, const PatchIndex::Tolerance& tolerance, int* found) const
{
  std::array<Floats, 6> rounded;
  const std::array<const Doubles*, 6> exact = {&x, &y, &z, &nx, &ny, &nz};
  for (std::size_t k = 0; k < exact.size(); ++k)
    for (std::size_t i = 0; i < count; ++i)
      rounded[k][i] = static_cast<float>((*exact[k])[i]);
  index.findAll({rounded[0].data(), rounded[1].data(), rounded[2].data()},
                {rounded[3].data(), rounded[4].data(), rounded[5].data()},
                count,
                tolerance,
                found);
}

} // namespace pcl_ssfr
