// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

/** \brief Before a function with loops over plain arrays: it is compiled for wider vectors too, and the processor
 * chooses when the library is loaded. The bits are the same: no fused multiply-add, no reordering.
 */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) &&                       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PCL_SSFR_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PCL_SSFR_VECTOR_CLONES
#endif
