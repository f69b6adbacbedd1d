// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <atomic>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A program to run in a process of its own.
struct ChildRequest {
  std::vector<std::string> command; ///< program (found as a shell would) and its arguments; no shell reads them
  std::string input;                ///< its standard input
  double time_limit = 0;            ///< it is killed after so long [s]; 0: never
  double cpu_limit = 0;             ///< it is killed after so much processor time of it and its children [s]; 0: never
  double loading_limit = 0;         ///< > 0: the limits count from its first line of output, which has this long [s]
  double grace = 0.3;               ///< between the request to end and the kill [s]
  unsigned threads = 1;             ///< OMP_NUM_THREADS of the child; 0: not set
};

/// How it went.
struct ChildOutcome {
  enum class End { Exited, Signalled, TimedOut, CpuTimedOut, Stopped, NotStarted };
  End end = End::NotStarted;
  int code = 0;            ///< exit code, signal, or errno of the failed start
  std::string output;      ///< end of its standard output
  std::string errors;      ///< end of its standard error
  double seconds = 0;      ///< wall clock from the start, or from the first line where loading_limit is set [s]
  double cpu_seconds = 0;  ///< processor time of it and its children, from the same moment on [s]
  double peak_rss_mib = 0; ///< largest resident memory of it or of a child it waited for [MiB]
};

/** \brief Run a program to its end, or to one of its limits, or until \p stop. It leads a process group that is killed
 * as a whole, and it dies with this process. Its environment is that of this process but for MPI's variables.
 */
ChildOutcome
runChild(const ChildRequest& request, const std::atomic<int>& stop);

/// From now on orphans of this process' children become its own children, so that killStrays() finds them.
void
adoptStrays();

/// Kill all children of this process, and theirs. For processes that wait for no other child.
void
killStrays();

/// Largest resident memory of this process since it was started [MiB]; 0 where the system does not report it.
double
peakMemoryMib();

/// What a person calls a signal ("segmentation fault").
std::string
signalName(int signal);

} // namespace apps
} // namespace pcl_ssfr
