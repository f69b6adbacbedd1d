// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What a method needs and what its answer means.
enum class MethodKind {
  Ssfr,        ///< ours: takes the raw scans, judges its answer
  SsfrRefined, ///< ours first, then a refiner from its answer
  Refiner,     ///< starts at the guess or at the identity
  Global       ///< finds its own start
};

/// A registration method that the programs can run, by the name that the command line and result files use.
struct Method {
  std::string name;
  std::string description; ///< half a line for the help
  MethodKind kind;
  std::string refiner;          ///< of SsfrRefined: the method that follows
  bool needs_normals = false;   ///< of Refiner and Global: works on normals, its own need or that of its features
  bool stops_by_itself = false; ///< of Refiner and Global: ends after ParameterRule::max_seconds
};

/// Whether a method judges its answer as ssfr does: ssfr alone, or with a refiner after it.
inline bool
isSsfr(const Method& method)
{
  return method.kind == MethodKind::Ssfr || method.kind == MethodKind::SsfrRefined;
}

/// All methods, in the order of the help and of reports.
const std::vector<Method>&
methods();

/// The method of this name, null when there is none.
const Method*
findMethod(const std::string& name);

/// The names of all methods, separated by commas.
std::string
methodNames();

/// Why findMethod() knows no method of a name, as the end of a sentence that begins with the name.
std::string
describeUnknown();

/// Load the module of a method that is not ours alone (comparisonMethods()): before its time runs, and before a search
/// whose answer it could not refine. \throw std::runtime_error where it cannot be loaded
void
loadModuleOf(const Method& method);

} // namespace apps
} // namespace pcl_ssfr
