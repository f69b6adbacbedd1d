// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/options.h>

#include <boost/program_options.hpp>

#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How a registration is run, as the command line says it.
struct MethodArguments {
  std::string method = "ssfr";
  std::string guess_file; ///< file of a 4x4 transform; empty: none
  Options options;
  std::vector<std::string> unread; ///< options that were given, "--name", though the method does not read them
};

/// Add the options that every program takes which runs one registration: method, scales, threads, --help, --version.
void
addMethodOptions(boost::program_options::options_description& all);

/// The values of these options. \throw UsageError
MethodArguments
readMethodOptions(const boost::program_options::variables_map& values);

/// Say of each option that had no effect that it had none, a line each.
void
warnOfUnread(const MethodArguments& arguments, const std::string& program, std::ostream& out);

} // namespace apps
} // namespace pcl_ssfr
