// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_options.h>

#include <pcl_ssfr/options.h>

#include <apps/common/command_line.h>
#include <apps/io/csv_line.h>
#include <apps/io/e57_format.h>
#include <apps/io/io_error.h>
#include <apps/io/loaded_cloud.h>
#include <apps/methods/option_numbers.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;
using Texts = std::vector<std::string>;

po::options_description
describeOptions()
{
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  const auto texts = [](const char* name) { return po::value<Texts>()->value_name(name)->composing(); };
  po::options_description results("Results", kHelpWidth);
  results.add_options()(
      "out", text("DIR"), "the folder that gets poses.csv, links.csv, map.json, report.html and map.sqlite")(
      "merged", text("FILE"), "write all scans of the largest component as one cloud (.pcd or .ply), coloured by scan")(
      "merged-leaf", text("M"), "spacing that each scan is thinned to in it [m], 0: every point (default: 0.02)")(
      "e57", text("FILE"), "write its scans with their poses, intensities and colours into one E57 file")(
      "pcd",
      text("DIR"),
      "write a PCD copy of each of its scans, moved into the map, with the pose of its sensor as VIEWPOINT")(
      "tum", "write poses.tum besides: one line a scan, its number, position and quaternion")(
      "json", text("FILE"), "write map.json there too, '-' is the standard output")(
      "truth",
      text("FILE"),
      "compare with these poses (poses.txt: scan tx ty tz qx qy qz qw, a poses.csv, or those in an E57 file)");
  po::options_description known("What you know", kHelpWidth);
  known.add_options()("gravity", text("X,Y,Z"), "up in the frame of every scan, to five degrees")(
      "poses", text("FILE"), "approximate poses (files as of --truth): only links near them are looked for")(
      "pose-tolerance", text("DEG,M"), "how near these are (default: 10,1)")(
      "control",
      text("FILE"),
      "control.csv: scan,x,y,z of setups, or with point,sx,sy,sz of points, in a site frame: the map is laid onto "
      "them")("pin", texts("SCAN"), "this scan holds the frame of its component");
  po::options_description mending("Mending, from the links in DIR/map.sqlite", kHelpWidth);
  mending.add_options()("accept", texts("A,B"), "the best pose of these two scans is right")(
      "reject", texts("A,B"), "do not join these two scans")(
      "resume", "go on with DIR/map.sqlite: what is linked is not linked again");
  po::options_description general("General", kHelpWidth);
  general.add_options()("threads",
                        text("N"),
                        "processors to use, 0: all; in an MPI job those of each rank, 0: all for rank 0 and 1 for each "
                        "other; the map does "
                        "not depend on it (default: 0)")(
      "pairs",
      text("RULE"),
      "which pairs of scans are linked: all, candidates (those likely to share a place), or auto: all up to 150 scans, "
      "candidates above (default: auto)")("help,h", "print this text")("version", "print the version");
  po::options_description all(kHelpWidth);
  all.add(results).add(known).add(mending).add(general);
  return all;
}

/// parseNumbers() that are finite. \throw UsageError
std::vector<double>
finiteNumbers(const std::string& option, const std::string& text, std::size_t count)
{
  std::vector<double> values =
      parseNumbers(option, text, count, count == 1 ? "1 number" : std::to_string(count) + " numbers between commas");
  if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }))
    throw UsageError(option + ": " + io::inQuotes(text) + " is not finite");
  return values;
}

std::pair<std::string, std::string>
pairOf(const std::string& option, const std::string& text)
{
  // A name with a comma is put in double quotes, as in a CSV file.
  const std::vector<std::string> names = io::splitCsvLine(text);
  if (names.size() != 2 || names[0].empty() || names[1].empty())
    throw UsageError("--" + option + ": " + io::inQuotes(text) + " is not A,B: two scans");
  return {names[0], names[1]};
}

} // namespace

MapArguments
parseMapArguments(const std::vector<std::string>& arguments)
{
  const po::variables_map values = parseCommandLine(arguments, describeOptions(), "inputs");
  MapArguments result;
  if (asksForText(values, result))
    return result;
  for (const std::string& word : arguments)
    result.words += (result.words.empty() ? "" : " ") + word;
  result.inputs = textsOf(values, "inputs");
  if (result.inputs.empty())
    throw UsageError("INPUT is missing: files or folders of scans");
  for (const std::string& input : result.inputs)
    if (input.empty())
      throw UsageError("INPUT is empty");
  result.out = textOf(values, "out");
  if (result.out.empty())
    throw UsageError("--out is missing: the folder for the map");
  const std::string threads = textOf(values, "threads");
  if (!threads.empty()) {
    const double count = finiteNumbers("--threads", threads, 1).front();
    if (!(count >= 0 && count <= kMaxThreads) || count != std::floor(count))
      throw UsageError("--threads: " + io::inQuotes(threads) + " is not a whole number from 0 to " +
                       std::to_string(kMaxThreads));
    result.threads = static_cast<unsigned>(count);
  }
  if (const std::string pairs = textOf(values, "pairs"); pairs == "all")
    result.pairs = PairRule::All;
  else if (pairs == "candidates")
    result.pairs = PairRule::Candidates;
  else if (!pairs.empty() && pairs != "auto")
    throw UsageError("--pairs: " + io::inQuotes(pairs) + " is neither all, candidates nor auto");
  if (const std::string gravity = textOf(values, "gravity"); !gravity.empty()) {
    const std::vector<double> up = finiteNumbers("--gravity", gravity, 3);
    result.gravity = Eigen::Vector3d(up[0], up[1], up[2]);
    if (!(result.gravity->norm() > 0))
      throw UsageError("--gravity: " + io::inQuotes(gravity) + " has no direction");
  }
  result.poses = textOf(values, "poses");
  if (const std::string tolerance = textOf(values, "pose-tolerance"); !tolerance.empty()) {
    if (result.poses.empty())
      throw UsageError("--pose-tolerance: there are no --poses");
    const std::vector<double> bounds = finiteNumbers("--pose-tolerance", tolerance, 2);
    if (!(bounds[0] > 0 && bounds[0] <= 180 && bounds[1] > 0))
      throw UsageError("--pose-tolerance: " + io::inQuotes(tolerance) + " is not DEG,M with 0 < DEG <= 180 and M > 0");
    result.pose_rotation_deg = bounds[0];
    result.pose_translation_m = bounds[1];
  }
  result.pins = textsOf(values, "pin");
  for (const std::string& text : textsOf(values, "accept"))
    result.accepted.push_back(pairOf("accept", text));
  for (const std::string& text : textsOf(values, "reject"))
    result.rejected.push_back(pairOf("reject", text));
  result.control = textOf(values, "control");
  CloudOutputs& clouds = result.clouds;
  clouds.merged = textOf(values, "merged");
  if (!clouds.merged.empty() && (!io::isWritableFormat(clouds.merged) || io::isE57(clouds.merged)))
    throw UsageError("--merged: " + clouds.merged + " is not a .pcd or .ply file");
  clouds.e57 = textOf(values, "e57");
  if (!clouds.e57.empty() && (!io::isE57(clouds.e57) || io::fileOfScan(clouds.e57) != clouds.e57))
    throw UsageError("--e57: " + clouds.e57 + " is not an .e57 file");
  clouds.pcd = textOf(values, "pcd");
  if (const std::string leaf = textOf(values, "merged-leaf"); !leaf.empty()) {
    if (clouds.merged.empty())
      throw UsageError("--merged-leaf: there is no --merged");
    clouds.merged_leaf = finiteNumbers("--merged-leaf", leaf, 1).front();
    if (!(clouds.merged_leaf >= 0))
      throw UsageError("--merged-leaf: " + io::inQuotes(leaf) + " is less than 0");
  }
  result.truth = textOf(values, "truth");
  result.resume = values.count("resume") > 0;
  result.tum = values.count("tum") > 0;
  result.json = textOf(values, "json");
  return result;
}

std::string
mapHelp()
{
  std::ostringstream text;
  text << "Usage: ssfr_map INPUT... --out DIR [options]\n\n"
          "Places many scans of one building or street in one frame: unordered scans in, one consistent map out, with\n"
          "standard deviations and a report. INPUT is a scan, a folder of scans, or an E57 file with several scans\n"
          "(site.e57: all of them, site.e57#2 and site.e57#Lobby: one). No order and no guess is needed.\n"
          "What no sure evidence connects stays apart: the report names the reasons, and what may be accepted.\n\n"
          "Scans are read by their extension: "
       << io::readableFormats()
       << "\n(in folders: all of these but pairs.csv, poses.csv, poses.txt and the like). Points are in metres.\n\n"
          "Examples:\n"
          "  ssfr_map scans --out map                                   place all scans of a folder\n"
          "  ssfr_map scans --out map --accept s3.pcd,s9.pcd            mend: join two parts by hand, in seconds\n"
          "  ssfr_map scans --out map --merged all.ply --merged-leaf 0.05\n"
          "  ssfr_map building.e57 --out map --e57 registered.e57       the same file with new poses\n"
          "On a cluster, with MPI: mpirun -n 65 ssfr_map ...; rank 0 deals out the pairs, makes the map and writes.\n\n"
       << describeOptions()
       << "\nExit code: 0 all scans are in one component; 1 there are several components (everything is written, "
          "poses.csv\ngives the reasons); 2 the command line is wrong; 3 a file cannot be read or written.\n";
  return text.str();
}

} // namespace apps
} // namespace pcl_ssfr
