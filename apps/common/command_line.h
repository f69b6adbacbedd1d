// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/usage_error.h>

#include <boost/program_options.hpp>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

constexpr unsigned kHelpWidth = 100; ///< of the lines of --help

constexpr const char* kStandardOutput = "-"; ///< in place of the name of a file that is written

/// An argument that belongs to no option, where none is taken.
class UnexpectedArgument : public UsageError {
public:
  using UsageError::UsageError;
};

/** \brief The arguments of a program by option. An abbreviation is an unknown option.
 * \param[in] positional name of the list of arguments that belong to no option, see textsOf(); empty: none are taken
 * \param[out] given names of the options that were given, in their order; may be null
 * \throw UsageError
 */
boost::program_options::variables_map
parseCommandLine(const std::vector<std::string>& arguments,
                 const boost::program_options::options_description& options,
                 const std::string& positional = "",
                 std::vector<std::string>* given = nullptr);

/// The text of option --\p name; empty: it was not given. \throw UsageError when it was, and is empty
std::string
textOf(const boost::program_options::variables_map& values, const std::string& name);

/// All texts of an option that may be given several times.
std::vector<std::string>
textsOf(const boost::program_options::variables_map& values, const std::string& name);

/// Set \p arguments.help or \p arguments.version where that is asked for. \return whether one is: the rest is not read
template <typename Arguments>
bool
asksForText(const boost::program_options::variables_map& values, Arguments& arguments)
{
  arguments.help = values.count("help") > 0;
  arguments.version = !arguments.help && values.count("version") > 0;
  return arguments.help || arguments.version;
}

} // namespace apps
} // namespace pcl_ssfr
