// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/usage_error.h>

#include <pcl_ssfr/options.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What the user of ssfr_align asked for.
struct AlignArguments {
  bool help = false;    ///< print the help and stop; nothing else is set
  bool version = false; ///< print the version and stop; nothing else is set
  std::string source;
  std::string target;
  std::string output;     ///< moved source, .pcd or .ply; empty: none
  std::string transform;  ///< file for the 4x4 transform; empty: none
  std::string json;       ///< file for the JSON report, "-": standard output, empty: none
  std::string pictures;   ///< folder for before.png and after.png; empty: none
  std::string guess_file; ///< file of a 4x4 transform; empty: none
  std::string method = "ssfr";
  Options options;
};

/** \brief Parse the command line of ssfr_align, program name left out.
 * \throw UsageError
 */
AlignArguments
parseAlignArguments(const std::vector<std::string>& arguments);

/// The text of --help.
std::string
alignHelp();

} // namespace apps
} // namespace pcl_ssfr
