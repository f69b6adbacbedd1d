// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/simulation/scene_pictures.h>
#include <apps/simulation/simulate_options.h>
#include <apps/simulation/simulation_error.h>
#include <apps/simulation/simulation_report.h>

#include <chrono>
#include <iostream>
#include <new>
#include <optional>

namespace {

using namespace pcl_ssfr;

/// Exit codes that scripts rely on.
enum ExitCode { kDone = 0, kUsage = 2, kFiles = 3 };

int
run(const std::vector<std::string>& tokens)
{
  const simulation::SimulateArguments arguments = simulation::parseSimulateArguments(tokens);
  if (const auto text = simulation::informationFor(arguments)) {
    std::cout << *text;
    return kDone;
  }
  const auto start = std::chrono::steady_clock::now();
  std::optional<simulation::DatasetWriter> writer; // first: it says early that a folder cannot be written
  if (!arguments.out.empty())
    writer.emplace(arguments.out, arguments.overwrite);
  const simulation::PreparedPlan prepared = simulation::prepare(arguments.plan, arguments.threads);
  if (!arguments.pictures.empty())
    simulation::drawPlan(arguments.pictures, prepared, arguments.threads);
  if (!writer)
    return kDone;
  simulation::Progress progress(std::cerr, simulation::Progress::styleFor(arguments.quiet));
  const auto summary = simulation::simulateDataset(prepared, *writer, progress, arguments.threads);
  writer->commit();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!arguments.quiet)
    std::cout << simulation::toText(arguments.out, prepared, summary, elapsed.count());
  return kDone;
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    return run({argv + 1, argv + argc});
  }
  catch (const apps::UsageError& error) {
    std::cerr << "ssfr_simulate: " << error.what() << "; see ssfr_simulate --help\n";
    return kUsage;
  }
  catch (const simulation::SimulationError& error) {
    std::cerr << "ssfr_simulate: " << error.what() << '\n';
    return kUsage;
  }
  catch (const std::bad_alloc&) {
    std::cerr << "ssfr_simulate: out of memory\n";
  }
  catch (const std::exception& error) {
    std::cerr << "ssfr_simulate: " << error.what() << '\n';
  }
  return kFiles;
}
