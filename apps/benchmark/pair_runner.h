// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_plan.h>
#include <apps/pairs/result_row.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace pcl_ssfr {
namespace apps {

/** \brief Runs methods on one planned pair and judges their answers. What all methods share (the truth, the files of
 * external programs) is made once, when the first method needs it. May be used by several threads.
 */
class PairRunner {
public:
  PairRunner(const BenchmarkPlan& plan, std::size_t pair, const std::atomic<int>& stop);
  ~PairRunner();
  PairRunner(const PairRunner&) = delete;
  PairRunner&
  operator=(const PairRunner&) = delete;

  /// The result of a method, by its index in the plan; nothing when the user stopped it. Whatever goes wrong is a row.
  std::optional<PairResult>
  run(std::size_t method);

private:
  struct Files {
    std::string source;
    std::string target;
  };
  /// Leave the signal that ends the run a moment to come.
  void
  waitForStop() const;
  /// Whether the truth of the pair was measured already, or cannot be.
  bool
  knowsTruth();
  void
  keepTruth(const PairTruth& truth);
  const PairTruth&
  truth();
  const Files&
  files();
  MethodAnswer
  ask(const BenchmarkMethod& method);

  const BenchmarkPlan& plan_;
  const PlannedPair& pair_;
  const std::atomic<int>& stop_;
  std::mutex mutex_;
  std::optional<PairTruth> truth_;
  std::string truth_error_;
  std::optional<Files> files_;
  std::string folder_; ///< of the files, removed in the end; empty: none
};

/// The row of an answer: errors, success and RMSE follow from the truth, as does which candidates are right.
PairResult
judgeAnswer(const BenchmarkPlan& plan, const PlannedPair& pair, const MethodAnswer& answer, const PairTruth* truth);

} // namespace apps
} // namespace pcl_ssfr
