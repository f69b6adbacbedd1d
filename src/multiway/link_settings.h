// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/multiway/pair_linking.h>

#include <optional>
#include <string>

namespace pcl_ssfr {

/// Text that differs where links of the same scans would, by which a project knows those that it may take.
std::string
settingsOf(const MultiwayOptions& options);

/// The same of a pair of which something is known beforehand.
std::string
withGuess(const std::string& settings, const std::optional<PairGuess>& guess);

} // namespace pcl_ssfr
