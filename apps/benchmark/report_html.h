// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_results.h>
#include <apps/benchmark/report_pictures.h>

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace apps {

/// Rows that a report lists one by one; of larger runs, those that were not solved come first.
constexpr std::size_t kReportRows = 20000;

/// A file of apps/benchmark/report, built into the program; empty for a name that is none of them.
std::string_view
reportAsset(std::string_view name);

/** \brief What the page shows: sums, curves and boxes over all rows, up to kReportRows single rows, scans to draw.
 * Unknown numbers are null. Poses are quaternion w, x, y, z and translation, between the middles of the two scans [m].
 */
nlohmann::ordered_json
reportJson(const BenchmarkResults& results, const ReportPictures& pictures);

/// JSON as the content of a script element: nothing in it can end the element.
std::string
jsonInHtml(const nlohmann::ordered_json& json);

/// The whole page, which loads nothing from anywhere.
std::string
reportHtml(const BenchmarkResults& results, const ReportPictures& pictures);

/// Replace report.html of a folder. \throw io::IoError
void
writeReport(const std::string& folder, const BenchmarkResults& results, const ReportPictures& pictures);

} // namespace apps
} // namespace pcl_ssfr
