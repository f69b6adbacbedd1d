// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/** \brief Walks a text line by line and knows where it is, so that errors can say so.
 * Lines end in LF, CR LF or CR. The text outlives the scanner.
 */
class TextScanner {
public:
  TextScanner(std::string_view text, const std::string& path) : rest_(text), path_(path) {}

  /// Go to the next line; false at the end.
  bool
  next();
  /// Go to the next line that is neither blank nor a comment (#, //, %); false at the end.
  bool
  nextData();
  /// The current line without its end.
  std::string_view
  line() const
  {
    return line_;
  }
  /// What follows the current line.
  std::string_view
  rest() const
  {
    return rest_;
  }
  /// An error that names the file and the current line.
  IoError
  error(const std::string& message) const;
  /// The numbers of the current line, appended to \p values; throws error() at what is no number.
  std::size_t
  appendNumbers(std::vector<double>& values) const;
  /// Exactly \p count numbers of the current line; throws error(), with \p what the line should be, otherwise.
  std::vector<double>
  numbers(std::size_t count, const char* what) const;

private:
  std::string_view rest_;
  std::string_view line_;
  const std::string& path_;
  std::size_t number_ = 0;
};

/// Cut the next token off the front of \p line (separators: blanks, comma, semicolon); empty at the end.
std::string_view
nextToken(std::string_view& line);

/// All tokens of a line.
std::vector<std::string_view>
splitTokens(std::string_view line);

/// The whole token as a number, whatever the locale; "nan" and "inf" are numbers. Nothing for anything else.
std::optional<double>
parseNumber(std::string_view token);

/// The whole token as a count in [0, 2^53].
std::optional<std::uint64_t>
parseCount(std::string_view token);

/// True for a blank line or a comment.
bool
isBlankOrComment(std::string_view line);

} // namespace io
} // namespace pcl_ssfr
