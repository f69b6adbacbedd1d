// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/usage_error.h>
#include <apps/methods/method_options.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What the user of ssfr_align asked for.
struct AlignArguments : MethodArguments {
  bool help = false;    ///< print the help and stop; nothing else is set
  bool version = false; ///< print the version and stop; nothing else is set
  std::string source;
  std::string target;
  std::string output;    ///< moved source, .pcd, .ply or .e57; empty: none
  std::string transform; ///< file for the 4x4 transform, kStandardOutput or empty: none
  std::string json;      ///< file for the JSON report, kStandardOutput or empty: none
  std::string pictures;  ///< folder for before.png and after.png; empty: none
};

/** \brief Parse the command line of ssfr_align, program name left out.
 * \throw UsageError also when two results would go to one file, or one in the place of a scan
 */
AlignArguments
parseAlignArguments(const std::vector<std::string>& arguments);

/// The text of --help.
std::string
alignHelp();

} // namespace apps
} // namespace pcl_ssfr
