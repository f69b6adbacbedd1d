// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_options.h>

namespace pcl_ssfr {
namespace apps {

/** \brief Run what the arguments ask for: check everything, run, write the reports. Alone or as a rank of an MPI job.
 * \return 0, or 128 + the signal that stopped it
 * \throw UsageError, io::IoError before any work starts, or when results cannot be written
 */
int
runBenchmark(const BenchmarkArguments& arguments);

} // namespace apps
} // namespace pcl_ssfr
