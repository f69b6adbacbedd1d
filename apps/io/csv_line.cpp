// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/csv_line.h>

#include <apps/common/utf8_text.h>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string
trimmed(const std::string& text)
{
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string::npos)
    return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

} // namespace

std::vector<std::string>
splitCsvLine(std::string_view line)
{
  std::vector<std::string> fields;
  std::string field;
  bool inside = false; // between quotes
  bool quoted = false; // the field had quotes: its blanks count
  const auto finish = [&] {
    fields.push_back(quoted ? field : trimmed(field));
    field.clear();
    quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (inside && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      field += '"';
      ++i;
    }
    else if (c == '"' && (inside || trimmed(field).empty())) {
      if (!inside)
        field.clear();
      inside = !inside;
      quoted = true;
    }
    else if (c == ',' && !inside) {
      finish();
    }
    else if (!quoted || inside) { // what follows a closing quote is dropped
      field += c;
    }
  }
  finish();
  return fields;
}

bool
isControl(char letter)
{
  return static_cast<unsigned char>(letter) < ' ' || letter == '\x7f';
}

std::string
csvField(std::string_view text)
{
  std::string clean;
  bool quote = !text.empty() && text.front() == '#'; // at the begin of a line it would be a comment
  for (const char c : apps::validUtf8(text)) {
    clean += isControl(c) ? ' ' : c;
    quote = quote || c == ',' || c == '"';
  }
  if (!quote && trimmed(clean) == clean)
    return clean;
  std::string field = "\"";
  for (const char c : clean) {
    if (c == '"')
      field += '"';
    field += c;
  }
  return field + '"';
}

} // namespace io
} // namespace pcl_ssfr
