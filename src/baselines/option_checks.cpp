// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "option_checks.h"

#include "common/option_checks.h"

#include <cmath>
#include <sstream>

namespace pcl_ssfr::baselines {

void
checkOption(bool is_valid, const char* name, double value, const char* bound)
{
  requireOption(is_valid, name, shortNumber(value), bound);
}

void
checkLength(const char* name, double value)
{
  checkOption(std::isfinite(value) && value >= 0, name, value, "be finite and >= 0 [m]");
}

std::string
shortNumber(double value)
{
  constexpr int kDigits = 3;
  std::ostringstream text;
  text.precision(kDigits);
  text << value;
  return text.str();
}

} // namespace pcl_ssfr::baselines
