// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <omp.h>

#include <cstdint>
#include <exception>

namespace pcl_ssfr {

/** \brief Calls \p body(i) for every i in [0, \p count), in parallel; each call should fill a slot of its own, so that
 * the bits do not depend on the number of threads.
 *
 * In a parallel region the iterations become tasks, which threads that wait at its end pick up: where two scans are
 * prepared side by side, the one that is ready first helps with the other. \param[in] threads with less than two
 * everything runs in this one \param[in] grain iterations that are handed out together, >= 1
 * \throws what a call threw, one of several, when all are done
 */
template <typename Body>
void
forEachInParallel(std::int64_t count, std::int64_t grain, int threads, const Body& body)
{
  if (threads < 2 || count <= grain) {
    for (std::int64_t i = 0; i < count; ++i)
      body(i);
    return;
  }
  std::exception_ptr failure;
  const auto run = [&](std::int64_t i) { // nothing may be thrown out of a parallel region
    try {
      body(i);
    }
    catch (...) {
#pragma omp critical(pcl_ssfr_failure)
      failure = std::current_exception();
    }
  };
  if (omp_in_parallel()) {
#pragma omp taskloop grainsize(grain) default(shared)
    for (std::int64_t i = 0; i < count; ++i)
      run(i);
  }
  else {
#pragma omp parallel for schedule(dynamic, grain) num_threads(threads)
    for (std::int64_t i = 0; i < count; ++i)
      run(i);
  }
  if (failure)
    std::rethrow_exception(failure);
}

} // namespace pcl_ssfr
