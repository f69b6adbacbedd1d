// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/option_numbers.h>

#include <apps/common/usage_error.h>
#include <apps/io/text_scanner.h>

namespace pcl_ssfr {
namespace apps {

std::vector<double>
parseNumbers(const std::string& option, const std::string& text, std::size_t count, const std::string& form)
{
  std::vector<double> values;
  for (const auto token : io::splitTokens(text)) {
    const auto value = io::parseNumber(token);
    if (!value)
      throw UsageError(option + ": " + io::inQuotes(token) + " is not a number");
    values.push_back(*value);
  }
  if (values.size() != count)
    throw UsageError(option + ": " + io::inQuotes(text) + " is not " + form);
  return values;
}

std::uint64_t
parseWhole(const std::string& option, const std::string& text, std::uint64_t least, std::uint64_t most)
{
  const auto value = io::parseCount(text);
  if (!value || *value < least || *value > most)
    throw UsageError(option + ": " + io::inQuotes(text) + " is not a whole number from " + std::to_string(least) +
                     " to " + std::to_string(most));
  return *value;
}

} // namespace apps
} // namespace pcl_ssfr
