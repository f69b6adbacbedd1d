// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/candidate_rows.h>
#include <apps/benchmark/child_process.h>
#include <apps/methods/method_run.h>
#include <apps/pairs/pair_input.h>
#include <apps/pairs/pair_truth.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A method as the benchmark runs it: one of ours by its name, or someone else's program.
struct BenchmarkMethod {
  std::string name;
  std::string command;            ///< of an external program, as written; empty: a method of the registry
  std::vector<std::string> words; ///< the command in words, with {source}, {target}, {threads} and {seed}
};

/// How every method of a run is run.
struct RunSettings {
  double timeout = 300;   ///< of a method in wall clock, loading excluded [s]
  double cpu_timeout = 0; ///< the same in processor time [s]; 0: no limit
  unsigned threads = 1;   ///< 0: all processors
  bool rmse = true;       ///< measure overlap and RMSE at the truth, which takes longer than reading the scans
  ParameterRule rule;
};

/// What came of a method on a pair.
struct MethodAnswer {
  std::string status; ///< of ssfr's Status, or crashed, timeout, failed, bad_output, missing, out_of_memory
  std::string message;
  bool converged = false;
  std::optional<Eigen::Isometry3d> T_target_source; ///< file coordinates; none: no pose
  std::optional<double> overlap;                    ///< as the method measured it
  std::optional<double> confidence;                 ///< of methods that judge their answer
  double seconds = 0;                               ///< the method alone, loading excluded [s]
  double cpu_seconds = 0;                           ///< the same in processor time [s]
  double peak_rss_mib = 0;                          ///< of its process [MiB]
  std::vector<CandidateAnswer> candidates;          ///< best first; of methods of the registry
  std::string lost_at;                              ///< stage that lost the truth, see lostStage(); of ssfr
  std::optional<PairTruth> truth;                   ///< where it was asked for and could be measured
  bool stopped = false;                             ///< ended by the user: no result
  bool asked_to_end = false; ///< its process was, by a signal from elsewhere: perhaps the whole run is
};

/// The words of a command line: separated by blanks; quotes keep blanks, a backslash keeps the next character.
/// \throw std::invalid_argument for an open quote
std::vector<std::string>
splitWords(const std::string& command);

/// What is known about a pair, measured in a process of its own. \throw std::runtime_error saying what failed
PairTruth
askTruth(const PairRequest& request, const RunSettings& settings, const std::atomic<int>& stop);

/// Write the pair as methods get it to two binary PCD files, in a process of its own. \throw std::runtime_error
void
askExport(const PairRequest& request,
          const std::string& source,
          const std::string& target,
          const std::atomic<int>& stop);

/** \brief Run a method of the registry on a pair in a process of its own. Never throws for what the method does.
 * \param[in] bound within which a pose of ssfr is right; of a wrong one, the stage that lost the truth is looked for
 * \param[in] with_truth measure the truth in the same process, once the method is done: the scans are loaded once
 */
MethodAnswer
askMethod(const std::string& method,
          const PairRequest& request,
          const RunSettings& settings,
          const SuccessBound& bound,
          bool with_truth,
          const std::atomic<int>& stop);

/// Run an external program on two files, watched by a process of its own.
MethodAnswer
askExternal(const BenchmarkMethod& method,
            const std::string& source,
            const std::string& target,
            std::uint64_t seed,
            const RunSettings& settings,
            const std::atomic<int>& stop);

/// The option that makes this program such a process: it reads one request (CBOR) from its standard input and answers
/// it in lines of JSON.
constexpr const char* kWorkerOption = "--worker";

/// The work of that process; the exit code of the program.
int
runWorker();

} // namespace apps
} // namespace pcl_ssfr
