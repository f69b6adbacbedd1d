// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/io_error.h>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::size_t kQuotedLength = 40;

} // namespace

std::string
inQuotes(std::string_view text)
{
  std::string result = "'";
  for (const char c : text.substr(0, kQuotedLength))
    result += (c >= ' ' && c <= '~') ? c : '?';
  return result + (text.size() > kQuotedLength ? "...'" : "'");
}

} // namespace io
} // namespace pcl_ssfr
