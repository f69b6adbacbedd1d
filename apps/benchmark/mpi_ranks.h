// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/** \brief The ranks of an MPI job: rank 0 deals out tasks and collects lines, the others work. Only for processes that
 * mpirun (or srun) started, in builds with MPI; MPI is not touched otherwise.
 */
class MpiRanks {
public:
  /// True when this process is one of several ranks and this build can use them.
  static bool
  areLaunched();

  MpiRanks();
  ~MpiRanks();
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks&
  operator=(const MpiRanks&) = delete;

  int
  rank() const;
  int
  count() const;
  /// What rank 0 says, on all ranks.
  int
  fromFirst(int value) const;

  /// Rank 0: hand the tasks to whoever is free until all are done, or none more once \p stop is set.
  void
  deal(const std::vector<std::string>& tasks,
       const std::function<void(const std::string& line)>& on_line,
       const std::function<void()>& on_idle,
       const std::atomic<int>& stop) const;

  using Send = std::function<void(const std::string& line)>;
  /// The others: do tasks until there are none.
  void
  work(const std::function<void(const std::string& task, const Send& send)>& run) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace apps
} // namespace pcl_ssfr
