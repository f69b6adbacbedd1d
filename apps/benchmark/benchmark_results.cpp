// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/benchmark_results.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kSlowShare = 0.9;

std::size_t
placeOf(const std::vector<std::string>& names, const std::string& name)
{
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

MethodSummary
summarizeGroup(const std::vector<const ResultRow*>& rows, const std::string& dataset)
{
  MethodSummary summary;
  summary.dataset = dataset;
  summary.method = rows.front()->method;
  summary.variation = rows.front()->variation;
  std::size_t right = 0;
  std::size_t converged = 0;
  std::size_t converged_wrong = 0;
  std::array<std::size_t, kSuccessBounds.size()> within{};
  std::vector<double> degrees, metres, rmse, gt_rmse, time, cpu;
  std::vector<JudgedAnswer> answers; ///< of those with a pose
  std::vector<JudgedAnswer> stated;  ///< all whose confidence is known
  for (const ResultRow* row : rows) {
    right += row->success ? 1 : 0;
    converged += row->converged ? 1 : 0;
    converged_wrong += row->converged && !row->success ? 1 : 0;
    for (std::size_t i = 0; i < within.size(); ++i)
      within[i] +=
          row->T_target_source && isWithin({row->rotation_error_deg, row->translation_error_m}, kSuccessBounds[i]) ? 1
                                                                                                                   : 0;
    if (row->success) {
      degrees.push_back(row->rotation_error_deg);
      metres.push_back(row->translation_error_m);
      rmse.push_back(row->rmse_m);
      gt_rmse.push_back(row->gt_rmse_m);
    }
    else {
      ++summary.failures[failureReason(*row)];
      if (!row->lost_at.empty())
        ++summary.lost_at[row->lost_at];
    }
    time.push_back(row->time_s);
    cpu.push_back(row->cpu_s);
    if (std::isfinite(row->peak_rss_mib))
      summary.peak_rss_mib = std::max(summary.peak_rss_mib, row->peak_rss_mib);
    if (!std::isfinite(row->confidence))
      continue;
    stated.push_back({row->confidence, row->success});
    if (row->T_target_source)
      answers.push_back(stated.back());
  }
  const std::size_t n = rows.size();
  summary.success = makeRate(right, n);
  summary.converged = makeRate(converged, n);
  summary.converged_wrong = makeRate(converged_wrong, converged);
  for (std::size_t i = 0; i < within.size(); ++i)
    summary.within[i] = makeRate(within[i], n);
  summary.median_rotation_deg = quantile(degrees, 0.5);
  summary.median_translation_m = quantile(metres, 0.5);
  summary.median_rmse_m = quantile(rmse, 0.5);
  summary.median_gt_rmse_m = quantile(gt_rmse, 0.5);
  summary.median_time_s = quantile(time, 0.5);
  summary.p90_time_s = quantile(time, kSlowShare);
  summary.median_cpu_s = quantile(cpu, 0.5);
  if (!stated.empty())
    summary.precision_recall = precisionRecall(answers, n);
  summary.log_loss = logLoss(stated);
  summary.calibration_error = calibrationError(stated);
  return summary;
}

} // namespace

Rate
makeRate(std::size_t count, std::size_t of)
{
  Rate rate;
  rate.count = count;
  rate.of = of;
  rate.value = of == 0 ? 0 : static_cast<double>(count) / static_cast<double>(of);
  rate.interval = wilsonInterval(count, of);
  return rate;
}

std::string
failureReason(const ResultRow& row)
{
  return row.converged ? "wrong pose" : row.status;
}

BenchmarkResults
summarize(std::vector<ResultRow> rows,
          const std::vector<std::string>& datasets,
          const std::vector<std::string>& methods)
{
  BenchmarkResults results;
  const auto order = [&](const ResultRow& row) {
    return std::make_tuple(placeOf(datasets, row.dataset),
                           row.dataset,
                           orderOf(row.variation),
                           row.pair,
                           placeOf(methods, row.method),
                           row.method);
  };
  std::sort(rows.begin(), rows.end(), [&order](const ResultRow& a, const ResultRow& b) { return order(a) < order(b); });
  results.rows = std::move(rows);
  results.planned = results.rows.size();

  using Key = std::tuple<std::size_t, std::string, decltype(orderOf(Variation{})), std::size_t, std::string>;
  std::map<Key, std::vector<const ResultRow*>> groups;
  std::size_t dataset_count = 0;
  std::string last;
  for (const ResultRow& row : results.rows) {
    dataset_count += dataset_count == 0 || row.dataset != last ? 1 : 0;
    last = row.dataset;
    const std::size_t method = placeOf(methods, row.method);
    groups[{placeOf(datasets, row.dataset), row.dataset, orderOf(row.variation), method, row.method}].push_back(&row);
    groups[{datasets.size() + 1, "", orderOf(row.variation), method, row.method}].push_back(&row);
  }
  for (const auto& [key, group] : groups) {
    const std::string& dataset = std::get<1>(key);
    if (!dataset.empty() || dataset_count > 1) // of one dataset, all are the same again
      results.summaries.push_back(summarizeGroup(group, dataset));
  }
  return results;
}

} // namespace apps
} // namespace pcl_ssfr
