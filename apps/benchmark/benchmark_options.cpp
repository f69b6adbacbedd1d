// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/benchmark_options.h>

#include <apps/common/command_line.h>
#include <apps/io/text_scanner.h>
#include <apps/methods/method_parameters.h>
#include <apps/methods/method_registry.h>
#include <apps/methods/option_numbers.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;

constexpr unsigned kMaxJobs = 1024;
constexpr double kWallPerCpu = 10; ///< a method that waits, for a busy machine or for ever, ends too
constexpr std::uint64_t kMaxPictures = 100000;

po::options_description
describeOptions()
{
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  po::options_description run("What is run", kHelpWidth);
  // clang-format off
  run.add_options()
      ("dataset", po::value<std::vector<std::string>>()->value_name("DIR...")->multitoken()->composing(),
       "dataset folders: pairs.csv with source, target and ground truth T00..T33, scans next to it or in scans/")
      ("methods", po::value<std::vector<std::string>>()->value_name("A,B,...")->multitoken()->composing(),
       "methods to compare, or all (default: ssfr)")
      ("external", text("FILE"),
       "JSON {\"name\": {\"command\": \"prog {source} {target}\"}}: programs to compare with. They are run without a "
       "shell; the last JSON line that they print holds T or T_target_source (4x4), and optionally time_s, converged, "
       "confidence. All of them are run, or those that --methods names")
      ("every", text("K"), "take every K-th pair of each dataset")
      ("pairs", text("I,J,..."), "take these rows of each pairs.csv, counted from 0")
      ("pairs-from", text("KIND"),
       "listed (default): the pairs of pairs.csv; unlisted: all ordered pairs that chains of listed pairs connect, but "
       "for the listed ones; all: every unordered pair of the scans that pairs.csv names; unrelated: the sources with "
       "the targets of the next --dataset, where every accepted answer is a false positive")
      ("parameters", text("FILE"), "JSON that overrides the rule of parameters, see below");
  po::options_description input("What is done to the scans first", kHelpWidth);
  input.add_options()
      ("perturb", text("KIND"),
       "none (default), rotation: rotate each source at random about its origin, se3: rotate and translate it; ground "
       "truth follows")
      ("random-rotation", "the same as --perturb rotation")
      ("seed", text("S"), "of all random numbers (default: 1)")
      ("resolution", text("R1,R2,..."), "thin both scans to this spacing [m], one run each; 0: as they are")
      ("noise", text("S1,S2,..."), "add Gaussian noise of this size to the source [m]")
      ("overlap", text("F1,F2,..."), "cut the target until only this share of the source has a counterpart, below 1; "
       "0: as it is")
      ("outliers", text("F1,F2,..."), "replace this share of the source by uniform noise, from 0 to below 1")
      ("origin-offset", text("M"), "move both origins this far from the sensors, which is not reported to any method [m]")
      ("merge-target",
       "lay the source of another pair into each target, which has no single viewpoint then; pairs without such are left "
       "out")
      ("mirror-source", "mirror each source, as a left-handed file is: every accepted answer is a false positive")
      ("degrade-every", text("K"), "keep every K-th point of each source")
      ("degrade-sector", text("DEG"), "keep a sector of each source of this width about the z axis of its sensor, at a "
       "random place [deg]")
      ("degrade-nearest", text("SHARE"), "keep this share of each source, the points nearest to its sensor, 0 to 1");
  po::options_description how("How it is run", kHelpWidth);
  how.add_options()
      ("out", text("DIR"), "folder for results.csv, candidates.csv, settings.json, summary.json, summary.md, report.html")
      ("candidates", "write candidates.csv too: every pose that a method considered, with the evidence for it")
      ("no-rmse", "leave overlap, rmse_m and gt_rmse_m empty: most of the time of a short run goes into them")
      ("resume", "go on with the results in DIR: what is done is not run again")
      ("report-only", "run nothing: write the reports of the results in DIR again; with --dataset, with pictures")
      ("pictures", text("N"), "pairs that report.html shows pictures of, those that most methods failed on first "
       "(default: 60)")
      ("jobs", text("N"), "methods run at the same time, each in a process of its own (default: 1)")
      ("threads", text("N"), "processors of each method (default: 1; 0: all)")
      ("timeout", text("S"), "seconds of wall clock after which a method is killed, loading not counted (default: 300; "
       "ten times --cpu-timeout where that is more)")
      ("cpu-timeout", text("S"), "seconds of processor time, of all its threads and children, after which a method is "
       "killed: the same limit however busy the machine is (default: none)")
      ("help,h", "print this text")
      ("version", "print the version");
  // clang-format on
  po::options_description all(kHelpWidth);
  all.add(run).add(input).add(how);
  return all;
}

std::vector<std::string>
splitList(const std::string& text)
{
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');)
    parts.push_back(part);
  return parts;
}

/// An argument as a shell would have to read it.
std::string
inShell(const std::string& argument)
{
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string("-_./,:=+@%").find(c) != std::string::npos;
  };
  if (!argument.empty() && std::all_of(argument.begin(), argument.end(), is_plain))
    return argument;
  std::string text = "'";
  for (const char c : argument)
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// Options of one value each, by name.
class Values {
public:
  explicit Values(const po::variables_map& map) : map_(map) {}

  std::string
  text(const char* name, const std::string& fallback = {}) const
  {
    return map_.count(name) == 0 ? fallback : textOf(map_, name);
  }
  std::uint64_t
  count(const char* name, std::uint64_t fallback, std::uint64_t low, std::uint64_t high) const
  {
    return map_.count(name) == 0 ? fallback : parseWhole(std::string("--") + name, text(name), low, high);
  }
  std::vector<std::size_t>
  counts(const char* name) const
  {
    std::vector<std::size_t> values;
    for (const std::string& part : splitList(text(name)))
      values.push_back(parseWhole(std::string("--") + name, part, 0, std::uint64_t{1} << 40));
    return values;
  }
  double
  number(const char* name, double fallback, double low, double high) const
  {
    return map_.count(name) == 0 ? fallback : parsed(name, text(name), low, high);
  }
  /// Numbers in [low, high).
  std::vector<double>
  numbers(const char* name, double high) const
  {
    std::vector<double> values;
    for (const std::string& part : splitList(text(name)))
      values.push_back(parsed(name, part, 0.0, high));
    return values;
  }

private:
  static double
  parsed(const char* name, const std::string& value, double low, double high)
  {
    const auto number = io::parseNumber(value);
    if (!number || !(*number >= low && *number < high)) {
      std::ostringstream text;
      text << "--" << name << ": " << io::inQuotes(value) << " is not a number from " << low << " to below " << high;
      throw UsageError(text.str());
    }
    return *number;
  }

  const po::variables_map& map_;
};

/// What is not varied by a list.
Variation
readVariation(const po::variables_map& map, const Values& values)
{
  constexpr double kFarthest = 1e6;   // [m]
  constexpr double kFullCircle = 360; // [deg]
  constexpr double kLeast = 1e-3;     // of what must not be zero
  const auto upTo = [](double high) { return std::nextafter(high, 2 * high); };
  const auto parsed = [&values](const char* name, auto parse, const char* fallback) {
    try {
      return parse(values.text(name, fallback));
    }
    catch (const std::invalid_argument& error) {
      throw UsageError(std::string("--") + name + ": " + error.what());
    }
  };
  Variation variation;
  variation.perturbation = parsed("perturb", parsePerturbation, "none");
  if (map.count("random-rotation") > 0) {
    if (map.count("perturb") > 0 && variation.perturbation != Perturbation::Rotation)
      throw UsageError(std::string("--random-rotation contradicts --perturb ") + toString(variation.perturbation));
    variation.perturbation = Perturbation::Rotation;
  }
  variation.pairs_from = parsed("pairs-from", parsePairsFrom, "listed");
  variation.origin_offset_m = values.number("origin-offset", 0, 0, kFarthest);
  variation.merge_target = map.count("merge-target") > 0;
  variation.mirror_source = map.count("mirror-source") > 0;
  Degradation& degradation = variation.degradation;
  degradation.every = values.count("degrade-every", 1, 1, std::uint64_t{1} << 40);
  degradation.sector_deg = values.number("degrade-sector", kFullCircle, kLeast, upTo(kFullCircle));
  degradation.nearest = values.number("degrade-nearest", 1, kLeast, upTo(1));
  return variation;
}

} // namespace

BenchmarkArguments
parseBenchmarkArguments(const std::vector<std::string>& arguments)
{
  const po::variables_map map = parseCommandLine(arguments, describeOptions());
  BenchmarkArguments result;
  if (asksForText(map, result))
    return result;
  constexpr double kFar = 1e6;       // [m] and [s]
  constexpr double kShortest = 1e-3; // [s]
  const Values values(map);
  result.report_only = map.count("report-only") > 0;
  if (map.count("dataset") == 0 && !result.report_only)
    throw UsageError("--dataset is missing");
  if (map.count("out") == 0)
    throw UsageError("--out is missing");
  result.datasets = textsOf(map, "dataset");
  if (map.count("methods") > 0) {
    for (const std::string& list : textsOf(map, "methods"))
      for (const std::string& name : splitList(list))
        result.methods.push_back(name);
    if (result.methods.empty())
      throw UsageError("--methods: the value is empty");
  }
  result.out = values.text("out");
  result.external = values.text("external");
  result.parameters = values.text("parameters");
  result.resume = map.count("resume") > 0;
  result.pictures = values.count("pictures", result.pictures, 0, kMaxPictures);
  result.command = "ssfr_benchmark";
  for (const std::string& argument : arguments)
    result.command += " " + inShell(argument);
  result.jobs = static_cast<unsigned>(values.count("jobs", 1, 1, kMaxJobs));
  result.threads = static_cast<unsigned>(values.count("threads", 1, 0, kMaxThreads));
  result.every = values.count("every", 1, 1, std::uint64_t{1} << 40);
  if (map.count("pairs") > 0)
    result.pairs = values.counts("pairs");
  result.cpu_timeout = map.count("cpu-timeout") > 0 ? values.number("cpu-timeout", 0, kShortest, kFar) : 0;
  result.timeout =
      values.number("timeout", std::max(result.timeout, kWallPerCpu * result.cpu_timeout), kShortest, kFar);
  result.seed = values.count("seed", result.seed, 0, std::uint64_t{1} << 53);
  result.candidates = map.count("candidates") > 0;
  result.rmse = map.count("no-rmse") == 0;
  result.variation = readVariation(map, values);
  result.resolutions = values.numbers("resolution", kFar);
  result.noises = values.numbers("noise", kFar);
  result.overlaps = values.numbers("overlap", 1);
  result.outliers = values.numbers("outliers", 1);
  return result;
}

std::string
benchmarkHelp()
{
  std::ostringstream text;
  text << "Usage: ssfr_benchmark --dataset DIR... --methods A,B,...|all --out DIR [options]\n\n"
          "Runs registration methods on pairs of scans whose true pose is known, each in a process of its own, and "
          "says\n"
          "who succeeds, how exactly, how fast, with how much memory, and who accepts a wrong pose. Every result "
          "is\n"
          "in results.csv as soon as it is there; a run that was stopped or killed goes on with --resume.\n\n"
          "Example:\n"
          "  ssfr_benchmark --dataset data --methods ssfr,icp_point_to_plane,fpfh_ransac --perturb rotation --out out\n"
          "On a cluster, with MPI: mpirun -n 64 ssfr_benchmark ...; rank 0 deals out the pairs and writes.\n\n"
       << describeOptions() << "\nMethods:\n";
  for (const Method& method : methods())
    text << "  " << method.name << std::string(20 - method.name.size(), ' ') << method.description << '\n';
  text << "\nParameters of all methods but ssfr, which needs none, follow from the two scans by one rule: the leaf is "
          "the\n"
          "smaller radius of the two times leaf_share, grown until voxels hold min_points_per_voxel points; every "
          "other\n"
          "length is a multiple of it. --parameters FILE changes the rule: {\"name\": number, ...,\n"
          "\"ssfr\": {\"normal_radius\": m, ...}}.\n";
  const ParameterRule rule;
  for (const Parameter& parameter : parameterTable())
    text << "  " << parameter.name << std::string(22 - std::string(parameter.name).size(), ' ') << parameter.meaning
         << " (" << rule.*(parameter.value) << ")\n";
  text << "\nExit code: 0 all was run, whatever the methods made of it; 2 the command line is wrong; 3 a file cannot "
          "be\n"
          "read or written; 130 or 143 stopped by Ctrl-C or a request to end: the report covers what was run.\n";
  return text.str();
}

} // namespace apps
} // namespace pcl_ssfr
