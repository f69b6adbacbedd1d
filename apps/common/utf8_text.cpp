// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/utf8_text.h>

#include <nlohmann/json.hpp>

namespace pcl_ssfr {
namespace apps {

std::string
validUtf8(std::string_view text)
{
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

std::string_view
utf8Prefix(std::string_view text, std::size_t length)
{
  if (text.size() <= length)
    return text;
  const auto continues = [&text](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xc0U) == 0x80U; };
  while (length > 0 && continues(length))
    --length;
  return text.substr(0, length);
}

} // namespace apps
} // namespace pcl_ssfr
