// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/command_line.h>

namespace pcl_ssfr {
namespace apps {

namespace po = boost::program_options;

po::variables_map
parseCommandLine(const std::vector<std::string>& arguments,
                 const po::options_description& options,
                 const std::string& positional,
                 std::vector<std::string>* given)
{
  po::options_description all;
  all.add(options);
  po::positional_options_description positions;
  if (!positional.empty()) {
    all.add_options()(positional.c_str(), po::value<std::vector<std::string>>());
    positions.add(positional.c_str(), -1);
  }
  constexpr int kStyle = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
  po::variables_map values;
  try {
    const po::parsed_options parsed =
        po::command_line_parser(arguments).options(all).positional(positions).style(kStyle).run();
    po::store(parsed, values);
    if (given)
      for (const po::option& option : parsed.options)
        if (option.position_key < 0)
          given->push_back(option.string_key);
  }
  catch (const po::too_many_positional_options_error& error) {
    throw UnexpectedArgument(error.what());
  }
  catch (const po::error& error) {
    throw UsageError(error.what());
  }
  return values;
}

std::string
textOf(const po::variables_map& values, const std::string& name)
{
  if (values.count(name) == 0)
    return {};
  auto text = values[name].as<std::string>();
  if (text.empty())
    throw UsageError("--" + name + ": the value is empty");
  return text;
}

std::vector<std::string>
textsOf(const po::variables_map& values, const std::string& name)
{
  return values.count(name) > 0 ? values[name].as<std::vector<std::string>>() : std::vector<std::string>();
}

} // namespace apps
} // namespace pcl_ssfr
