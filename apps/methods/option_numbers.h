// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// The \p count numbers of an option "--name", between commas or blanks; they may be infinite or NaN.
/// \param[in] form how they are asked for
/// \throw UsageError
std::vector<double>
parseNumbers(const std::string& option, const std::string& text, std::size_t count, const std::string& form);

/// The whole number of an option "--name", in [\p least, \p most]. \throw UsageError
std::uint64_t
parseWhole(const std::string& option, const std::string& text, std::uint64_t least, std::uint64_t most);

} // namespace apps
} // namespace pcl_ssfr
