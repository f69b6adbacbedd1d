// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_results.h>

#include <string>

namespace pcl_ssfr {
namespace apps {

/// Everything but the single rows, for scripts; what is not known is null.
nlohmann::ordered_json
summaryJson(const BenchmarkResults& results);

/// A table for each dataset and variation, fit for a pull request.
std::string
summaryMarkdown(const BenchmarkResults& results);

/// Write summary.json and summary.md into a folder. \throw io::IoError
void
writeSummaries(const std::string& folder, const BenchmarkResults& results);

} // namespace apps
} // namespace pcl_ssfr
