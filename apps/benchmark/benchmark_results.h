// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/pairs/measures.h>
#include <apps/pairs/result_row.h>

#include <nlohmann/json.hpp>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How often something happened, with its confidence interval.
struct Rate {
  std::size_t count = 0;
  std::size_t of = 0;
  double value = 0;  ///< count / of, 0 of none
  Interval interval; ///< Wilson, 95 %
};

Rate
makeRate(std::size_t count, std::size_t of);

/// One method on the pairs of one dataset under one variation, or of all datasets.
struct MethodSummary {
  std::string dataset; ///< empty: all
  std::string method;
  Variation variation;
  Rate success;                                   ///< by each dataset's own bound
  std::array<Rate, kSuccessBounds.size()> within; ///< by kSuccessBounds
  Rate converged;                                 ///< accepted: the method says that its pose may be used
  Rate converged_wrong;                           ///< false positives, of the accepted
  // Of the right answers; NaN of none.
  double median_rotation_deg = 0;
  double median_translation_m = 0;
  double median_rmse_m = 0;
  double median_gt_rmse_m = 0;
  // Of all runs.
  double median_time_s = 0;
  double p90_time_s = 0;
  double median_cpu_s = 0;
  double peak_rss_mib = 0;                       ///< largest
  std::map<std::string, std::size_t> failures;   ///< of pairs that were not solved, by reason; see failureReason()
  std::map<std::string, std::size_t> lost_at;    ///< of the same, by the stage that lost the truth, where it is known
  std::vector<PrecisionRecall> precision_recall; ///< empty: the method states no confidence
  // Of the confidence, over all runs that state one; NaN of none.
  double log_loss = 0;
  double calibration_error = 0; ///< [0, 1]
};

/// All that a run found, and earlier runs in the same folder: what reports are made from.
struct BenchmarkResults {
  nlohmann::ordered_json settings; ///< as in settings.json
  nlohmann::ordered_json run;      ///< date, machine, command of the run that wrote last; null when they are not known
  std::vector<ResultRow> rows;     ///< sorted by dataset, variation, pair, method: as they were first asked for
  std::size_t planned = 0;         ///< rows that the run would have had; more than it has when it was stopped
  bool complete = true;
  std::vector<MethodSummary> summaries; ///< by dataset, variation and method; those of all datasets last
};

/// Why a row is no success: the status of a method that gave up or broke, or "wrong pose" of one that claims another.
std::string
failureReason(const ResultRow& row);

/** \brief Sort the rows and sum them up.
 * \param[in] datasets,methods names in the order of the report; others follow
 */
BenchmarkResults
summarize(std::vector<ResultRow> rows,
          const std::vector<std::string>& datasets,
          const std::vector<std::string>& methods);

} // namespace apps
} // namespace pcl_ssfr
