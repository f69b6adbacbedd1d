// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

/// A file that cannot be read or written. what() is one line that names the file, the line or field, and the value.
class IoError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// \p text made fit for a one-line message: quoted, unprintable bytes as '?', cut after 40 bytes.
std::string
inQuotes(std::string_view text);

} // namespace io
} // namespace pcl_ssfr
