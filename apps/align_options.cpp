// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/align_options.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/text_scanner.h>
#include <apps/methods.h>

#include <boost/program_options.hpp>

#include <sstream>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;

constexpr unsigned kHelpWidth = 100;
constexpr const char* kDefaultMethod = "ssfr";
constexpr const char* kPaperMethod = "ssfr_paper2017";

std::string
methodNames()
{
  std::string names;
  for (const Method& method : methods())
    names += (names.empty() ? "" : ", ") + method.name;
  return names;
}

/// The option table: parsed, printed by --help, with the defaults of the library.
po::options_description
describeOptions()
{
  const Options defaults = makeOptions(Profile::Default);
  po::options_description results("Results", kHelpWidth);
  results.add_options()("output",
                        po::value<std::string>()->value_name("FILE"),
                        "write the moved source (.pcd or .ply): all its fields, in the coordinates of TARGET")(
      "transform",
      po::value<std::string>()->value_name("FILE"),
      "write T_target_source as 4x4 text; it maps points of SOURCE onto TARGET")(
      "json",
      po::value<std::string>()->value_name("FILE"),
      "write everything that was found as JSON instead of the summary; '-' is the standard output")(
      "pictures",
      po::value<std::string>()->value_name("DIR"),
      "draw before.png and after.png into DIR: both scans from above and from the side");

  po::options_description method("Method", kHelpWidth);
  method.add_options()("method",
                       po::value<std::string>()->value_name("NAME")->default_value(kDefaultMethod),
                       ("one of " + methodNames()).c_str())(
      "profile",
      po::value<std::string>()->value_name("NAME"),
      "default, or paper2017 for the method as published (the same as --method ssfr_paper2017)")(
      "guess",
      po::value<std::string>()->value_name("FILE"),
      "4x4 text: a pose to judge as one more candidate (ssfr), or to start from (icp, gicp, ndt)")(
      "viewpoint",
      po::value<std::string>()->value_name("MODE")->default_value("auto"),
      "auto: decide from the points whether the sensor is at the origin (or at the place that the file gives); sensor: "
      "it "
      "is; unknown: it is not (merged or moved clouds)")(
      "gravity",
      po::value<std::string>()->value_name("X,Y,Z"),
      "up direction in both scans, when it is known: only poses that keep it are considered")("refine",
                                                                                              "polish the pose on the "
                                                                                              "points (the default)")(
      "no-refine", "leave the pose as the histograms give it");

  const auto from_data = [](double value) { return value > 0 ? std::to_string(value) : std::string("from the scans"); };
  po::options_description scales("Scales, in metres; all follow from the scans when they are not given", kHelpWidth);
  scales.add_options()(
      "normal-radius",
      po::value<double>()->value_name("M"),
      ("radius in which a normal is estimated (default: " + from_data(defaults.normal_radius) + ")").c_str())(
      "density-radius",
      po::value<double>()->value_name("CHORD"),
      ("radius of a region on the Gaussian sphere, as a chord of the unit sphere (default: " +
       from_data(defaults.density_radius) + ")")
          .c_str())("bin-width",
                    po::value<double>()->value_name("M"),
                    ("width of the bins of the histograms (default: " + from_data(defaults.bin_width) + ")").c_str())(
      "leaf",
      po::value<double>()->value_name("M"),
      ("spacing that the scans are thinned to (default: " + from_data(defaults.leaf) + ")").c_str());

  std::ostringstream confidence;
  confidence << "accept a pose from this confidence on, 0 to 1 (default: " << defaults.min_confidence << ")";
  po::options_description general("General", kHelpWidth);
  general.add_options()("min-confidence", po::value<double>()->value_name("P"), confidence.str().c_str())(
      "time-limit", po::value<double>()->value_name("S"), "stop after so many seconds (default: no limit)")(
      "threads",
      po::value<int>()->value_name("N")->default_value(0),
      "processors to use, 0: all; the result does not depend on it")("help,h", "print this text")("version",
                                                                                                  "print the version");

  po::options_description all(kHelpWidth);
  all.add(results).add(method).add(scales).add(general);
  return all;
}

Eigen::Vector3d
parseGravity(const std::string& text)
{
  std::vector<double> values;
  for (const auto token : io::splitTokens(text)) {
    const auto value = io::parseNumber(token);
    if (!value)
      throw UsageError("--gravity: " + io::inQuotes(token) + " is not a number");
    values.push_back(*value);
  }
  if (values.size() != 3)
    throw UsageError("--gravity: " + io::inQuotes(text) + " is not x,y,z");
  const Eigen::Vector3d up(values[0], values[1], values[2]);
  if (!up.allFinite() || !(up.norm() > 0))
    throw UsageError("--gravity: " + io::inQuotes(text) + " is not a direction");
  return up.normalized();
}

ViewpointMode
parseViewpoint(const std::string& text)
{
  if (text == "auto")
    return ViewpointMode::Auto;
  if (text == "sensor")
    return ViewpointMode::SensorOrigin;
  if (text == "unknown")
    return ViewpointMode::Unknown;
  throw UsageError("--viewpoint: " + io::inQuotes(text) + " is not auto, sensor or unknown");
}

/// The profile that --method and --profile ask for together.
Profile
chooseProfile(const po::variables_map& values, std::string& method)
{
  if (!values.count("profile"))
    return method == kPaperMethod ? Profile::Paper2017 : Profile::Default;
  const auto& name = values["profile"].as<std::string>();
  if (name != "default" && name != "paper2017")
    throw UsageError("--profile: " + io::inQuotes(name) + " is not default or paper2017");
  const Profile profile = name == "default" ? Profile::Default : Profile::Paper2017;
  if (profile == Profile::Default && method == kPaperMethod)
    throw UsageError("--profile default contradicts --method ssfr_paper2017");
  if (profile == Profile::Paper2017 && method == kDefaultMethod)
    method = kPaperMethod;
  return profile;
}

Options
chooseOptions(const po::variables_map& values, Profile profile)
{
  Options options = makeOptions(profile);
  const auto set = [&values](const char* name, double& target) {
    if (values.count(name))
      target = values[name].as<double>();
  };
  set("normal-radius", options.normal_radius);
  set("density-radius", options.density_radius);
  set("bin-width", options.bin_width);
  set("leaf", options.leaf);
  set("min-confidence", options.min_confidence);
  set("time-limit", options.time_limit);
  options.viewpoint_mode = parseViewpoint(values["viewpoint"].as<std::string>());
  if (values.count("gravity")) {
    GravityPrior gravity;
    gravity.up_source = gravity.up_target = parseGravity(values["gravity"].as<std::string>());
    options.gravity = gravity;
  }
  if (values.count("refine") && values.count("no-refine"))
    throw UsageError("--refine contradicts --no-refine");
  if (values.count("refine"))
    options.refine = true;
  if (values.count("no-refine"))
    options.refine = false;
  const int threads = values["threads"].as<int>();
  if (threads < 0)
    throw UsageError("--threads: '" + std::to_string(threads) + "' is negative");
  options.threads = static_cast<unsigned>(threads);
  try {
    validate(options);
  }
  catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return options;
}

po::variables_map
parseTokens(const std::vector<std::string>& arguments)
{
  po::options_description all = describeOptions();
  all.add_options()("clouds", po::value<std::vector<std::string>>());
  po::positional_options_description positional;
  positional.add("clouds", -1);
  namespace style = po::command_line_style;
  constexpr int kStyle = style::unix_style & ~style::allow_guessing; // an abbreviation is an unknown option
  po::variables_map values;
  try {
    po::store(po::command_line_parser(arguments).options(all).positional(positional).style(kStyle).run(), values);
  }
  catch (const po::error& error) {
    throw UsageError(error.what());
  }
  return values;
}

} // namespace

AlignArguments
parseAlignArguments(const std::vector<std::string>& arguments)
{
  const po::variables_map values = parseTokens(arguments);
  AlignArguments result;
  result.help = values.count("help") > 0;
  result.version = !result.help && values.count("version") > 0;
  if (result.help || result.version)
    return result;
  const auto clouds =
      values.count("clouds") ? values["clouds"].as<std::vector<std::string>>() : std::vector<std::string>();
  if (clouds.size() < 2)
    throw UsageError(clouds.empty() ? "SOURCE and TARGET are missing" : "TARGET is missing");
  if (clouds.size() > 2)
    throw UsageError("unexpected argument " + io::inQuotes(clouds[2]) + ", SOURCE and TARGET are already given");
  result.source = clouds[0];
  result.target = clouds[1];
  const auto set = [&values](const char* name, std::string& target) {
    if (!values.count(name))
      return;
    target = values[name].as<std::string>();
    if (target.empty())
      throw UsageError(std::string("--") + name + ": the value is empty");
  };
  set("output", result.output);
  set("transform", result.transform);
  set("json", result.json);
  set("pictures", result.pictures);
  set("guess", result.guess_file);
  set("method", result.method);
  if (!result.output.empty() && !io::isWritableFormat(result.output))
    throw UsageError("--output: " + result.output + " is not a .pcd or .ply file");
  if (!findMethod(result.method))
    throw UsageError("--method: " + io::inQuotes(result.method) + " is not one of " + methodNames());
  const Profile profile = chooseProfile(values, result.method);
  result.options = chooseOptions(values, profile);
  return result;
}

std::string
alignHelp()
{
  std::ostringstream text;
  text << "Usage: ssfr_align SOURCE TARGET [options]\n\n"
          "Finds where the scan SOURCE lies in the frame of the scan TARGET, whatever their positions: two LiDAR scans "
          "of\n"
          "the same rooms, halls or streets, which overlap in part. No initial guess and no parameter is needed.\n\n"
          "Scans are read by their extension: "
       << io::readableFormats()
       << "\n(.csv as in the ASL/ETH data sets, .3d of 3DTK, .bin of KITTI, .las without compression). Points are in "
          "metres.\n\n"
          "Examples:\n"
          "  ssfr_align scan2.pcd scan1.pcd                          print the pose and how sure it is\n"
          "  ssfr_align scan2.pcd scan1.pcd --output moved.pcd       write scan2 in the frame of scan1\n"
          "  ssfr_align scan2.las scan1.las --json - --pictures out  for scripts, with pictures to look at\n\n"
       << describeOptions() << "\nMethods:\n";
  for (const Method& method : methods())
    text << "  " << method.name << std::string(20 - method.name.size(), ' ') << method.description << '\n';
  text << "\nExit code: 0 aligned; 1 ran, but no pose is certain enough (the reason is printed, --output and "
          "--transform are\n"
          "not written); 2 the command line is wrong; 3 a file cannot be read or written.\n";
  return text.str();
}

} // namespace apps
} // namespace pcl_ssfr
