// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_run.h>

#include "common/stage_names.h"

#include <apps/common/format_text.h>
#include <apps/common/usage_error.h>
#include <apps/io/dataset_folder.h>
#include <apps/io/e57_format.h>
#include <apps/io/file_bytes.h>
#include <apps/io/transform_file.h>
#include <apps/methods/options_json.h>
#include <apps/pairs/pair_list.h>
#include <apps/pairs/result_row.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using io::IoError;

constexpr double kSamePose = 1e-6; ///< largest difference of the numbers of two poses that are the same

/// Options that the kind of input does not take.
void
refuse(const ViewArguments& arguments, const std::vector<std::string>& taken, const std::string& input)
{
  static const std::set<std::string> kAlways{
      "png", "render", "window", "screenshot", "layer", "candidate", "truth", "threads", "help", "version"};
  for (const std::string& name : arguments.given)
    if (!kAlways.count(name) && std::find(taken.begin(), taken.end(), name) == taken.end())
      throw UsageError(std::string("--").append(name).append(" does not go with ").append(input));
}

const std::vector<std::string>&
methodOptionNames()
{
  static const std::vector<std::string> names{"method",
                                              "profile",
                                              "guess",
                                              "guess-tolerance",
                                              "viewpoint",
                                              "gravity",
                                              "gravity-tolerance",
                                              "refine",
                                              "no-refine",
                                              "normal-radius",
                                              "density-radius",
                                              "bin-width",
                                              "leaf",
                                              "min-confidence",
                                              "time-limit"};
  return names;
}

bool
isSame(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < kSamePose * (1 + a.translation().cwiseAbs().maxCoeff());
}

void
runAgain(ViewRun& run, const MethodSettings& settings = {})
{
  Report& report = run.report;
  report.run = runMethod(report.method, run.source, run.target, report.options, report.guess, settings);
  report.peak_rss_mib = peakRssMib();
}

// ---------------------------------------------------------------------------------------------------------------------
// Two scans

ViewRun
runOfScans(const ViewArguments& arguments)
{
  refuse(arguments, methodOptionNames(), "two scans");
  ViewRun run;
  run.source = io::loadCloud(arguments.inputs[0]);
  run.target = io::loadCloud(arguments.inputs[1]);
  run.report.source = arguments.inputs[0];
  run.report.target = arguments.inputs[1];
  run.report.method = arguments.method.method;
  run.report.options = arguments.method.options;
  if (!arguments.method.guess_file.empty())
    run.report.guess = io::readTransform(arguments.method.guess_file);
  runAgain(run);
  run.reference = referencePoint(run.source, run.report.run.result);
  return run;
}

// ---------------------------------------------------------------------------------------------------------------------
// What ssfr_align --json wrote

/// A JSON object whose errors name the file and the key.
class JsonFile {
public:
  explicit JsonFile(std::string path) : path_(std::move(path))
  {
    json_ = Json::parse(io::readFile(path_), nullptr, false);
    if (json_.is_discarded())
      throw IoError(path_ + ": is not JSON");
    if (!json_.is_object())
      throw IoError(path_ + ": is not a JSON object as ssfr_align --json writes it");
  }

  const Json&
  at(const Json& object, const std::string& key) const
  {
    const auto found = object.find(key);
    if (!object.is_object() || found == object.end())
      throw IoError(path_ + ": has no " + io::inQuotes(key));
    return *found;
  }
  const Json&
  at(const std::string& key) const
  {
    return at(json_, key);
  }
  bool
  has(const std::string& key) const
  {
    return json_.contains(key) && !json_[key].is_null();
  }
  std::string
  text(const Json& object, const std::string& key) const
  {
    const Json& value = at(object, key);
    if (!value.is_string())
      throw wrong(key, "is not a text");
    return value.get<std::string>();
  }
  /// A number; null is NaN, or \p fallback when the key is missing and that is given.
  Eigen::Vector3d
  vector(const Json& object, const std::string& key) const
  {
    const Json& values = at(object, key);
    Eigen::Vector3d v;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!values.is_array() || values.size() != 3 || !values[i].is_number())
        throw wrong(key, "is not three numbers");
      v[static_cast<Eigen::Index>(i)] = values[i].get<double>();
    }
    return v;
  }
  double
  number(const Json& object, const std::string& key, std::optional<double> fallback = std::nullopt) const
  {
    if (fallback && !object.contains(key))
      return *fallback;
    const Json& value = at(object, key);
    if (value.is_null())
      return fallback.value_or(std::nan(""));
    if (!value.is_number())
      throw wrong(key, "is not a number");
    return value.get<double>();
  }
  Eigen::Isometry3d
  pose(const Json& object, const std::string& key) const
  {
    try {
      return poseFromJson(at(object, key));
    }
    catch (const std::invalid_argument& error) {
      throw wrong(key, error.what());
    }
  }
  const Json&
  array(const std::string& key) const
  {
    const Json& value = at(key);
    if (!value.is_array())
      throw wrong(key, "is not an array");
    return value;
  }
  const Json&
  root() const
  {
    return json_;
  }
  IoError
  wrong(const std::string& key, const std::string& what) const
  {
    return IoError(path_ + ": " + io::inQuotes(key) + " " + what);
  }

private:
  std::string path_;
  Json json_;
};

Status
statusFromJson(const JsonFile& file)
{
  const std::string name = file.text(file.root(), "status");
  for (int i = static_cast<int>(Status::NotRun); i <= static_cast<int>(Status::TimeLimit); ++i)
    if (name == toString(static_cast<Status>(i)))
      return static_cast<Status>(i);
  throw file.wrong("status", "is " + io::inQuotes(name) + ", which is no status");
}

Result
resultFromJson(const JsonFile& file)
{
  const Json& root = file.root();
  Result result;
  result.status = statusFromJson(file);
  result.message = file.text(root, "message");
  result.T_target_source = file.pose(root, "T_target_source");
  result.overlap = file.number(root, "overlap");
  result.confidence = file.number(root, "confidence", 0);
  result.contradiction = file.number(root, "contradiction", 0);
  result.rmse = file.number(root, "rmse_m", 0);
  for (const Json& entry : file.array("candidates")) {
    Candidate candidate;
    candidate.T_target_source = file.pose(entry, "T_target_source");
    candidate.score = file.number(entry, "score");
    candidate.overlap = file.number(entry, "overlap");
    candidate.contradiction = file.number(entry, "contradiction", 0);
    const auto from_guess = entry.find("from_guess");
    candidate.from_guess = from_guess != entry.end() && *from_guess == true;
    result.candidates.push_back(candidate);
  }
  for (const Json& entry : file.array("stages"))
    result.stages.push_back({file.text(entry, "name"),
                             file.number(entry, "seconds"),
                             static_cast<std::uint64_t>(std::max(0.0, file.number(entry, "in"))),
                             static_cast<std::uint64_t>(std::max(0.0, file.number(entry, "out")))});
  if (file.has("unobservable"))
    for (const Json& entry : file.array("unobservable")) {
      UnobservableDirection open;
      open.rotation = file.text(entry, "kind") == "rotation";
      open.strength = file.number(entry, "strength", 0);
      open.direction = file.vector(entry, "direction");
      result.unobservable.push_back(open);
    }
  const auto readSensor = [&](const std::string& scan, bool& used, bool& found, Eigen::Vector3d& place) {
    used = root.value(scan + "_viewpoint_used", Json()) == true;
    found = root.value(scan + "_viewpoint_found", Json()) == true;
    if (used && file.has(scan + "_viewpoint_m"))
      place = file.vector(root, scan + "_viewpoint_m");
  };
  readSensor("source", result.source_viewpoint_used, result.source_viewpoint_found, result.source_viewpoint);
  readSensor("target", result.target_viewpoint_used, result.target_viewpoint_found, result.target_viewpoint);
  return result;
}

/// Where a scan lies now: as written down, or next to the file that names it.
std::string
findScan(const JsonFile& file, const std::string& json_path, const std::string& key)
{
  const std::string name = file.text(file.root(), key);
  std::error_code error;
  std::vector<fs::path> places;
  if (file.has(key + "_path"))
    places.emplace_back(file.text(file.root(), key + "_path"));
  places.emplace_back(name);
  places.push_back(fs::path(json_path).parent_path() / name);
  places.push_back(fs::path(json_path).parent_path() / fs::path(name).filename());
  for (const fs::path& place : places)
    if (fs::is_regular_file(io::fileOfScan(place.string()), error))
      return place.string();
  throw file.wrong(key, "names " + places.front().string() + ", which is no longer there");
}

/// A scan that was replaced since would be drawn with figures that are not its own. \p scan: "source" or "target"
void
checkPoints(const JsonFile& file, const Result& result, const std::string& scan, const io::LoadedCloud& cloud)
{
  for (const StageReport& stage : result.stages)
    if ((stage.name == scan + " " + kThinningStage || stage.name == scan + "_" + kPaperNormalsStage) &&
        stage.count_in != cloud.points->size())
      throw file.wrong(scan,
                       "had " + std::to_string(stage.count_in) + " points when it was registered, and has " +
                           std::to_string(cloud.points->size()) + " now");
}

ViewRun
runOfJson(const ViewArguments& arguments)
{
  refuse(arguments, {}, "a JSON result, which says how it was made");
  const std::string& path = arguments.inputs[0];
  const JsonFile file(path);
  ViewRun run;
  run.report.method = file.text(file.root(), "method");
  if (!findMethod(run.report.method))
    throw file.wrong("method", "is " + io::inQuotes(run.report.method) + ", which is no method");
  run.report.run.result = resultFromJson(file);
  run.report.run.seconds = file.number(file.root(), "time_s");
  run.report.run.judged = file.has("confidence");
  run.report.loading_seconds = file.number(file.root(), "loading_s", 0);
  run.report.peak_rss_mib = file.number(file.root(), "peak_rss_mib", 0);
  if (file.has("options")) {
    try {
      run.report.options = optionsFromJson(file.at("options"));
    }
    catch (const std::invalid_argument& error) {
      throw file.wrong("options", error.what());
    }
  }
  else {
    run.report.options = makeOptions(run.report.method == "ssfr_paper2017" ? Profile::Paper2017 : Profile::Default);
    run.remarks.emplace_back("The file does not say with which options it was made; the defaults are shown.");
  }
  run.report.options.threads = arguments.method.options.threads;
  if (file.has("guess"))
    run.report.guess = file.pose(file.root(), "guess");
  run.report.source = findScan(file, path, "source");
  run.report.target = findScan(file, path, "target");
  run.source = io::loadCloud(run.report.source);
  run.target = io::loadCloud(run.report.target);
  checkPoints(file, run.report.run.result, "source", run.source);
  checkPoints(file, run.report.run.result, "target", run.target);
  run.reference = referencePoint(run.source, run.report.run.result);
  return run;
}

// ---------------------------------------------------------------------------------------------------------------------
// A pair of a dataset

void
loadInto(ViewRun& run, const PairRequest& request)
{
  PairInput input = loadPair(request);
  run.source = std::move(input.source);
  run.target = std::move(input.target);
  run.truth = input.T_target_source;
  run.reference = input.reference;
  run.report.source = request.source;
  run.report.target = request.target;
  if (!request.sensor_at_origin)
    run.report.options.viewpoint_mode = ViewpointMode::Unknown;
  const std::string variation = describeVariation(request.variation);
  if (variation != describeVariation({}))
    run.remarks.push_back("The pair was varied: " + variation + "; the truth is that of the varied pair.");
}

std::size_t
choosePair(const ViewArguments& arguments, std::size_t count, const std::string& folder)
{
  const std::string rows = count > 0 ? "0 to " + std::to_string(count - 1) : std::string("none");
  if (!arguments.pair)
    throw UsageError("--pair is missing: " + folder + " has the rows " + rows);
  if (*arguments.pair >= count)
    throw UsageError("--pair: '" + std::to_string(*arguments.pair) + "' is no row of " + folder + ", which has " +
                     rows);
  return *arguments.pair;
}

ViewRun
runOfDataset(const ViewArguments& arguments)
{
  std::vector<std::string> taken = methodOptionNames();
  taken.insert(taken.end(), {"pair", "perturb", "seed"});
  refuse(arguments, taken, "a dataset folder");
  const std::string& folder = arguments.inputs[0];
  const io::DatasetFolder dataset = io::readDatasetFolder(folder);
  const std::size_t pair = choosePair(arguments, dataset.pairs.size(), folder);
  Variation variation;
  variation.perturbation = arguments.perturbation;
  const PairRequest request = *PairList(dataset, dataset, PairsFrom::Listed).request(pair, variation, arguments.seed);
  ViewRun run;
  run.report.method = arguments.method.method;
  run.report.options = arguments.method.options;
  run.bound = {dataset.success_rotation_deg, dataset.success_translation_m};
  loadInto(run, request);
  if (!arguments.method.guess_file.empty())
    run.report.guess = io::readTransform(arguments.method.guess_file);
  MethodSettings settings;
  settings.seed = request.seed;
  runAgain(run, settings);
  return run;
}

// ---------------------------------------------------------------------------------------------------------------------
// A pair of ssfr_benchmark's results

std::vector<ResultRow>
readRows(const std::string& path)
{
  const std::string text = io::readFile(path);
  std::vector<ResultRow> rows;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line(text.data() + begin, end - begin);
    begin = end + 1;
    if (++number == 1) {
      if (line != csvHeader())
        throw IoError(path + ":1: is not the header that ssfr_benchmark writes");
      continue;
    }
    if (line.empty())
      continue;
    try {
      rows.push_back(rowFromCsv(line));
    }
    catch (const std::invalid_argument& problem) {
      throw IoError(path + ":" + std::to_string(number) + ": " + problem.what());
    }
  }
  return rows;
}

std::string
listed(const std::set<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Folder of a dataset as the run wrote it down; empty when it did not.
std::string
recordedFolder(const std::string& results, const std::string& dataset)
{
  const fs::path path = fs::path(results) / "summary.json";
  std::error_code error;
  if (!fs::exists(path, error))
    return {};
  const Json json = Json::parse(io::readFile(path.string()), nullptr, false);
  const auto folder = Json::json_pointer("/run/datasets");
  if (!json.is_object() || !json.contains(folder) || !json[folder].is_object() || !json[folder].contains(dataset) ||
      !json[folder][dataset].is_string())
    return {};
  return json[folder][dataset].get<std::string>();
}

/// The row that the arguments ask for.
ResultRow
chooseRow(const ViewArguments& arguments, const std::vector<ResultRow>& rows, const std::string& dataset)
{
  const std::string& folder = arguments.inputs[0];
  std::set<std::string> datasets;
  std::size_t count = 0;
  for (const ResultRow& row : rows)
    if (dataset.empty() || row.dataset == dataset) {
      datasets.insert(row.dataset);
      count = std::max(count, row.pair + 1);
    }
  if (datasets.empty())
    throw UsageError("--dataset: " + io::inQuotes(dataset) + " is not in the results of " + folder);
  if (datasets.size() > 1)
    throw UsageError("--dataset is missing: " + folder + " holds " + listed(datasets));
  const std::size_t pair = choosePair(arguments, count, folder);
  const bool asked = std::find(arguments.given.begin(), arguments.given.end(), "method") != arguments.given.end();
  std::set<std::string> methods;
  const ResultRow* chosen = nullptr;
  for (const ResultRow& row : rows) {
    if (row.dataset != *datasets.begin() || row.pair != pair)
      continue;
    methods.insert(row.method);
    if (!chosen && (row.method == arguments.method.method))
      chosen = &row;
  }
  if (!chosen && !asked && methods.size() == 1)
    for (const ResultRow& row : rows)
      if (row.dataset == *datasets.begin() && row.pair == pair)
        return row;
  if (methods.empty())
    throw UsageError("--pair: " + folder + " has no result of pair " + std::to_string(pair));
  if (!chosen)
    throw UsageError("--method: " + folder + " has results of pair " + std::to_string(pair) + " by " + listed(methods));
  return *chosen;
}

/// What the row says of a method whose run is not repeated.
MethodRun
recordedRun(const ResultRow& row)
{
  MethodRun run;
  Result& result = run.result;
  result.status = row.converged ? Status::Converged : Status::NoCandidate;
  result.message = row.status + (row.message.empty() ? "" : ": " + row.message);
  result.overlap = std::isfinite(row.found_overlap) ? row.found_overlap : 0;
  result.confidence = std::isfinite(row.confidence) ? row.confidence : 0;
  run.judged = std::isfinite(row.confidence);
  run.seconds = row.time_s;
  if (row.T_target_source) {
    result.T_target_source = *row.T_target_source;
    Candidate candidate;
    candidate.T_target_source = *row.T_target_source;
    candidate.score = candidate.overlap = result.overlap;
    result.candidates.push_back(candidate);
  }
  return run;
}

Options
benchmarkOptions(const std::string& results, const std::string& method, unsigned threads)
{
  ParameterRule rule;
  const std::string path = (fs::path(results) / "settings.json").string();
  const Json json = Json::parse(io::readFile(path), nullptr, false);
  if (!json.is_object())
    throw IoError(path + ": is not a JSON object");
  if (json.contains("parameters")) {
    try {
      applyParameters(json["parameters"], rule);
    }
    catch (const std::invalid_argument& error) {
      throw IoError(path + ": parameters: " + error.what());
    }
  }
  Options options = method == "ssfr_paper2017" ? rule.paper2017 : rule.ssfr;
  options.threads = threads;
  return options;
}

void
compareWithRecord(ViewRun& run, const ResultRow& row)
{
  const Result& result = run.report.run.result;
  const bool same_pose = row.T_target_source.has_value() == !result.candidates.empty() &&
                         (!row.T_target_source || isSame(*row.T_target_source, result.T_target_source));
  if (same_pose && row.status == toString(result.status)) {
    run.remarks.emplace_back("The pair was registered again: the same pose as in results.csv.");
    return;
  }
  std::string text =
      "The pair was registered again, and the answer is another than in results.csv, which says " + row.status;
  if (row.T_target_source) {
    const PoseError apart = poseError(*row.T_target_source, result.T_target_source, run.reference);
    text += format(", %.3f deg and %.3f m away", apart.rotation_deg, apart.translation_m);
  }
  run.remarks.push_back(text + ": the results are of another version.");
}

ViewRun
runOfResults(const ViewArguments& arguments)
{
  refuse(arguments, {"pair", "method", "dataset"}, "a results folder, which says how it was made");
  const std::string& folder = arguments.inputs[0];
  const std::string csv = (fs::path(folder) / "results.csv").string();
  const std::vector<ResultRow> rows = readRows(csv);
  std::optional<io::DatasetFolder> dataset;
  if (!arguments.dataset.empty())
    dataset = io::readDatasetFolder(arguments.dataset);
  const ResultRow row = chooseRow(arguments, rows, dataset ? dataset->name : std::string());
  if (!dataset) {
    const std::string recorded = recordedFolder(folder, row.dataset);
    std::error_code error;
    if (recorded.empty() || !fs::is_directory(recorded, error))
      throw UsageError("--dataset is missing: the folder of " + io::inQuotes(row.dataset) +
                       (recorded.empty() ? " is not known" : " was " + recorded + ", which is no longer there"));
    dataset = io::readDatasetFolder(recorded);
  }
  io::DatasetFolder targets = *dataset;
  if (!row.target_dataset.empty()) {
    const std::string recorded = recordedFolder(folder, row.target_dataset);
    if (recorded.empty())
      throw IoError(folder + ": the folder of " + io::inQuotes(row.target_dataset) + " is not known");
    targets = io::readDatasetFolder(recorded);
  }
  const PairList pairs(*dataset, targets, row.variation.pairs_from);
  if (row.pair >= pairs.size() || pairs[row.pair].source != row.source || pairs[row.pair].target != row.target)
    throw IoError(dataset->path + ": row " + std::to_string(row.pair) + " of pairs.csv is not " + row.source + " and " +
                  row.target + ", as in " + csv);
  std::optional<PairRequest> request = pairs.request(row.pair, row.variation, 0);
  if (!request)
    throw IoError(dataset->path + ": no scan can be merged into " + row.target + ", as in " + csv);
  request->seed = row.seed;
  ViewRun run;
  run.report.method = row.method;
  run.report.options = benchmarkOptions(folder, row.method, arguments.method.options.threads);
  run.bound = {dataset->success_rotation_deg, dataset->success_translation_m};
  loadInto(run, *request);
  const Method* method = findMethod(row.method);
  if (!method || method->kind != MethodKind::Ssfr) {
    run.report.run = recordedRun(row);
    run.remarks.emplace_back("The pose is that of results.csv; everything else is what ssfr sees in these scans.");
    return run;
  }
  runAgain(run);
  compareWithRecord(run, row);
  return run;
}

ViewRun
loadAny(const ViewArguments& arguments)
{
  if (arguments.inputs.size() == 2)
    return runOfScans(arguments);
  const std::string& path = arguments.inputs[0];
  std::error_code error;
  if (fs::is_directory(path, error)) {
    if (fs::exists(fs::path(path) / "results.csv", error))
      return runOfResults(arguments);
    if (fs::exists(fs::path(path) / "pairs.csv", error))
      return runOfDataset(arguments);
    throw IoError(path + ": holds neither pairs.csv nor results.csv");
  }
  if (io::isReadableFormat(path))
    throw UsageError("TARGET is missing: " + path + " is one scan");
  return runOfJson(arguments);
}

} // namespace

ViewRun
loadRun(const ViewArguments& arguments)
{
  ViewRun run = loadAny(arguments);
  if (!arguments.truth.empty())
    run.truth = io::readTransform(arguments.truth);
  const std::size_t known = run.report.run.result.candidates.size();
  if (arguments.candidate > std::max<std::size_t>(known, 1))
    throw UsageError("--candidate: '" + std::to_string(arguments.candidate) + "' is more than the " +
                     std::to_string(known) + " that were found");
  return run;
}

} // namespace apps
} // namespace pcl_ssfr
