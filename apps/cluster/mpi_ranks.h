// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace pcl_ssfr {
namespace apps {

/** \brief The ranks of an MPI job: rank 0 deals out tasks and takes what the others send, the others work.
 *
 * Only for processes that mpirun (or srun) started, in builds with MPI; MPI is not touched otherwise. All functions are
 * for the thread that made the object. Nobody burns a processor while there is nothing to do.
 */
class MpiRanks {
public:
  /// True when this process is one of several ranks and this build can use them.
  static bool
  areLaunched();
  /// True in a process that speaks for the job: alone, or rank 0 by what its starter says.
  static bool
  isFirst();

  MpiRanks();
  /// Rank 0: work() of the others returns. In another rank that did not come to its end, the job is ended.
  ~MpiRanks();
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks&
  operator=(const MpiRanks&) = delete;

  int
  rank() const;
  int
  count() const;

  /// The next task for a rank; none: it waits.
  using Next = std::function<std::optional<std::string>(int rank)>;
  using OnMessage = std::function<void(const std::string& message)>;
  /** \brief Rank 0: hand out tasks to whoever is free, until there is none and all that were handed out are done. May
   * be called again.
   * \param[in] on_idle called every few milliseconds while nothing comes
   * \throws what a call threw, std::runtime_error when a rank failed, with its number, its machine and what it threw.
   * No task is handed out any more then, and every rank has let go of its own
   */
  void
  deal(const Next& next, const OnMessage& on_message, const std::function<void()>& on_idle);

  using Send = std::function<void(const std::string& message)>;
  /// The others: do tasks until rank 0 is done. What \p run throws is thrown there.
  void
  work(const std::function<void(const std::string& task, const Send& send)>& run);
  /// The others, within a task: rank 0 has no use for the rest of it.
  bool
  isStopped() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace apps
} // namespace pcl_ssfr
