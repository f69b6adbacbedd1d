// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/simulate_options.h>

#include <apps/common/command_line.h>
#include <apps/common/degrees.h>
#include <apps/io/io_error.h>
#include <apps/io/text_scanner.h>
#include <apps/simulation/dataset_writer.h>
#include <apps/simulation/paper_sets.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

namespace po = boost::program_options;

using apps::kHelpWidth;
using apps::UsageError;

constexpr double kMostScans = 100000;
constexpr double kMostBeams = 1e9;
constexpr double kMostSeed = 9007199254740992.0; // 2^53

/// An option with a number: what --help says, and where its values end.
struct NumberOption {
  const char* name;
  const char* unit;
  const char* description;
  double low;
  double high;
  bool whole;
};

constexpr NumberOption kNumbers[] = {
    {"scans", "N", "number of scans", 1, kMostScans, true},
    {"storeys", "N", "storeys of tower, levels of car_park_levels", 2, kMostStoreys, true},
    {"seed",
     "S",
     "another seed is another scene, walk and noise; the same one gives the same bytes",
     0,
     kMostSeed,
     true},
    {"start", "K", "number of the first scan: leaves out the first K of the same walk", 0, kMostScans, true},
    {"points",
     "N",
     "beams a scan, both directions of the grid scaled alike (default: as the sensor)",
     1,
     kMostBeams,
     true},
    {"step",
     "M",
     "distance of consecutive scans along the scene's path (default: the scene's own)",
     0.001,
     10000,
     false},
    {"overlap", "X", "wanted overlap of consecutive scans, decides the step", 0.01, 0.99, false},
    {"turn", "DEG", "largest change of heading between scans, beyond that of the path", 0, 180, false},
    {"turn-limit", "DEG", "rotate no farther between scans, whatever the path does", 0.1, 180, false},
    {"tilt", "DEG", "largest roll and pitch", 0, 90, false},
    {"velocity", "M/S", "drive forward while scanning: scans are distorted by motion", -100, 100, false},
    {"turn-rate", "DEG/S", "rotation about the sensor's z while scanning", -3600, 3600, false},
    {"people", "N", "people, who stand somewhere else in every scan", 0, 1000, true},
    {"shut-doors", "X", "share of the doors that are shut in every scan", 0, 1, false},
    {"moved-furniture",
     "X",
     "share of loose things (chairs, boxes, parked cars) that stand elsewhere in every scan",
     0,
     1,
     false},
    {"threads", "N", "processors to use, 0: all; the result does not depend on it", 0, 1024, true},
};

const NumberOption&
numberOption(const std::string& name)
{
  return *std::find_if(std::begin(kNumbers), std::end(kNumbers), [&](const NumberOption& o) { return o.name == name; });
}

std::string
joined(const std::vector<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string
formatNumber(double value)
{
  std::ostringstream text;
  text.precision(16);
  text << value;
  return text.str();
}

/// The option table: parsed and printed by --help.
po::options_description
describeOptions()
{
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  const auto add_number = [&text](po::options_description& group, const char* name, const std::string& shown = "") {
    const NumberOption& option = numberOption(name);
    const std::string help = option.description + (shown.empty() ? "" : " (default: " + shown + ")");
    group.add_options()(name, text(option.unit), help.c_str());
  };
  const DatasetPlan defaults;
  po::options_description what("What is simulated", kHelpWidth);
  what.add_options()("scene", text("NAME|FILE"), "a scene of --list, or a mesh (.obj, .ply, .stl; metres, z up)")(
      "sensor",
      text("NAME|FILE"),
      "a sensor of --list, or a .json file (default: what suits the scene); several with commas: scans take them in "
      "turn")("paper-set", text("NAME"), ("instead of both: " + joined(paperSetNames())).c_str())(
      "reduced", "the small version of a paper set: three scans of less than 2 MB");
  add_number(what, "scans", std::to_string(defaults.trajectory.scans));
  what.add_options()("stations",
                     "instead: one scan at each place where a surveyor would put up a scanner in the scene");
  add_number(what, "seed", std::to_string(defaults.seed));
  add_number(what, "start", std::to_string(defaults.start));
  add_number(what, "points");
  add_number(what, "storeys");
  what.add_options()("alike", "storeys, rooms, wings and bays of a scene repeat exactly, furniture included");

  po::options_description motion("How the sensor moves", kHelpWidth);
  add_number(motion, "step");
  add_number(motion, "overlap");
  add_number(motion, "turn", formatNumber(std::round(defaults.trajectory.turn * kDegreesPerRadian * 10) / 10));
  add_number(motion, "turn-limit");
  add_number(motion, "tilt", formatNumber(defaults.trajectory.tilt * kDegreesPerRadian));
  motion.add_options()("random-rotation", "give every scan in a randomly rotated frame of its own");
  add_number(motion, "velocity", formatNumber(defaults.velocity));
  add_number(motion, "turn-rate", formatNumber(defaults.turn_rate * kDegreesPerRadian));

  po::options_description changes("What changes, and what is measured", kHelpWidth);
  add_number(changes, "people", std::to_string(defaults.movables.people));
  changes.add_options()("doors", "every door stands at another angle in every scan (default: all wide open)");
  add_number(changes, "shut-doors", formatNumber(defaults.movables.shut_doors));
  add_number(changes, "moved-furniture", formatNumber(defaults.movables.moved_furniture));
  changes.add_options()("no-noise", "exact ranges on exact beams");

  po::options_description output("Output", kHelpWidth);
  output.add_options()("out", text("DIR"), "the dataset folder; written completely or not at all")(
      "pairs", text("RULE"), "pairs in pairs.csv: consecutive, all, or N: scans up to N apart (default: consecutive)")(
      "overwrite", "replace an existing dataset when the new one is complete")(
      "pictures", text("DIR"), "draw the scene and the places of the scans into DIR, which is not in that of --out")(
      "quiet", "no progress and no summary");

  po::options_description general("General", kHelpWidth);
  add_number(general, "threads", "0");
  general.add_options()("list", "list scenes, sensors and paper sets")(
      "print-sensor", text("NAME|FILE"), "print a sensor as JSON, to change it and use it with --sensor FILE.json")(
      "help,h", "print this text")("version", "print the version");

  po::options_description all(kHelpWidth);
  all.add(what).add(motion).add(changes).add(output).add(general);
  return all;
}

po::variables_map
parseTokens(const std::vector<std::string>& arguments)
{
  try {
    return apps::parseCommandLine(arguments, describeOptions());
  }
  catch (const apps::UnexpectedArgument&) {
    throw UsageError("unexpected argument: only options are taken");
  }
}

/// The values of the command line, checked.
class Values {
public:
  explicit Values(const po::variables_map& map) : map_(map) {}

  bool
  has(const char* name) const
  {
    return map_.count(name) > 0;
  }
  /// A text that is not empty; empty when it is not given.
  std::string
  text(const char* name) const
  {
    return apps::textOf(map_, name);
  }
  /// Set \p target to a number of its table entry divided by \p unit, when it is given.
  template <typename Number>
  void
  number(const char* name, Number& target, double unit = 1) const
  {
    if (!has(name))
      return;
    const NumberOption& option = numberOption(name);
    const std::string value = text(name);
    const auto parsed = io::parseNumber(value);
    const std::string message = std::string("--") + name + ": " + io::inQuotes(value) + " is not ";
    if (!parsed || !std::isfinite(*parsed))
      throw UsageError(message + "a number");
    if (option.whole && *parsed != std::floor(*parsed))
      throw UsageError(message + "a whole number");
    if (*parsed < option.low || *parsed > option.high)
      throw UsageError(message + "between " + formatNumber(option.low) + " and " + formatNumber(option.high));
    target = static_cast<Number>(*parsed / unit);
  }

private:
  const po::variables_map& map_;
};

/// Throws unless \p value is one of \p names or the name of a file.
void
checkName(const char* option, const std::string& value, const std::vector<std::string>& names, const char* file)
{
  if (std::find(names.begin(), names.end(), value) != names.end())
    return;
  if (file && (std::filesystem::path(value).has_extension() || value.find('/') != std::string::npos))
    return;
  throw UsageError(std::string("--") + option + ": " + io::inQuotes(value) + " is not one of " + joined(names) +
                   (file ? std::string(", and not ") + file : ""));
}

/// The plan of --paper-set, or an empty one for --scene and --sensor.
DatasetPlan
basePlan(const Values& values)
{
  DatasetPlan plan;
  if (!values.has("paper-set")) {
    if (!values.has("scene"))
      throw UsageError("--scene or --paper-set is missing");
    if (values.has("reduced"))
      throw UsageError("--reduced is only for --paper-set");
    plan.scene = values.text("scene");
    checkName("scene", plan.scene, sceneNames(), "a mesh file");
    plan.sensor = values.text("sensor");
    for (const std::string& name : sensorsOf(plan.sensor))
      checkName("sensor", name, sensorNames(), "a .json file");
    if (plan.sensor.find(',') != std::string::npos && sensorsOf(plan.sensor).size() > 1 && values.has("overlap"))
      throw UsageError("--overlap contradicts several sensors, which have an overlap each: give --step");
    values.number("storeys", plan.scene_options.storeys);
    plan.scene_options.alike = values.has("alike");
    return plan;
  }
  const std::string set = values.text("paper-set");
  checkName("paper-set", set, paperSetNames(), nullptr);
  plan = makePaperSet(set, values.has("reduced")).plan;
  for (const char* fixed : {"scene",
                            "sensor",
                            "points",
                            "step",
                            "overlap",
                            "turn",
                            "turn-limit",
                            "tilt",
                            "start",
                            "storeys",
                            "alike",
                            "stations"})
    if (values.has(fixed))
      throw UsageError(std::string("--") + fixed + " contradicts --paper-set, which decides it");
  for (const char* fixed : {"scans", "pairs"})
    if (!plan.motions.empty() && values.has(fixed))
      throw UsageError(std::string("--") + fixed + " contradicts --paper-set " + set + ", which decides it");
  return plan;
}

void
choosePairs(const Values& values, DatasetPlan& plan)
{
  const std::string rule = values.text("pairs");
  if (rule.empty())
    return;
  const auto reach = io::parseCount(rule);
  if (rule == "all")
    plan.pair_reach = kAllPairs;
  else if (rule == "consecutive")
    plan.pair_reach = 1;
  else if (reach && *reach >= 1)
    plan.pair_reach = static_cast<int>(std::min<std::uint64_t>(*reach, kAllPairs));
  else
    throw UsageError("--pairs: " + io::inQuotes(rule) + " is not consecutive, all or a number of at least 1");
}

DatasetPlan
choosePlan(const Values& values)
{
  DatasetPlan plan = basePlan(values);
  values.number("scans", plan.trajectory.scans);
  plan.at_stations = values.has("stations");
  for (const char* other : {"scans", "step", "overlap"})
    if (plan.at_stations && values.has(other))
      throw UsageError(std::string("--") + other + " contradicts --stations, which decides it");
  values.number("seed", plan.seed);
  values.number("start", plan.start);
  values.number("points", plan.beams);
  values.number("step", plan.trajectory.step);
  values.number("overlap", plan.trajectory.overlap);
  if (values.has("step") && values.has("overlap"))
    throw UsageError("--step contradicts --overlap, which decides it");
  if (plan.start > 0 && values.has("overlap"))
    throw UsageError("--start contradicts --overlap: the step depends on all scans of the walk, give --step");
  values.number("turn", plan.trajectory.turn, kDegreesPerRadian);
  values.number("turn-limit", plan.turn_limit, kDegreesPerRadian);
  if (values.has("turn-limit") && values.has("overlap"))
    throw UsageError("--turn-limit contradicts --overlap, which is that of scans that look along the path");
  values.number("tilt", plan.trajectory.tilt, kDegreesPerRadian);
  values.number("velocity", plan.velocity);
  values.number("turn-rate", plan.turn_rate, kDegreesPerRadian);
  values.number("people", plan.movables.people);
  values.number("shut-doors", plan.movables.shut_doors);
  values.number("moved-furniture", plan.movables.moved_furniture);
  plan.movables.doors_move = values.has("doors");
  plan.random_rotation = values.has("random-rotation");
  if (values.has("no-noise"))
    plan.noise = false;
  choosePairs(values, plan);
  return plan;
}

/// Whether a folder is another one or lies below it; false where that cannot be known.
bool
isWithin(const std::string& folder, const std::string& other)
{
  std::error_code error;
  const std::filesystem::path inner = resolvedFolder(folder, error);
  const std::filesystem::path outer = error ? std::filesystem::path() : resolvedFolder(other, error);
  return !error && std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

} // namespace

SimulateArguments
parseSimulateArguments(const std::vector<std::string>& arguments)
{
  const po::variables_map map = parseTokens(arguments);
  const Values values(map);
  SimulateArguments result;
  if (apps::asksForText(map, result))
    return result;
  result.list = values.has("list");
  if (result.list)
    return result;
  result.print_sensor = values.text("print-sensor");
  if (!result.print_sensor.empty()) {
    checkName("print-sensor", result.print_sensor, sensorNames(), "a .json file");
    return result;
  }
  result.plan = choosePlan(values);
  result.out = values.text("out");
  result.pictures = values.text("pictures");
  if (result.out.empty() && result.pictures.empty())
    throw UsageError("--out is missing");
  if (!result.out.empty() && !result.pictures.empty() && isWithin(result.pictures, result.out))
    throw UsageError("--pictures: " + io::inQuotes(result.pictures) +
                     " lies in --out, which holds a dataset and nothing else; take another folder");
  result.overwrite = values.has("overwrite");
  result.quiet = values.has("quiet");
  values.number("threads", result.threads);
  return result;
}

std::string
simulateHelp()
{
  std::ostringstream text;
  text << "Usage: ssfr_simulate --scene NAME [--sensor NAME] [--scans N] [--seed S] --out DIR [options]\n"
          "       ssfr_simulate --paper-set NAME [--reduced] --out DIR [options]\n\n"
          "Simulates LiDAR scans of a scene and writes them with their exact poses: DIR/scans/scanNNN.pcd (binary, in "
          "the\n"
          "frame of the sensor), DIR/pairs.csv (pairs and true transforms), DIR/poses.txt, DIR/dataset.json.\n\n"
          "Examples:\n"
          "  ssfr_simulate --scene apartment --sensor velodyne_vlp16 --scans 5 --out flat     five scans on a walk\n"
          "  ssfr_simulate --paper-set ds1h --random-rotation --out ds1h                      one of the paper's sets\n"
          "  ssfr_simulate --scene my_hall.obj --sensor my_sensor.json --overlap 0.5 --out x  your building, your "
          "sensor\n\n"
       << describeOptions()
       << "\nExit code: 0 done; 2 the command line is wrong, or asks for what the scene does not allow; 3 a file "
          "cannot be\n"
          "read or written.\n";
  return text.str();
}

std::string
simulateList()
{
  constexpr std::size_t kColumn = 18;
  std::ostringstream text;
  const auto line = [&text](const std::string& name, const std::string& description) {
    text << "  " << name << std::string(kColumn - std::min(kColumn - 1, name.size()), ' ') << description << '\n';
  };
  text << "Scenes:\n";
  for (const std::string& name : sceneNames())
    line(name, makeScene(name, DatasetPlan{}.seed).description);
  text << "\nSensors:\n";
  for (const std::string& name : sensorNames())
    line(name, makeSensor(name).description);
  text << "\nPaper sets:\n";
  for (const std::string& name : paperSetNames())
    line(name, makePaperSet(name, false).description);
  return text.str();
}

} // namespace pcl_ssfr::simulation
