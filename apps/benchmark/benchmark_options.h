// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/usage_error.h>
#include <apps/pairs/pair_input.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

constexpr std::size_t kDefaultPictures = 60; ///< some 20 kB each

/// What the user of ssfr_benchmark asked for.
struct BenchmarkArguments {
  bool help = false;    ///< print the help and stop; nothing else is set
  bool version = false; ///< print the version and stop; nothing else is set
  std::vector<std::string> datasets;
  std::vector<std::string> methods; ///< as given, "all" included
  std::string out;
  std::string external;   ///< file; empty: none
  std::string parameters; ///< file; empty: none
  bool resume = false;
  bool report_only = false;                ///< run nothing, write the reports of what is in the folder again
  std::size_t pictures = kDefaultPictures; ///< pairs of which report.html holds pictures, at most
  std::string command;                     ///< the whole command line, for the report
  unsigned jobs = 1;
  unsigned threads = 1; ///< of each method, 0: all processors
  std::size_t every = 1;
  std::vector<std::size_t> pairs; ///< rows of pairs.csv, or of the pairs that --pairs-from gives, from 0; empty: all
  double timeout = 300;           ///< of wall clock [s]
  double cpu_timeout = 0;         ///< of processor time [s]; 0: no limit
  bool candidates = false;        ///< write candidates.csv
  bool rmse = true;               ///< measure overlap and RMSE at the truth
  Variation variation;            ///< what is not varied by a list
  std::uint64_t seed = 1;
  std::vector<double> resolutions; ///< [m], 0: as it is; empty: not varied
  std::vector<double> noises;      ///< [m]
  std::vector<double> overlaps;    ///< (0, 1), 0: as it is
  std::vector<double> outliers;    ///< [0, 1)
};

/** \brief Parse the command line of ssfr_benchmark, program name left out.
 * \throw UsageError
 */
BenchmarkArguments
parseBenchmarkArguments(const std::vector<std::string>& arguments);

/// The text of --help.
std::string
benchmarkHelp();

} // namespace apps
} // namespace pcl_ssfr
