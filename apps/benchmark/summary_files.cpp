// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/summary_files.h>

#include <apps/common/format_text.h>
#include <apps/common/json_values.h>
#include <apps/io/file_bytes.h>

#include <cmath>
#include <filesystem>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kPercent = 100;
constexpr double kCentimetres = 100;

Json
rateJson(const Rate& rate)
{
  return {{"count", rate.count},
          {"of", rate.of},
          {"rate", rate.of > 0 ? Json(rate.value) : Json(nullptr)},
          {"wilson_95", {rate.interval.low, rate.interval.high}}};
}

Json
methodJson(const MethodSummary& summary)
{
  Json json;
  json["dataset"] = summary.dataset.empty() ? Json(nullptr) : Json(summary.dataset);
  json["method"] = summary.method;
  json["variation"] = toJson(summary.variation);
  json["pairs"] = summary.success.of;
  json["solved"] = summary.success.count;
  json["accepted"] = summary.converged.count;
  json["false_positives"] = summary.converged_wrong.count;
  json["success"] = rateJson(summary.success);
  json["success_within"] = Json::array();
  for (std::size_t i = 0; i < kSuccessBounds.size(); ++i) {
    Json within{{"rotation_deg", kSuccessBounds[i].rotation_deg}, {"translation_m", kSuccessBounds[i].translation_m}};
    within.update(rateJson(summary.within[i]));
    json["success_within"].push_back(within);
  }
  json["converged"] = rateJson(summary.converged);
  json["converged_wrong"] = rateJson(summary.converged_wrong);
  json["median_rotation_error_deg"] = numberOrNull(summary.median_rotation_deg);
  json["median_translation_error_m"] = numberOrNull(summary.median_translation_m);
  json["median_rmse_m"] = numberOrNull(summary.median_rmse_m);
  json["median_gt_rmse_m"] = numberOrNull(summary.median_gt_rmse_m);
  json["median_time_s"] = numberOrNull(summary.median_time_s);
  json["p90_time_s"] = numberOrNull(summary.p90_time_s);
  json["median_cpu_s"] = numberOrNull(summary.median_cpu_s);
  json["peak_rss_mib"] = numberOrNull(summary.peak_rss_mib);
  json["log_loss"] = numberOrNull(summary.log_loss);
  json["calibration_error"] = numberOrNull(summary.calibration_error);
  json["failures"] = Json::object();
  for (const auto& [reason, count] : summary.failures)
    json["failures"][reason] = count;
  json["lost_at"] = Json::object();
  for (const auto& [stage, count] : summary.lost_at)
    json["lost_at"][stage] = count;
  json["precision_recall"] = Json::array();
  for (const PrecisionRecall& point : summary.precision_recall)
    json["precision_recall"].push_back(
        {{"confidence", point.confidence}, {"precision", point.precision}, {"recall", point.recall}});
  return json;
}

std::string
rateText(const Rate& rate)
{
  return rate.of == 0 ? "-" : format("%.0f %%", kPercent * rate.value);
}

std::string
rateWithInterval(const Rate& rate)
{
  return rate.of == 0 ? "-"
                      : format("%zu of %zu, %.0f %% [%.0f, %.0f]",
                               rate.count,
                               rate.of,
                               kPercent * rate.value,
                               kPercent * rate.interval.low,
                               kPercent * rate.interval.high);
}

std::string
numberText(const char* pattern, double value)
{
  return std::isfinite(value) ? format(pattern, value) : std::string("-");
}

/// A name within a table.
std::string
cell(const std::string& text)
{
  std::string result;
  for (const char c : text)
    result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

std::string
failuresText(const MethodSummary& summary)
{
  std::string text;
  for (const auto& [reason, count] : summary.failures)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  return text.empty() ? "-" : text;
}

/// The limit of processor time, where there was one.
std::string
cpuLimitText(const Json& settings)
{
  const double limit = settings.value("cpu_timeout_s", 0.0);
  return limit > 0 ? format(" of wall clock and %g s of processor time", limit) : std::string();
}

std::string
tableRow(const MethodSummary& s)
{
  std::string text = "| " + cell(s.method) + " | " + rateWithInterval(s.success) + " | ";
  for (const Rate& rate : s.within)
    text += rateText(rate) + " | ";
  text += format("%zu | %zu | ", s.converged.count, s.converged_wrong.count);
  text += numberText("%.3f", s.median_rotation_deg) + " | ";
  text += numberText("%.1f", kCentimetres * s.median_translation_m) + " | ";
  text += numberText("%.1f", kCentimetres * s.median_rmse_m) + " (" +
          numberText("%.1f", kCentimetres * s.median_gt_rmse_m) + ") | ";
  text += numberText("%.2f", s.median_time_s) + " / " + numberText("%.2f", s.p90_time_s) + " | ";
  text += numberText("%.2f", s.median_cpu_s) + " | " + numberText("%.0f", s.peak_rss_mib) + " | ";
  text += numberText("%.3f", s.log_loss) + " | " + numberText("%.1f %%", kPercent * s.calibration_error) + " | ";
  return text + cell(failuresText(s)) + " |\n";
}

std::string
tableHead()
{
  std::string head = "| method | success [95 %] |";
  std::string line = "|---|---|";
  for (const SuccessBound& bound : kSuccessBounds) {
    head += format(" %g° / %g m |", bound.rotation_deg, bound.translation_m);
    line += "---|";
  }
  head +=
      " accepted | false positives | median ° | median cm | RMSE (truth) cm | time, 90 % s | CPU s | MiB | log loss | "
      "calibration error | not solved |\n";
  return head + line + "---|---|---|---|---|---|---|---|---|---|---|\n";
}

bool
same(const Variation& a, const Variation& b)
{
  return orderOf(a) == orderOf(b);
}

} // namespace

Json
summaryJson(const BenchmarkResults& results)
{
  Json json;
  json["complete"] = results.complete;
  json["rows"] = results.rows.size();
  json["planned"] = results.planned;
  json["run"] = results.run;
  json["settings"] = results.settings;
  json["methods"] = Json::array();
  for (const MethodSummary& summary : results.summaries)
    json["methods"].push_back(methodJson(summary));
  return json;
}

std::string
summaryMarkdown(const BenchmarkResults& results)
{
  std::string text = "# Comparison of registration methods\n";
  if (!results.complete)
    text += format("\n**Partial:** %zu of %zu runs.\n", results.rows.size(), results.planned);
  const MethodSummary* before = nullptr;
  for (const MethodSummary& summary : results.summaries) {
    if (!before || before->dataset != summary.dataset || !same(before->variation, summary.variation))
      text += "\n## " + (summary.dataset.empty() ? std::string("All datasets") : summary.dataset) + ", " +
              describeVariation(summary.variation) + "\n\n" + tableHead();
    text += tableRow(summary);
    before = &summary;
  }
  text += "\nSuccess: the pose is right within the dataset's own bound, whatever the method thinks of it; in brackets\n"
          "Wilson's 95 % interval. Accepted: the method says that its pose may be used; false positives: accepted, and "
          "not\n"
          "right. Medians of the errors are over the pairs that were solved; RMSE is over the correspondences fixed at "
          "the\n"
          "ground truth, in brackets under the ground truth itself. Times are of the method alone, loading excluded. "
          "Log loss\n"
          "and expected calibration error (ten bins) are of the confidence, where a method states one.\n";
  const Json& settings = results.settings;
  if (settings.contains("parameters"))
    text += "\nVersion " + settings.value("version", std::string()) + ", seed " +
            std::to_string(settings.value("seed", std::uint64_t{0})) + ", " +
            std::to_string(settings.value("threads", 0U)) + " threads, time limit " +
            format("%g", settings.value("timeout_s", 0.0)) + " s" + cpuLimitText(settings) +
            ". Parameters:\n\n```json\n" + settings["parameters"].dump(2) + "\n```\n";
  return text;
}

void
writeSummaries(const std::string& folder, const BenchmarkResults& results)
{
  const std::filesystem::path path(folder);
  io::writeFile((path / "summary.json").string(),
                summaryJson(results).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  io::writeFile((path / "summary.md").string(), summaryMarkdown(results));
}

} // namespace apps
} // namespace pcl_ssfr
