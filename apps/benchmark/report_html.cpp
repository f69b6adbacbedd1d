// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/report_html.h>

#include <apps/common/utf8_text.h>
#include <apps/io/file_bytes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;
using GroupKey = std::tuple<std::string, std::string, std::string>; ///< dataset, variation in words, method

constexpr std::array<double, 5> kBoxShares{0.05, 0.25, 0.5, 0.75, 0.95};
constexpr std::size_t kCurvePoints = 49;
constexpr double kLowDegrees = 0.01;
constexpr double kHighDegrees = 180;
constexpr double kLowMetres = 0.001;
constexpr double kHighMetres = 100;
constexpr std::size_t kPrecisionRecallPoints = 200; ///< of a curve; more are not seen
constexpr std::size_t kLongestMessage = 400;        ///< [bytes]
constexpr int kDigits = 5;
constexpr int kPoseDigits = 7;

/// A number with few digits, which JSON then writes as shortly; null when it is not known.
Json
rounded(double value, int digits = kDigits)
{
  if (!std::isfinite(value))
    return nullptr;
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return std::strtod(text.data(), nullptr);
}

/// Names in the order in which they came, numbered.
class Names {
public:
  std::size_t
  place(const std::string& name)
  {
    const auto [entry, is_new] = places_.emplace(name, list_.size());
    if (is_new)
      list_.push_back(name);
    return entry->second;
  }
  const std::vector<std::string>&
  list() const
  {
    return list_;
  }

private:
  std::map<std::string, std::size_t> places_;
  std::vector<std::string> list_;
};

/// Thresholds of a curve, evenly on a logarithmic axis.
std::vector<double>
thresholds(double low, double high)
{
  std::vector<double> values;
  for (std::size_t i = 0; i < kCurvePoints; ++i)
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(kCurvePoints - 1)));
  return values;
}

/// Share of all runs whose error is within each threshold; a run without a pose never is.
Json
shareWithin(std::vector<double> errors, const std::vector<double>& bounds, std::size_t runs)
{
  constexpr double kRounding = 1 + 1e-9; // of the last threshold
  errors.erase(std::remove_if(errors.begin(), errors.end(), [](double e) { return !std::isfinite(e); }), errors.end());
  std::sort(errors.begin(), errors.end());
  Json shares = Json::array();
  for (const double bound : bounds) {
    const auto end = std::upper_bound(errors.begin(), errors.end(), bound * kRounding);
    const auto within = static_cast<double>(end - errors.begin());
    shares.push_back(rounded(within / static_cast<double>(std::max<std::size_t>(runs, 1))));
  }
  return shares;
}

Json
boxOf(const std::vector<double>& values)
{
  Json box = Json::array();
  for (const double share : kBoxShares) {
    const double value = quantile(values, share);
    if (!std::isfinite(value))
      return nullptr;
    box.push_back(rounded(value));
  }
  return box;
}

Json
rateJson(const Rate& rate)
{
  return Json::array({rate.count, rate.of, rounded(rate.interval.low), rounded(rate.interval.high)});
}

Json
precisionRecallJson(const std::vector<PrecisionRecall>& curve)
{
  Json json = Json::array();
  const std::size_t kept = std::min(curve.size(), kPrecisionRecallPoints);
  for (std::size_t i = 0; i < kept; ++i) { // first and last among them
    const PrecisionRecall& point = curve[kept < 2 ? 0 : i * (curve.size() - 1) / (kept - 1)];
    json.push_back({rounded(point.confidence), rounded(point.precision), rounded(point.recall)});
  }
  return json;
}

Json
poseJson(const Eigen::Isometry3d& T)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  const Eigen::Vector3d t = T.translation();
  Json json = Json::array();
  for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()})
    json.push_back(rounded(value, kPoseDigits));
  return json;
}

std::string
base64(const std::vector<std::int16_t>& values)
{
  static constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned> bytes; // low byte first
  for (const std::int16_t value : values) {
    const auto bits = static_cast<std::uint16_t>(value);
    bytes.push_back(bits & 0xffU);
    bytes.push_back(static_cast<unsigned>(bits) >> 8U);
  }
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t j) { return j < bytes.size() ? bytes[j] : 0U; };
    const unsigned group = (bytes[i] << 16U) | (at(i + 1) << 8U) | at(i + 2);
    for (unsigned j = 0; j < 4; ++j)
      text += i + j <= bytes.size() ? kAlphabet[(group >> (18U - 6U * j)) & 63U] : '=';
  }
  return text;
}

/// The rows of each group, and of all datasets together under an empty name.
std::map<GroupKey, std::vector<const ResultRow*>>
groupRows(const std::vector<ResultRow>& rows)
{
  std::map<GroupKey, std::vector<const ResultRow*>> groups;
  for (const ResultRow& row : rows) {
    const std::string variation = describeVariation(row.variation);
    groups[{row.dataset, variation, row.method}].push_back(&row);
    groups[{"", variation, row.method}].push_back(&row);
  }
  return groups;
}

/// A variation but for the settings that the chart of a sweep goes along: points of one line have all else in common.
Variation
restOf(Variation variation)
{
  variation.resolution_m = variation.noise_m = variation.outliers = variation.overlap = 0;
  return variation;
}

Json
groupJson(const MethodSummary& s,
          const std::vector<const ResultRow*>& rows,
          const std::vector<double>& degree_bounds,
          const std::vector<double>& metre_bounds)
{
  std::vector<double> time, degrees, metres;
  for (const ResultRow* row : rows) {
    time.push_back(row->time_s);
    if (row->T_target_source) {
      degrees.push_back(row->rotation_error_deg);
      metres.push_back(row->translation_error_m);
    }
  }
  Json json;
  json["success"] = rateJson(s.success);
  json["within"] = Json::array();
  for (const Rate& rate : s.within)
    json["within"].push_back(rateJson(rate));
  json["converged"] = rateJson(s.converged);
  json["wrong"] = rateJson(s.converged_wrong);
  json["degrees"] = rounded(s.median_rotation_deg);
  json["metres"] = rounded(s.median_translation_m);
  json["rmse"] = rounded(s.median_rmse_m);
  json["truth_rmse"] = rounded(s.median_gt_rmse_m);
  json["time"] = rounded(s.median_time_s);
  json["time90"] = rounded(s.p90_time_s);
  json["cpu"] = rounded(s.median_cpu_s);
  json["memory"] = rounded(s.peak_rss_mib);
  json["failures"] = Json::object();
  for (const auto& [reason, count] : s.failures)
    json["failures"][reason] = count;
  json["precision_recall"] = precisionRecallJson(s.precision_recall);
  json["degree_curve"] = shareWithin(degrees, degree_bounds, rows.size());
  json["metre_curve"] = shareWithin(metres, metre_bounds, rows.size());
  json["time_box"] = boxOf(time);
  json["degree_box"] = boxOf(degrees);
  json["metre_box"] = boxOf(metres);
  return json;
}

/// The rows that are listed: all, or those not solved and as many of the others as fit.
std::vector<const ResultRow*>
chooseRows(const std::vector<ResultRow>& rows)
{
  std::size_t unsolved = 0;
  for (const ResultRow& row : rows)
    unsolved += row.success ? 0 : 1;
  std::size_t room_for_unsolved = std::min(unsolved, kReportRows);
  std::size_t room_for_solved = kReportRows - room_for_unsolved;
  std::vector<const ResultRow*> chosen;
  for (const ResultRow& row : rows) {
    std::size_t& room = row.success ? room_for_solved : room_for_unsolved;
    if (room > 0) {
      --room;
      chosen.push_back(&row);
    }
  }
  return chosen;
}

/// Cut a long text, not within a character of several bytes.
std::string
shortened(const std::string& text)
{
  if (text.size() <= kLongestMessage)
    return text;
  return std::string(utf8Prefix(text, kLongestMessage)) + " ...";
}

/** \brief Poses as they are drawn: of the source's points as they are in the file, between the middles of the scans. */
class Drawing {
public:
  explicit Drawing(const ReportPictures& pictures) : pictures_(pictures)
  {
    for (const ReportPair& pair : pictures.pairs)
      pairs_[{pair.dataset, pair.pair}] = &pair;
  }

  /// Null when the pair is not drawn, or nothing is known of where the source was put.
  Json
  found(const ResultRow& row) const
  {
    const auto start = this->start(row);
    return start && row.T_target_source ? pose(row, *row.T_target_source * *start) : Json(nullptr);
  }
  Json
  before(const ResultRow& row) const
  {
    const auto start = this->start(row);
    return start ? pose(row, *start) : Json(nullptr);
  }

private:
  const ReportPair*
  pairOf(const ResultRow& row) const
  {
    const auto found = isDrawn(row.variation) ? pairs_.find({row.dataset, row.pair}) : pairs_.end();
    return found == pairs_.end() ? nullptr : found->second;
  }
  /// How the source was moved before the method got it: what is between the truth of the files and that of the row.
  std::optional<Eigen::Isometry3d>
  start(const ResultRow& row) const
  {
    const ReportPair* pair = pairOf(row);
    if (!pair)
      return std::nullopt;
    if (row.truth)
      return row.truth->inverse() * pair->T_target_source;
    if (row.variation.perturbation == Perturbation::None)
      return Eigen::Isometry3d::Identity();
    return std::nullopt;
  }
  Json
  pose(const ResultRow& row, const Eigen::Isometry3d& T) const
  {
    const ReportPair& pair = *pairOf(row);
    return between(pair, T);
  }

public:
  Json
  between(const ReportPair& pair, const Eigen::Isometry3d& T) const
  {
    const Eigen::Translation3d from(pictures_.clouds[pair.source].origin);
    const Eigen::Translation3d to(-pictures_.clouds[pair.target].origin);
    return poseJson(to * T * from);
  }

private:
  const ReportPictures& pictures_;
  std::map<std::pair<std::string, std::size_t>, const ReportPair*> pairs_;
};

/// A text between two markers replaced: "@@name@@" by the asset of this name.
std::string
fillTemplate(std::string_view page, const std::string& data)
{
  static constexpr std::string_view kMark = "@@";
  std::string result;
  while (true) {
    const std::size_t begin = page.find(kMark);
    const std::size_t end = begin == std::string_view::npos ? begin : page.find(kMark, begin + kMark.size());
    if (end == std::string_view::npos)
      break;
    const std::string_view name = page.substr(begin + kMark.size(), end - begin - kMark.size());
    std::string_view text = name == "data" ? std::string_view(data) : reportAsset(name);
    if (name != "data") // there is no map next to the page
      text = text.substr(0, text.find("\n//# sourceMappingURL="));
    result.append(page.substr(0, begin)).append(text);
    page.remove_prefix(end + kMark.size());
  }
  return result.append(page);
}

} // namespace

Json
reportJson(const BenchmarkResults& results, const ReportPictures& pictures)
{
  Names datasets, methods, statuses, variations, scans;
  std::vector<Variation> variation_values;
  for (const ResultRow& row : results.rows) {
    datasets.place(row.dataset);
    methods.place(row.method);
    if (variations.place(describeVariation(row.variation)) == variation_values.size())
      variation_values.push_back(row.variation);
  }
  Json json;
  json["run"] = results.run;
  json["settings"] = results.settings;
  json["complete"] = results.complete;
  json["rows_total"] = results.rows.size();
  json["planned"] = results.planned;
  json["bounds"] = Json::array();
  for (const SuccessBound& bound : kSuccessBounds)
    json["bounds"].push_back({bound.rotation_deg, bound.translation_m});
  json["datasets"] = datasets.list();
  json["methods"] = methods.list();
  json["variations"] = Json::array();
  for (const Variation& variation : variation_values)
    json["variations"].push_back({{"text", describeVariation(variation)},
                                  {"resolution", variation.resolution_m},
                                  {"noise", variation.noise_m},
                                  {"outliers", variation.outliers},
                                  {"overlap", variation.overlap},
                                  {"rest", describeVariation(restOf(variation))}});

  const std::vector<double> degree_bounds = thresholds(kLowDegrees, kHighDegrees);
  const std::vector<double> metre_bounds = thresholds(kLowMetres, kHighMetres);
  json["degree_bounds"] = Json::array();
  for (const double bound : degree_bounds)
    json["degree_bounds"].push_back(rounded(bound));
  json["metre_bounds"] = Json::array();
  for (const double bound : metre_bounds)
    json["metre_bounds"].push_back(rounded(bound));
  const auto groups = groupRows(results.rows);
  json["groups"] = Json::array();
  for (const MethodSummary& summary : results.summaries) {
    const std::string variation = describeVariation(summary.variation);
    const auto rows = groups.find({summary.dataset, variation, summary.method});
    if (rows == groups.end())
      continue;
    Json group;
    group["dataset"] = summary.dataset.empty() ? Json(-1) : Json(datasets.place(summary.dataset));
    group["variation"] = variations.place(variation);
    group["method"] = methods.place(summary.method);
    group.update(groupJson(summary, rows->second, degree_bounds, metre_bounds));
    json["groups"].push_back(group);
  }

  const Drawing drawing(pictures);
  std::map<std::tuple<std::string, std::size_t, std::size_t>, Json> before; // by dataset, pair and variation
  json["rows"] = Json::array();
  for (const ResultRow* row : chooseRows(results.rows)) {
    const std::size_t variation = variations.place(describeVariation(row->variation));
    Json& start = before[{row->dataset, row->pair, variation}];
    if (start.is_null())
      start = drawing.before(*row);
    Json fields = Json::array({datasets.place(row->dataset),
                               row->pair,
                               variation,
                               methods.place(row->method),
                               statuses.place(row->status),
                               row->converged ? 1 : 0,
                               row->success ? 1 : 0,
                               scans.place(row->source),
                               scans.place(row->target)});
    for (const double value : {row->rotation_error_deg,
                               row->translation_error_m,
                               row->rmse_m,
                               row->gt_rmse_m,
                               row->overlap,
                               row->confidence,
                               row->time_s,
                               row->cpu_s,
                               row->peak_rss_mib})
      fields.push_back(rounded(value));
    fields.push_back(shortened(row->message));
    fields.push_back(drawing.found(*row));
    fields.push_back(row->lost_at);
    json["rows"].push_back(fields);
  }
  json["statuses"] = statuses.list();
  json["scans"] = scans.list();

  json["clouds"] = Json::array();
  for (const ReportCloud& cloud : pictures.clouds)
    json["clouds"].push_back({{"step", rounded(cloud.step, kPoseDigits)}, {"points", base64(cloud.coordinates)}});
  json["pairs"] = Json::array();
  for (const ReportPair& pair : pictures.pairs) {
    Json starts = Json::object();
    for (std::size_t v = 0; v < variation_values.size(); ++v) {
      const auto start = before.find({pair.dataset, pair.pair, v});
      if (start != before.end() && !start->second.is_null())
        starts[std::to_string(v)] = start->second;
    }
    json["pairs"].push_back({{"dataset", datasets.place(pair.dataset)},
                             {"pair", pair.pair},
                             {"source", pair.source},
                             {"target", pair.target},
                             {"truth", drawing.between(pair, pair.T_target_source)},
                             {"before", starts}});
  }
  return json;
}

std::string
jsonInHtml(const Json& json)
{
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    switch (c) { // none of them stands outside of a string
    case '<':
      result += "\\u003c";
      break;
    case '>':
      result += "\\u003e";
      break;
    case '&':
      result += "\\u0026";
      break;
    default:
      result += c;
    }
  }
  return result;
}

std::string
reportHtml(const BenchmarkResults& results, const ReportPictures& pictures)
{
  return fillTemplate(reportAsset("report.html"), jsonInHtml(reportJson(results, pictures)));
}

void
writeReport(const std::string& folder, const BenchmarkResults& results, const ReportPictures& pictures)
{
  const std::string path = (std::filesystem::path(folder) / "report.html").string();
  io::writeFile(path, reportHtml(results, pictures));
}

} // namespace apps
} // namespace pcl_ssfr
