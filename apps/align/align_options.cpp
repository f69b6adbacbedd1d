// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/align/align_options.h>

#include <apps/common/command_line.h>
#include <apps/io/e57_format.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/text_scanner.h>
#include <apps/methods/method_options.h>
#include <apps/methods/method_run.h>

#include <sstream>
#include <system_error>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;

/// The option table: parsed, printed by --help, with the defaults of the library.
po::options_description
describeOptions()
{
  po::options_description results("Results", kHelpWidth);
  results.add_options()(
      "output",
      po::value<std::string>()->value_name("FILE"),
      "write the moved source: .pcd or .ply with all its fields, in the coordinates of TARGET, or .e57 with its "
      "pose")("transform",
              po::value<std::string>()->value_name("FILE"),
              "write T_target_source as 4x4 text, which maps points of SOURCE onto TARGET; '-' is the standard "
              "output, without the summary then")(
      "json",
      po::value<std::string>()->value_name("FILE"),
      "write everything that was found as JSON instead of the summary; '-' is the standard output")(
      "pictures",
      po::value<std::string>()->value_name("DIR"),
      "draw before.png and after.png into DIR: both scans from above and from the side");

  po::options_description all(kHelpWidth);
  all.add(results);
  addMethodOptions(all);
  return all;
}

/// Nothing may be lost: neither one result to another, nor a scan to a result. What is no file, as /dev/null, may be
/// named twice, but for the standard output: nobody could tell its two results apart.
void
checkFiles(const AlignArguments& arguments)
{
  const std::pair<const char*, std::string> named[] = {{"SOURCE", arguments.source},
                                                       {"TARGET", arguments.target},
                                                       {"--guess", arguments.guess_file},
                                                       {"--output", arguments.output},
                                                       {"--transform", arguments.transform},
                                                       {"--json", arguments.json}};
  constexpr std::size_t kFirstResult = 3;
  const auto identity = [](const std::string& scan) {
    return scan.empty() || scan == kStandardOutput ? scan : io::fileIdentity(io::fileOfScan(scan));
  };
  for (std::size_t i = kFirstResult; i < std::size(named); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const std::string file = identity(named[i].second);
      if (!file.empty() && file == identity(named[k].second))
        throw UsageError(std::string(named[i].first) + ": " + io::inQuotes(named[i].second) + " is also " +
                         named[k].first);
    }
}

} // namespace

AlignArguments
parseAlignArguments(const std::vector<std::string>& arguments)
{
  const po::variables_map values = parseCommandLine(arguments, describeOptions(), "clouds");
  AlignArguments result;
  if (asksForText(values, result))
    return result;
  const std::vector<std::string> clouds = textsOf(values, "clouds");
  if (clouds.size() < 2)
    throw UsageError(clouds.empty() ? "SOURCE and TARGET are missing" : "TARGET is missing");
  if (clouds.size() > 2)
    throw UsageError("unexpected argument " + io::inQuotes(clouds[2]) + ", SOURCE and TARGET are already given");
  result.source = clouds[0];
  result.target = clouds[1];
  for (const auto& [name, file] : {std::pair("SOURCE", result.source), std::pair("TARGET", result.target)})
    if (file.empty())
      throw UsageError(std::string(name) + " is empty");
  result.output = textOf(values, "output");
  result.transform = textOf(values, "transform");
  result.json = textOf(values, "json");
  result.pictures = textOf(values, "pictures");
  if (!result.output.empty() && !io::isWritableFormat(result.output))
    throw UsageError("--output: " + result.output + " is not a file of " + io::writableFormats());
  static_cast<MethodArguments&>(result) = readMethodOptions(values);
  checkFiles(result);
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
       << "\n(.csv as in the ASL/ETH data sets, .3d of 3DTK, .bin of KITTI, .las without compression;\n"
          "a.e57#2 or a.e57#NAME is one scan of a file with several). Points are in metres.\n\n"
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
