// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace apps {

/// \p text with U+FFFD in place of what is no character of UTF-8.
std::string
validUtf8(std::string_view text);

/// The begin of \p text, at most \p length long [bytes], that does not end within a character of UTF-8.
std::string_view
utf8Prefix(std::string_view text, std::size_t length);

} // namespace apps
} // namespace pcl_ssfr
