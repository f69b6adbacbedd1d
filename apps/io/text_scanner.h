// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_ssfr {
namespace io {

/** \brief Walks a text line by line and knows where it is, so that errors can say so.
 * Lines end in LF, CR LF or CR. A byte order mark of UTF-8 is skipped. The text outlives the scanner.
 */
class TextScanner {
public:
  TextScanner(std::string_view text, const std::string& path) : rest_(text), path_(path) {}
  /// A file of which \p block bytes at a time are in memory, or as many as its longest line has; > 0.
  TextScanner(const ByteSource& source, const std::string& path, std::size_t block = kTextBlock)
      : source_(&source), block_(block), path_(path)
  {}
  TextScanner(const TextScanner&) = delete;
  TextScanner&
  operator=(const TextScanner&) = delete;

  /// Go to the next line; false at the end. What line() gave before is gone.
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
  /// What follows the current line in memory.
  std::string_view
  rest() const
  {
    return rest_;
  }
  /// Bytes that follow the current line.
  std::uint64_t
  left() const
  {
    return rest_.size() + (source_ ? source_->size() - read_ : 0);
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
  static constexpr std::size_t kTextBlock = std::size_t{1} << 18; ///< [bytes]

  /// Take more of the file into memory; false at its end.
  bool
  readMore();

  const ByteSource* source_ = nullptr; ///< null: all of the text is in memory
  std::size_t block_ = 0;
  std::uint64_t read_ = 0; ///< bytes of the file that are or were in memory
  std::string window_;     ///< of the file
  std::string_view rest_;
  std::string_view line_;
  const std::string& path_;
  std::size_t number_ = 0;
};

/** \brief The beginning of a file that has a header of lines: all of the header and some of what follows, or the whole
 * file. Of a file whose header cannot be read 4 MiB at least.
 * \throw IoError when the header is longer than that
 */
std::string
headOf(const ByteSource& source, const std::string& path, const std::function<void(TextScanner&)>& readHeader);

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
