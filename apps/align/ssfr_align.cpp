// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/align/align_options.h>
#include <apps/align/pictures.h>
#include <apps/common/command_line.h>
#include <apps/common/program_main.h>
#include <apps/io/file_bytes.h>
#include <apps/io/output_file.h>
#include <apps/io/transform_file.h>
#include <apps/methods/report.h>

#include <pcl/console/print.h>

#include <chrono>
#include <iostream>

namespace {

using namespace pcl_ssfr;

/// Exit codes that scripts rely on.
enum ExitCode { kAligned = 0, kNotAligned = 1 };

apps::Report
align(const apps::AlignArguments& arguments, const io::LoadedCloud& source, const io::LoadedCloud& target)
{
  std::optional<Eigen::Isometry3d> guess;
  if (!arguments.guess_file.empty())
    guess = io::readTransform(arguments.guess_file);
  apps::Report report;
  report.source = arguments.source;
  report.target = arguments.target;
  report.method = arguments.method;
  report.options = arguments.options;
  report.guess = guess;
  report.run = apps::runMethod(arguments.method, source, target, arguments.options, guess);
  report.reference = apps::referencePoint(source, report.run.result);
  report.peak_rss_mib = apps::peakRssMib();
  return report;
}

/// Write a text to a file, or to the standard output.
void
writeText(const std::string& path, const std::string& text)
{
  if (path == apps::kStandardOutput)
    std::cout << text;
  else
    io::writeFile(path, text);
}

void
write(const apps::AlignArguments& arguments,
      const io::LoadedCloud& source,
      const io::LoadedCloud& target,
      const apps::Report& report)
{
  const Result& result = report.run.result;
  if (result.accepted() && !arguments.transform.empty())
    writeText(arguments.transform, io::formatTransform(result.T_target_source));
  if (result.accepted() && !arguments.output.empty())
    io::saveMovedCloud(arguments.output, source, result.T_target_source);
  if (!arguments.pictures.empty())
    apps::drawPair(arguments.pictures, source, target, report, arguments.options);
  if (!arguments.json.empty())
    writeText(arguments.json, apps::toJsonText(report));
  const bool prints_summary = arguments.json.empty() && arguments.transform != apps::kStandardOutput;
  if (prints_summary)
    std::cout << apps::toText(report);
  else if (!result.accepted())
    std::cerr << "ssfr_align: " << apps::headline(report) << '\n';
  std::cout.flush();
  if (!std::cout)
    throw io::IoError("standard output: cannot be written");
}

int
run(const std::vector<std::string>& tokens)
{
  const apps::AlignArguments arguments = apps::parseAlignArguments(tokens);
  if (arguments.help || arguments.version) {
    std::cout << (arguments.help ? apps::alignHelp() : std::string("ssfr_align " PCL_SSFR_VERSION "\n"));
    return kAligned;
  }
  apps::warnOfUnread(arguments, "ssfr_align", std::cerr);
  for (const std::string& output : {arguments.output, arguments.transform, arguments.json})
    if (!output.empty() && output != apps::kStandardOutput)
      io::requireWritable(output);
  const auto start = std::chrono::steady_clock::now();
  io::LoadedCloud source = io::loadCloud(arguments.source);
  io::LoadedCloud target = io::loadCloud(arguments.target);
  const std::chrono::duration<double> loading = std::chrono::steady_clock::now() - start;
  apps::Report report = align(arguments, source, target);
  report.loading_seconds = loading.count();
  // A sensor that was found goes before what the file says, in what is written and drawn too.
  const apps::FoundSensors found(report.run.result);
  if (found.source)
    source.viewpoint = found.source;
  if (found.target)
    target.viewpoint = found.target;
  write(arguments, source, target, report);
  return report.run.result.accepted() ? kAligned : kNotAligned;
}

} // namespace

int
main(int argc, char** argv)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); // this program reports errors itself
  return apps::runProgram("ssfr_align", argc, argv, run);
}
