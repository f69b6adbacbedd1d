// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/options.h>

#include <nlohmann/json.hpp>

namespace pcl_ssfr {
namespace apps {

/// What of the options the programs can set: enough to run a registration again.
nlohmann::ordered_json
optionsJson(const Options& options);

/** \brief The options that optionsJson() wrote; what is missing has its default.
 * \throw std::invalid_argument with one line that names the key
 */
Options
optionsFromJson(const nlohmann::ordered_json& json);

} // namespace apps
} // namespace pcl_ssfr
