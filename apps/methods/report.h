// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/method_run.h>

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// One run of one method on one pair, and what it cost.
struct Report {
  std::string source; ///< path
  std::string target; ///< path
  std::string method;
  MethodRun run;
  double loading_seconds = 0;             ///< [s]
  double peak_rss_mib = 0;                ///< [MiB]
  Options options;                        ///< that it was run with
  std::optional<Eigen::Isometry3d> guess; ///< in file coordinates
  /// Where distances between poses are measured, see referencePoint() [m].
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();
};

/// Largest resident memory of this process so far [MiB].
double
peakRssMib();

/// Everything that was found, with the keys that scripts rely on; what a method does not know is null.
nlohmann::ordered_json
toJson(const Report& report);

/// The text of toJson(), whatever bytes file names hold.
std::string
toJsonText(const Report& report);

/// The same for people: metres and degrees, what was found, how sure it is, what else it may be.
std::string
toText(const Report& report);

/// Where the sensors are taken to be, for people.
std::string
describeSensors(const Result& result);

/// One line: the answer, or why there is none.
std::string
headline(const Report& report);

} // namespace apps
} // namespace pcl_ssfr
