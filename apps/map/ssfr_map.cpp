// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/cluster/mpi_ranks.h>
#include <apps/common/program_main.h>
#include <apps/map/map_options.h>
#include <apps/map/map_run.h>

#include <pcl/console/print.h>

#include <iostream>

namespace {

using namespace pcl_ssfr;

/// Exit codes that scripts rely on.
enum ExitCode { kOneComponent = 0, kSeveralComponents = 1 };

int
run(const std::vector<std::string>& tokens)
{
  const bool is_first = apps::MpiRanks::isFirst(); // of the ranks of an MPI job: one speaks
  apps::MapArguments arguments;
  try {
    arguments = apps::parseMapArguments(tokens);
  }
  catch (const apps::UsageError&) {
    if (is_first)
      throw;
    // A rank that fails ends the job, even while rank 0 says what is wrong: rank 0 learns of it, and fails for all.
    apps::MpiRanks().work([](const std::string&, const apps::MpiRanks::Send&) { throw; });
    return kOneComponent;
  }
  if (arguments.help || arguments.version) {
    if (is_first)
      std::cout << (arguments.help ? apps::mapHelp() : std::string("ssfr_map " PCL_SSFR_VERSION "\n"));
    return kOneComponent;
  }
  return apps::runMap(arguments) ? kOneComponent : kSeveralComponents;
}

} // namespace

int
main(int argc, char** argv)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); // this program reports errors itself
  return apps::runProgram("ssfr_map", argc, argv, run);
}
