// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

/// A command line that cannot be run; what() is one line that names the option or argument.
class UsageError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

} // namespace apps
} // namespace pcl_ssfr
