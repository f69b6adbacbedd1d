// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/dataset_simulation.h>
#include <apps/simulation/simulate_options.h>

#include <optional>
#include <string>

namespace pcl_ssfr::simulation {

/// What --help, --version, --list or --print-sensor print; nothing when there is a dataset to make.
/// \throw io::IoError for a sensor file that cannot be used
std::optional<std::string>
informationFor(const SimulateArguments& arguments);

/// The summary of a dataset for people.
/// \param[in] seconds that it took
std::string
toText(const std::string& folder, const PreparedPlan& prepared, const DatasetSummary& summary, double seconds);

} // namespace pcl_ssfr::simulation
