// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/method_options.h>
#include <apps/pairs/pair_input.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What a window shows at first.
enum class WindowLayer {
  Points,  ///< both scans as points
  Patches, ///< planar patches coloured by direction
  Matches  ///< planar patches, green where they meet their like, red where they contradict
};

/// What the user of ssfr_view asked for.
struct ViewArguments {
  bool help = false;               ///< print the help and stop; nothing else is set
  bool version = false;            ///< print the version and stop; nothing else is set
  std::vector<std::string> inputs; ///< RESULT, or SOURCE and TARGET
  std::optional<std::size_t> pair; ///< row of pairs.csv, from 0
  std::string dataset;             ///< folder of the scans of benchmark results; empty: as the results say
  Perturbation perturbation = Perturbation::None;
  std::uint64_t seed = 1;
  std::string truth;         ///< file of the true pose; empty: what the input knows
  std::size_t candidate = 1; ///< that is shown closely, from 1
  std::string pictures;      ///< folder; empty: none
  bool window = false;
  WindowLayer layer = WindowLayer::Points;
  std::string screenshot; ///< of the window, which is closed then; empty: none
  MethodArguments method;
  std::vector<std::string> given; ///< long names of the options that were given, for inputs that do not take all
};

/** \brief Parse the command line of ssfr_view, program name left out.
 * \throw UsageError
 */
ViewArguments
parseViewArguments(const std::vector<std::string>& arguments);

/// The text of --help.
std::string
viewHelp();

} // namespace apps
} // namespace pcl_ssfr
