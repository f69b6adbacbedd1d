// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/** \brief The fields of one line of a CSV file. A field in double quotes may hold commas, and a doubled quote means
 * one; blanks around a field and a CR at the end of the line are dropped.
 */
std::vector<std::string>
splitCsvLine(std::string_view line);

/// Whether a letter is a line end or another control character, which a field does not keep.
bool
isControl(char letter);

/// \p text as one field: quoted when it must be, with every line end and other control character as a blank, and in
/// UTF-8: U+FFFD in place of what is not.
std::string
csvField(std::string_view text);

} // namespace io
} // namespace pcl_ssfr
