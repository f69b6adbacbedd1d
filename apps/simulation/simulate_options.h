// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/usage_error.h>
#include <apps/simulation/dataset_simulation.h>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// What the user of ssfr_simulate asked for.
struct SimulateArguments {
  bool help = false;        ///< print the help and stop; nothing else is set
  bool version = false;     ///< print the version and stop; nothing else is set
  bool list = false;        ///< print scenes, sensors and sets and stop; nothing else is set
  std::string print_sensor; ///< print this sensor as JSON and stop; empty: no
  std::string out;          ///< folder of the dataset; empty: none, only pictures
  std::string pictures;     ///< folder for a picture of the scene, not in that of the dataset; empty: none
  bool overwrite = false;
  bool quiet = false;
  unsigned threads = 0; ///< 0: all
  DatasetPlan plan;
};

/** \brief Parse the command line of ssfr_simulate, program name left out.
 * \throw apps::UsageError
 */
SimulateArguments
parseSimulateArguments(const std::vector<std::string>& arguments);

/// The text of --help.
std::string
simulateHelp();

/// The text of --list: scenes, sensors and the paper's sets.
std::string
simulateList();

} // namespace pcl_ssfr::simulation
