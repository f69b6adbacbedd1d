// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/benchmark/benchmark_run.h>
#include <apps/benchmark/worker.h>
#include <apps/common/program_main.h>

#include <pcl/console/print.h>

#include <iostream>

namespace {

using namespace pcl_ssfr;

/// Exit codes that scripts rely on.
enum ExitCode { kDone = 0 };

int
run(const std::vector<std::string>& tokens)
{
  if (tokens.size() == 1 && tokens.front() == apps::kWorkerOption)
    return apps::runWorker();
  const apps::BenchmarkArguments arguments = apps::parseBenchmarkArguments(tokens);
  if (arguments.help || arguments.version) {
    std::cout << (arguments.help ? apps::benchmarkHelp() : std::string("ssfr_benchmark " PCL_SSFR_VERSION "\n"));
    return kDone;
  }
  return apps::runBenchmark(arguments);
}

} // namespace

int
main(int argc, char** argv)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); // this program reports errors itself
  return apps::runProgram("ssfr_benchmark", argc, argv, run);
}
