// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_options.h>

#include <apps/common/usage_error.h>
#include <apps/io/loaded_cloud.h>

#include <boost/program_options.hpp>

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

po::variables_map
parseTokens(const std::vector<std::string>& arguments, ViewArguments& result)
{
  po::options_description all = describeOptions();
  all.add_options()("inputs", po::value<std::vector<std::string>>());
  po::positional_options_description positional;
  positional.add("inputs", -1);
  namespace style = po::command_line_style;
  constexpr int kStyle = style::unix_style & ~style::allow_guessing; // an abbreviation is an unknown option
  po::variables_map values;
  try {
    const po::parsed_options parsed =
        po::command_line_parser(arguments).options(all).positional(positional).style(kStyle).run();
    for (const po::option& option : parsed.options)
      if (option.position_key < 0)
        result.given.push_back(option.string_key);
    po::store(parsed, values);
  }
  catch (const po::error& error) {
    throw UsageError(error.what());
  }
  return values;
}

std::uint64_t
parseWhole(const std::string& option, const std::string& text, std::uint64_t least, std::uint64_t most)
{
  std::uint64_t value = 0;
  bool valid = !text.empty() && text.size() < 20;
  for (const char c : text) {
    valid = valid && c >= '0' && c <= '9';
    value = value * 10 + static_cast<std::uint64_t>(c - '0');
  }
  if (!valid || value < least || value > most)
    throw UsageError("--" + option + ": " + io::inQuotes(text) + " is not a whole number from " +
                     std::to_string(least) + " to " + std::to_string(most));
  return value;
}

} // namespace

ViewArguments
parseViewArguments(const std::vector<std::string>& arguments)
{
  ViewArguments result;
  const po::variables_map values = parseTokens(arguments, result);
  result.help = values.count("help") > 0;
  result.version = !result.help && values.count("version") > 0;
  if (result.help || result.version)
    return result;
  if (values.count("inputs"))
    result.inputs = values["inputs"].as<std::vector<std::string>>();
  if (result.inputs.empty())
    throw UsageError("RESULT, or SOURCE and TARGET, are missing");
  if (result.inputs.size() > 2)
    throw UsageError("unexpected argument " + io::inQuotes(result.inputs[2]) + ", SOURCE and TARGET are already given");
  const auto text = [&values](const char* name, std::string& target) {
    if (!values.count(name))
      return false;
    target = values[name].as<std::string>();
    if (target.empty())
      throw UsageError(std::string("--") + name + ": the value is empty");
    return true;
  };
  std::string render;
  if (text("png", result.pictures) && values.count("render"))
    throw UsageError("--render is the same as --png, which is given too");
  if (text("render", render))
    result.pictures = render;
  text("screenshot", result.screenshot);
  text("truth", result.truth);
  text("dataset", result.dataset);
  std::string word;
  if (text("candidate", word))
    result.candidate = parseWhole("candidate", word, 1, kMostCandidates);
  if (text("layer", word)) {
    if (word != "points" && word != "patches" && word != "matches")
      throw UsageError("--layer: " + io::inQuotes(word) + " is not points, patches or matches");
    result.layer = word == "points"    ? WindowLayer::Points
                   : word == "patches" ? WindowLayer::Patches
                                       : WindowLayer::Matches;
  }
  if (text("pair", word))
    result.pair = parseWhole("pair", word, 0, std::uint64_t{1} << 53);
  if (text("seed", word))
    result.seed = parseWhole("seed", word, 0, std::uint64_t{1} << 53);
  if (text("perturb", word)) {
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
