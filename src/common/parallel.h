// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <exception>

namespace pcl_ssfr {

/// Work is dealt in so many pieces a thread: some take longer than others.
constexpr std::int64_t kTasksPerThread = 8;

namespace detail {

/// Marks the thread as one that works for this library, in a parallel region of its own, for as long as this lives.
class TeamScope {
public:
  TeamScope() : before_(inside_) { inside_ = true; }
  ~TeamScope() { inside_ = before_; }
  TeamScope(const TeamScope&) = delete;
  TeamScope&
  operator=(const TeamScope&) = delete;

  static bool
  isInside()
  {
    return inside_;
  }

private:
  inline static thread_local bool inside_ = false;
  bool before_;
};

/// Keeps what was thrown first in a parallel region, which nothing may be thrown out of.
class Failure {
public:
  template <typename Call>
  void
  guard(const Call& call)
  {
    const TeamScope scope;
    try {
      call();
    }
    catch (...) {
#pragma omp critical(pcl_ssfr_failure)
      if (!failure_)
        failure_ = std::current_exception();
    }
  }
  void
  rethrow() const
  {
    if (failure_)
      std::rethrow_exception(failure_);
  }

private:
  std::exception_ptr failure_;
};

} // namespace detail

/** \brief Calls \p body once; the loops that it runs by forEachInParallel() share one team of \p threads threads.
 *
 * The others pick up pieces of those loops while there are some. None has to come to the end of each loop: on a machine
 * that does other work as well, that wait costs more than the loop.
 * \throws what \p body throws
 */
template <typename Body>
void
runInTeam(int threads, const Body& body)
{
  if (threads < 2 || detail::TeamScope::isInside()) {
    body();
    return;
  }
  detail::Failure failure;
#pragma omp parallel num_threads(threads)
#pragma omp single
  failure.guard(body);
  failure.rethrow();
}

/** \brief Calls \p body(i) for every i in [0, \p count), in parallel; each call should fill a slot of its own, so that
 * the bits do not depend on the number of threads.
 *
 * Within another such loop or runInTeam() the pieces become tasks for that team: where two scans are prepared side by
 * side, the thread that is ready first helps with the other scan. A parallel region of the caller's is left alone.
 * \param[in] threads of a new team; with less than two everything runs in this thread, in order
 * \param[in] grain iterations that are handed out together, at least, >= 1
 * \throws what a call threw, one of several; with several threads the other calls are made all the same
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
  detail::Failure failure;
  if (detail::TeamScope::isInside()) {
    // GNU's OpenMP makes no tasks where that would make more than 64 a thread.
    const std::int64_t most = kTasksPerThread * omp_get_num_threads();
    const std::int64_t piece = std::max(grain, (count + most - 1) / most);
// Clang 14 counts the tasks unsigned, and warns of that.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma omp taskloop grainsize(piece) default(shared)
    for (std::int64_t i = 0; i < count; ++i)
      failure.guard([&] { body(i); });
#pragma GCC diagnostic pop
  }
  else {
#pragma omp parallel for schedule(dynamic, grain) num_threads(threads)
    for (std::int64_t i = 0; i < count; ++i)
      failure.guard([&] { body(i); });
  }
  failure.rethrow();
}

} // namespace pcl_ssfr
