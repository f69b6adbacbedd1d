// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <sstream>
#include <stdexcept>
#include <string_view>

namespace pcl_ssfr {

/// \throw std::invalid_argument "name = value, must <bound>"
template <typename Value>
[[noreturn]] void
rejectOption(std::string_view name, const Value& value, std::string_view bound)
{
  std::ostringstream text;
  text << name << " = " << value << ", must " << bound;
  throw std::invalid_argument(text.str());
}

/// rejectOption() unless \p good. Conditions are written so that NaN is not good.
template <typename Value>
void
requireOption(bool good, std::string_view name, const Value& value, std::string_view bound)
{
  if (!good)
    rejectOption(name, value, bound);
}

} // namespace pcl_ssfr
