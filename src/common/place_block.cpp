// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/place_block.h"

#include "common/vector_clones.h"

namespace pcl_ssfr {

namespace {

template <typename Scalar>
[[gnu::always_inline]] inline void
moveInto(PlaceBlock& block, const Scalar* places, const Scalar* normals, Eigen::Index n, const Eigen::Isometry3d& T)
{
  std::array<double, 12> m; // rows of the rotation with the translation
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      m[static_cast<std::size_t>(4 * row + column)] = T.matrix()(row, column);
  block.count = static_cast<std::size_t>(n);
  for (std::size_t i = 0; i < block.count; ++i) {
    const auto x = static_cast<double>(places[3 * i]);
    const auto y = static_cast<double>(places[3 * i + 1]);
    const auto z = static_cast<double>(places[3 * i + 2]);
    block.x[i] = m[0] * x + m[1] * y + m[2] * z + m[3];
    block.y[i] = m[4] * x + m[5] * y + m[6] * z + m[7];
    block.z[i] = m[8] * x + m[9] * y + m[10] * z + m[11];
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    const auto x = static_cast<double>(normals[3 * i]);
    const auto y = static_cast<double>(normals[3 * i + 1]);
    const auto z = static_cast<double>(normals[3 * i + 2]);
    block.nx[i] = m[0] * x + m[1] * y + m[2] * z;
    block.ny[i] = m[4] * x + m[5] * y + m[6] * z;
    block.nz[i] = m[8] * x + m[9] * y + m[10] * z;
  }
}

} // namespace

PCL_SSFR_VECTOR_CLONES void
PlaceBlock::move(const double* places, const double* normals, Eigen::Index n, const Eigen::Isometry3d& T)
{
  moveInto(*this, places, normals, n, T);
}

PCL_SSFR_VECTOR_CLONES void
PlaceBlock::move(const float* places, const float* normals, Eigen::Index n, const Eigen::Isometry3d& T)
{
  moveInto(*this, places, normals, n, T);
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
