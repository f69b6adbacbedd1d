// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_options.h>

#include <apps/common/command_line.h>
#include <apps/io/loaded_cloud.h>
#include <apps/methods/option_numbers.h>

#include <algorithm>
#include <sstream>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace po = boost::program_options;

constexpr std::uint64_t kMostCandidates = 100000;

po::options_description
describeOptions()
{
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  po::options_description output("What is shown, and where", kHelpWidth);
  // clang-format off
  output.add_options()
      ("png", text("DIR"), "draw pictures and index.html into DIR; needs no display")
      ("render", text("DIR"), "the same as --png")
      ("window", "show the scans in a window (what happens without --png)")
      ("screenshot", text("FILE"), "open the window, write it to FILE (.png) and close it")
      ("layer", text("NAME"), "what the window shows at first: points (default), patches or matches")
      ("candidate", text("K"), "candidate to show closely, 1 (default): the chosen one")
      ("truth", text("FILE"), "4x4 text: the true pose of SOURCE in TARGET, shown next to what was found");
  po::options_description input("Which pair, when RESULT is a folder", kHelpWidth);
  input.add_options()
      ("pair", text("I"), "row of pairs.csv, counted from 0")
      ("dataset", text("DIR"), "folder of the scans of benchmark results, where it is no longer known")
      ("perturb", text("KIND"), "of a dataset: none (default), rotation or se3, as in ssfr_benchmark")
      ("seed", text("S"), "of --perturb, as in ssfr_benchmark (default: 1)");
  // clang-format on
  po::options_description all(kHelpWidth);
  all.add(output).add(input);
  addMethodOptions(all);
  return all;
}

} // namespace

ViewArguments
parseViewArguments(const std::vector<std::string>& arguments)
{
  ViewArguments result;
  const po::variables_map values = parseCommandLine(arguments, describeOptions(), "inputs", &result.given);
  if (asksForText(values, result))
    return result;
  result.inputs = textsOf(values, "inputs");
  if (result.inputs.empty())
    throw UsageError("RESULT, or SOURCE and TARGET, are missing");
  if (result.inputs.size() > 2)
    throw UsageError("unexpected argument " + io::inQuotes(result.inputs[2]) + ", SOURCE and TARGET are already given");
  result.pictures = textOf(values, "png");
  if (values.count("render")) {
    if (!result.pictures.empty())
      throw UsageError("--render is the same as --png, which is given too");
    result.pictures = textOf(values, "render");
  }
  result.screenshot = textOf(values, "screenshot");
  result.truth = textOf(values, "truth");
  result.dataset = textOf(values, "dataset");
  if (const std::string word = textOf(values, "candidate"); !word.empty())
    result.candidate = parseWhole("--candidate", word, 1, kMostCandidates);
  if (const std::string word = textOf(values, "layer"); !word.empty()) {
    if (word != "points" && word != "patches" && word != "matches")
      throw UsageError("--layer: " + io::inQuotes(word) + " is not points, patches or matches");
    result.layer = word == "points"    ? WindowLayer::Points
                   : word == "patches" ? WindowLayer::Patches
                                       : WindowLayer::Matches;
  }
  if (const std::string word = textOf(values, "pair"); !word.empty())
    result.pair = parseWhole("--pair", word, 0, std::uint64_t{1} << 53);
  if (const std::string word = textOf(values, "seed"); !word.empty())
    result.seed = parseWhole("--seed", word, 0, std::uint64_t{1} << 53);
  if (const std::string word = textOf(values, "perturb"); !word.empty()) {
    try {
      result.perturbation = parsePerturbation(word);
    }
    catch (const std::invalid_argument& error) {
      throw UsageError(std::string("--perturb: ") + error.what());
    }
  }
  result.window = values.count("window") > 0 || !result.screenshot.empty() || result.pictures.empty();
  result.method = readMethodOptions(values);
  return result;
}

std::string
viewHelp()
{
  std::ostringstream help;
  help
      << "Usage: ssfr_view RESULT [options]\n"
         "       ssfr_view SOURCE TARGET [options]\n\n"
         "Shows what a registration found, stage by stage, so that its answer can be understood: the scans before and\n"
         "after, planar patches, Gaussian spheres, histograms and correlations along each axis, the ranked poses,\n"
         "what meets (green) and what contradicts (red), counts and times. With a true pose it says at which stage\n"
         "the truth was lost. docs/VIEW.md explains the pictures.\n\n"
         "RESULT is one of\n"
         "  FILE.json             what ssfr_align --json FILE.json wrote; nothing is registered again\n"
         "  a dataset folder      with --pair I, and --perturb, --seed: the pair is registered; its truth is known\n"
         "  a results folder      of ssfr_benchmark, with --pair I, --method M: the same pair again, varied as it was\n"
         "SOURCE and TARGET are two scans, which are registered as ssfr_align does, with its options. Formats:\n"
      << io::readableFormats()
      << "\n\nExamples:\n"
         "  ssfr_align a.pcd b.pcd --json run.json; ssfr_view run.json --png pictures\n"
         "  ssfr_view a.pcd b.pcd --truth T.txt --png pictures    then open pictures/index.html\n"
         "  ssfr_view data --pair 1 --perturb se3 --seed 7        in a window, which lists its keys\n\n"
      << describeOptions()
      << "\nExit code: 0 shown or drawn, whether the scans were aligned or not (the first line of the output says "
         "it);\n"
         "2 the command line is wrong, or there is neither a display nor --png; 3 a file cannot be read or written.\n";
  return help.str();
}

} // namespace apps
} // namespace pcl_ssfr
