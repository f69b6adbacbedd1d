// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <string>

namespace pcl_ssfr::baselines {

/// \throw std::invalid_argument "name = value, must <bound>" unless \p is_valid
void
checkOption(bool is_valid, const char* name, double value, const char* bound);

/// checkOption() for a length [m], which is finite and not negative.
void
checkLength(const char* name, double value);

/// \p value in short, for messages.
std::string
shortNumber(double value);

} // namespace pcl_ssfr::baselines
