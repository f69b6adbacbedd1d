// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/vector_clones.h"
#include "preparation/range_image.h"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>

namespace pcl_ssfr {

/// Some points as seen from a place: arrays, so that the compiler can handle several points at once.
struct SightBlock {
  static constexpr std::size_t kSize = kBlockSize;
  using Floats = std::array<float, kSize>;

  Floats x, y, z; ///< from the place [m]
  Floats range;   ///< [m]
  std::array<int, kSize> cells;

  /// \p count points whose coordinates, floats or doubles, are \p stride apart in arrays.
  template <typename Scalar>
  [[gnu::always_inline]] inline void
  look(const std::array<const Scalar*, 3>& points,
       std::size_t stride,
       std::size_t count,
       const Eigen::Vector3f& place,
       const DirectionGrid& grid)
  {
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = static_cast<float>(points[0][stride * i]) - place.x();
      y[i] = static_cast<float>(points[1][stride * i]) - place.y();
      z[i] = static_cast<float>(points[2][stride * i]) - place.z();
    }
    locate(count, grid);
  }

  /// Range and cell of \p count places that are known.
  [[gnu::always_inline]] inline void
  locate(std::size_t count, const DirectionGrid& grid)
  {
    for (std::size_t i = 0; i < count; ++i)
      range[i] = std::sqrt(x[i] * x[i] + (y[i] * y[i] + z[i] * z[i]));
    for (std::size_t i = 0; i < count; ++i)
      cells[i] = grid.cell(x[i], y[i], z[i]);
  }
};

} // namespace pcl_ssfr
