// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/options.h>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {

Options
makeOptions(Profile profile)
{
  Options options;
  options.profile = profile;
  return options;
}

void
validate(const Options&)
{}

} // namespace pcl_ssfr
