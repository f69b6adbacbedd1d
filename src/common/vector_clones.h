// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <array>
#include <cstddef>

/** \brief Before a function with loops over plain arrays: it is compiled for wider vectors too, and the processor
 * chooses when the library is loaded. The bits are the same: no fused multiply-add, no reordering.
 */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) &&                       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PCL_SSFR_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PCL_SSFR_VECTOR_CLONES
#endif

namespace pcl_ssfr {

/// Places that loops over arrays handle at once: few enough for the first cache, many enough to be worth a call.
constexpr std::size_t kBlockSize = 256;
/// Places in flight of a search in a tree or an index.
constexpr std::size_t kBatchSize = 32;
/// Points that are handled between two looks at the clock: some 0.1 ms.
constexpr std::size_t kPointsPerLook = 64 * kBlockSize;

/// Loops that add keep so many sums, whatever the width of the processor's vectors: then their order is always the
/// same.
constexpr std::size_t kSumGroup = 8;
using GroupSums = std::array<double, kSumGroup>;

[[gnu::always_inline]] inline double
total(const GroupSums& sums)
{
  return ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]));
}

} // namespace pcl_ssfr
