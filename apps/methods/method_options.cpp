// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/method_options.h>

#include "common/angles.h"

#include <apps/common/command_line.h>
#include <apps/io/text_scanner.h>
#include <apps/methods/method_run.h>
#include <apps/methods/option_numbers.h>

#include <cmath>
#include <ostream>
#include <sstream>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;

constexpr const char* kDefaultMethod = "ssfr";
constexpr const char* kPaperMethod = "ssfr_paper2017";

Eigen::Vector3d
parseGravity(const std::string& text)
{
  const std::vector<double> values = parseNumbers("--gravity", text, 3, "x,y,z");
  const Eigen::Vector3d up(values[0], values[1], values[2]);
  Eigen::Vector3d direction = up.stableNormalized();
  if (!(std::abs(direction.norm() - 1) < 1e-9)) // of zero, of what is not finite
    throw UsageError("--gravity: " + io::inQuotes(text) + " is not a direction");
  return direction;
}

/// [rad]
double
parseGravityTolerance(const std::string& text)
{
  const double degrees = parseNumbers("--gravity-tolerance", text, 1, "one number")[0];
  if (!(degrees > 0 && degrees <= 180))
    throw UsageError("--gravity-tolerance: " + io::inQuotes(text) + " is not in (0, 180] degrees");
  return degrees * kDegree;
}

GuessTolerance
parseGuessTolerance(const std::string& text)
{
  const std::vector<double> values = parseNumbers("--guess-tolerance", text, 2, "DEG,M");
  if (!(values[0] > 0 && values[0] <= 180 && values[1] > 0 && std::isfinite(values[1])))
    throw UsageError("--guess-tolerance: " + io::inQuotes(text) +
                     ": the angle must be in (0, 180] degrees, the distance greater than 0");
  return {values[0] * kDegree, values[1]};
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
  if (text == "unused")
    return ViewpointMode::Unused;
  throw UsageError("--viewpoint: " + io::inQuotes(text) + " is not auto, sensor, unknown or unused");
}

/// The profile that --method and --profile ask for together. \param[in,out] method one of methods()
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
  if (profile == Profile::Paper2017 && findMethod(method)->kind == MethodKind::SsfrRefined)
    throw UsageError("--profile paper2017 contradicts --method " + method);
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
    if (values.count("gravity-tolerance"))
      gravity.tolerance = parseGravityTolerance(values["gravity-tolerance"].as<std::string>());
    options.gravity = gravity;
  }
  else if (values.count("gravity-tolerance")) {
    throw UsageError("--gravity-tolerance needs --gravity");
  }
  if (values.count("guess-tolerance"))
    options.guess_tolerance = parseGuessTolerance(values["guess-tolerance"].as<std::string>());
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

/// Options that were given, "--name", though the method does not read them.
std::vector<std::string>
findUnread(const po::variables_map& values, const Method& method, Profile profile)
{
  std::vector<const char*> not_read;
  if (isSsfr(method)) {
    if (profile == Profile::Paper2017)
      not_read = {"min-confidence", "refine", "no-refine"};
  }
  else {
    not_read = {"profile",
                "viewpoint",
                "gravity",
                "gravity-tolerance",
                "refine",
                "no-refine",
                "density-radius",
                "bin-width",
                "min-confidence"};
    if (method.kind == MethodKind::Global)
      not_read.push_back("guess");
    if (!method.needs_normals)
      not_read.push_back("normal-radius");
    if (!method.stops_by_itself)
      not_read.push_back("time-limit");
  }
  std::vector<std::string> unread;
  for (const char* name : not_read)
    if (values.count(name) && !values[name].defaulted())
      unread.push_back(std::string("--") + name);
  return unread;
}

} // namespace

void
addMethodOptions(po::options_description& all)
{
  const Options defaults = makeOptions(Profile::Default);
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
      "guess-tolerance",
      po::value<std::string>()->value_name("DEG,M"),
      "how good the guess is (ssfr): only poses that rotate and move the sensor by at most this from it are "
      "considered; "
      "surer and faster (default: the guess is one candidate among all)")(
      "viewpoint",
      po::value<std::string>()->value_name("MODE")->default_value("auto"),
      "auto: decide from the points whether the sensor is at the origin (or at the place that the file gives), and "
      "look "
      "for it in the points where it is not; sensor: it is; unknown: it is not (merged or moved clouds); unused: do "
      "without")(
      "gravity",
      po::value<std::string>()->value_name("X,Y,Z"),
      "up direction in both scans, when it is known: only poses that keep it are considered, and it constrains "
      "the tilt where the scans do not")("gravity-tolerance",
                                         po::value<std::string>()->value_name("DEG"),
                                         "how far it may be wrong, in degrees: three standard deviations (default: 5)")(
      "refine",
      "polish the pose on the "
      "points (the default)")("no-refine", "leave the pose as the histograms give it");

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
      "time-limit",
      po::value<double>()->value_name("S"),
      "stop after so many seconds: ssfr, go_icp, super4pcs, fpcs, kfpcs (default: no limit; 60 for the last four)")(
      "threads",
      po::value<int>()->value_name("N")->default_value(0),
      "processors to use, 0: all; the result does not depend on it")("help,h", "print this text")("version",
                                                                                                  "print the version");

  all.add(method).add(scales).add(general);
}

MethodArguments
readMethodOptions(const po::variables_map& values)
{
  MethodArguments result;
  result.method = values["method"].as<std::string>();
  result.guess_file = textOf(values, "guess");
  if (!findMethod(result.method))
    throw UsageError("--method: " + io::inQuotes(result.method) + " " + describeUnknown());
  const Profile profile = chooseProfile(values, result.method);
  const Method& method = *findMethod(result.method); // the profile may have chosen another
  if (values.count("guess-tolerance")) {
    if (!values.count("guess"))
      throw UsageError("--guess-tolerance needs --guess");
    if (profile != Profile::Default || !isSsfr(method))
      throw UsageError("--guess-tolerance is not read by --method " + result.method);
  }
  result.options = chooseOptions(values, profile);
  result.unread = findUnread(values, method, profile);
  return result;
}

void
warnOfUnread(const MethodArguments& arguments, const std::string& program, std::ostream& out)
{
  for (const std::string& option : arguments.unread)
    out << program << ": warning: " << option << " is not read by --method " << arguments.method << '\n';
}

} // namespace apps
} // namespace pcl_ssfr
