// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/benchmark_plan.h>

#include <pcl_ssfr/version.h>

#include <apps/common/utf8_text.h>
#include <apps/io/file_bytes.h>
#include <apps/pairs/pair_list.h>
#include <apps/pairs/result_row.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;
using io::IoError;

Json
readJson(const std::string& path)
{
  const std::string text = io::readFile(path);
  try {
    return Json::parse(text);
  }
  catch (const Json::parse_error& error) {
    const std::size_t at = std::min<std::size_t>(error.byte, text.size());
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
    const std::size_t column = at - (before == std::string::npos ? 0 : before + 1);
    throw IoError(path + ":" + std::to_string(line) + ": column " + std::to_string(column) + ": is not JSON");
  }
}

std::vector<BenchmarkMethod>
readExternal(const std::string& path)
{
  const Json json = readJson(path);
  if (!json.is_object())
    throw IoError(path + ": is not a JSON object {\"name\": {\"command\": \"...\"}}");
  std::vector<BenchmarkMethod> result;
  for (const auto& [name, entry] : json.items()) {
    const std::string field = path + ": " + io::inQuotes(name);
    if (name.empty() || name.find(',') != std::string::npos || name == "all")
      throw IoError(field + ": is no name for a method");
    if (findMethod(name))
      throw IoError(field + ": is the name of a method of this program");
    if (!entry.is_object() || !entry.contains("command") || !entry["command"].is_string())
      throw IoError(field + ": has no \"command\" that is a text");
    for (const auto& [key, value] : entry.items())
      if (key != "command" && key != "note")
        throw IoError(field + ": " + io::inQuotes(key) + " is not command or note");
    BenchmarkMethod method;
    method.name = name;
    method.command = entry["command"].get<std::string>();
    try {
      method.words = splitWords(method.command);
    }
    catch (const std::invalid_argument& error) {
      throw IoError(field + ": command: " + error.what());
    }
    if (method.words.empty())
      throw IoError(field + ": command: is empty");
    result.push_back(method);
  }
  return result;
}

BenchmarkMethod
ours(const std::string& name)
{
  BenchmarkMethod method;
  method.name = name;
  return method;
}

/// The methods asked for, each once, in the order asked for.
std::vector<BenchmarkMethod>
chooseMethods(const BenchmarkArguments& arguments)
{
  const std::vector<BenchmarkMethod> external =
      arguments.external.empty() ? std::vector<BenchmarkMethod>() : readExternal(arguments.external);
  std::vector<BenchmarkMethod> chosen;
  const auto add = [&chosen](const BenchmarkMethod& method) {
    for (const BenchmarkMethod& other : chosen)
      if (other.name == method.name)
        return;
    chosen.push_back(method);
  };
  bool names_external = false;
  for (const std::string& name : arguments.methods.empty() ? std::vector<std::string>{"ssfr"} : arguments.methods) {
    if (name == "all") {
      for (const Method& method : methods())
        add(ours(method.name));
      continue;
    }
    const auto other =
        std::find_if(external.begin(), external.end(), [&name](const BenchmarkMethod& m) { return m.name == name; });
    if (other != external.end())
      names_external = true;
    else if (!findMethod(name))
      throw UsageError("--methods: " + io::inQuotes(name) + " " + describeUnknown() +
                       (arguments.external.empty() ? "" : ", nor is it in " + arguments.external));
    add(other != external.end() ? *other : ours(name));
  }
  if (!names_external)
    for (const BenchmarkMethod& method : external)
      add(method);
  return chosen;
}

/// A short text that changes with the content.
std::string
checksum(const std::string& content)
{
  std::uint64_t hash = 1469598103934665603ULL; // FNV-1a
  for (const char c : content)
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

Json
datasetSettings(const io::DatasetFolder& dataset)
{
  namespace fs = std::filesystem;
  Json json;
  json["pairs_checksum"] = checksum(io::readFile((fs::path(dataset.path) / "pairs.csv").string()));
  json["viewpoint"] = dataset.sensor_at_origin ? "sensor" : "unknown";
  json["success_rotation_deg"] = dataset.success_rotation_deg;
  json["success_translation_m"] = dataset.success_translation_m;
  return json;
}

/// Every combination of what the lists ask for.
std::vector<Variation>
variationsOf(const BenchmarkArguments& arguments)
{
  const auto orNone = [](const std::vector<double>& values) {
    return values.empty() ? std::vector<double>{0} : values;
  };
  std::vector<Variation> result;
  for (const double resolution : orNone(arguments.resolutions))
    for (const double noise : orNone(arguments.noises))
      for (const double outliers : orNone(arguments.outliers))
        for (const double overlap : orNone(arguments.overlaps)) {
          Variation variation = arguments.variation;
          variation.resolution_m = resolution;
          variation.noise_m = noise;
          variation.outliers = outliers;
          variation.overlap = overlap;
          result.push_back(variation);
        }
  return result;
}

std::vector<std::size_t>
choosePairs(const BenchmarkArguments& arguments, std::size_t count)
{
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; i += arguments.every)
    if (arguments.pairs.empty() ||
        std::find(arguments.pairs.begin(), arguments.pairs.end(), i) != arguments.pairs.end())
      chosen.push_back(i);
  return chosen;
}

void
planPairs(const BenchmarkArguments& arguments, BenchmarkPlan& plan)
{
  const PairsFrom from = arguments.variation.pairs_from;
  if (from == PairsFrom::Unrelated && plan.datasets.size() < 2)
    throw UsageError("--pairs-from unrelated: needs two datasets or more");
  std::vector<PairList> lists;
  std::size_t longest = 0;
  for (std::size_t d = 0; d < plan.datasets.size(); ++d) {
    const std::size_t next = from == PairsFrom::Unrelated ? (d + 1) % plan.datasets.size() : d;
    lists.emplace_back(plan.datasets[d], plan.datasets[next], from);
    longest = std::max(longest, lists.back().size());
  }
  for (const std::size_t pair : arguments.pairs)
    if (pair >= longest)
      throw UsageError("--pairs: '" + std::to_string(pair) + "' is no row of any dataset; the longest has rows 0 to " +
                       std::to_string(longest - 1));
  std::set<std::string> seen; // a value that a list holds twice is run once
  for (std::size_t d = 0; d < plan.datasets.size(); ++d) {
    const io::DatasetFolder& dataset = plan.datasets[d];
    for (const Variation& variation : variationsOf(arguments)) {
      for (const std::size_t i : choosePairs(arguments, lists[d].size())) {
        const ListedPair& pair = lists[d][i];
        const auto request = lists[d].request(i, variation, arguments.seed);
        if (!request)
          continue; // there is no other scan to merge
        if (variation.overlap > 0 && !pair.T_target_source)
          throw UsageError("--overlap: the pose of " + pair.source + " in " + pair.target + " is not known");
        PlannedPair planned;
        planned.dataset = d;
        planned.pair = i;
        planned.source = pair.source;
        planned.target = pair.target;
        if (from == PairsFrom::Unrelated)
          planned.target_dataset = plan.datasets[(d + 1) % plan.datasets.size()].name;
        planned.request = *request;
        if (seen.insert(rowKey(dataset.name, planned.target_dataset, i, variation, "")).second)
          plan.pairs.push_back(planned);
      }
    }
  }
  if (plan.pairs.empty())
    throw UsageError("--every, --pairs, --pairs-from and --merge-target leave no pair");
}

} // namespace

std::string
BenchmarkPlan::rowKeyOf(const PlannedPair& planned, const std::string& method) const
{
  return rowKey(
      datasets[planned.dataset].name, planned.target_dataset, planned.pair, planned.request.variation, method);
}

std::vector<io::DatasetFolder>
readDatasets(const std::vector<std::string>& paths)
{
  std::vector<io::DatasetFolder> datasets;
  std::map<std::string, std::size_t> uses;
  for (const std::string& path : paths) {
    datasets.push_back(io::readDatasetFolder(path));
    ++uses[datasets.back().name];
  }
  std::set<std::string> names;
  for (io::DatasetFolder& dataset : datasets) {
    if (uses[dataset.name] > 1)
      dataset.name = std::filesystem::weakly_canonical(dataset.path).filename().string();
    dataset.name = validUtf8(dataset.name);
    if (!names.insert(dataset.name).second)
      throw UsageError("--dataset: " + dataset.path + " has the same name as another, " + io::inQuotes(dataset.name));
  }
  return datasets;
}

BenchmarkPlan
makePlan(const BenchmarkArguments& arguments)
{
  BenchmarkPlan plan;
  plan.methods = chooseMethods(arguments);
  plan.run.timeout = arguments.timeout;
  plan.run.cpu_timeout = arguments.cpu_timeout;
  plan.run.threads = arguments.threads;
  plan.run.rmse = arguments.rmse;
  plan.candidates = arguments.candidates;
  if (!arguments.parameters.empty()) {
    try {
      applyParameters(readJson(arguments.parameters), plan.run.rule);
    }
    catch (const std::invalid_argument& error) {
      throw IoError(arguments.parameters + ": " + error.what());
    }
  }
  plan.settings["version"] = PCL_SSFR_VERSION;
  plan.settings["perturb"] = toString(arguments.variation.perturbation);
  plan.settings["seed"] = arguments.seed;
  plan.settings["timeout_s"] = arguments.timeout;
  plan.settings["cpu_timeout_s"] = arguments.cpu_timeout; // 0: none
  plan.settings["threads"] = arguments.threads;
  plan.settings["candidates"] = arguments.candidates;
  plan.settings["rmse"] = arguments.rmse;
  plan.settings["parameters"] = toJson(plan.run.rule);
  plan.settings["datasets"] = Json::object();
  plan.settings["external"] = Json::object();
  plan.datasets = readDatasets(arguments.datasets);
  for (const io::DatasetFolder& dataset : plan.datasets)
    plan.settings["datasets"][dataset.name] = datasetSettings(dataset);
  for (const BenchmarkMethod& method : plan.methods)
    if (!method.words.empty())
      plan.settings["external"][method.name] = method.command;
  planPairs(arguments, plan);
  return plan;
}

} // namespace apps
} // namespace pcl_ssfr
