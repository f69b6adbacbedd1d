// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/text_scanner.h>

#include <algorithm>
#include <charconv>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::string_view kSeparators = " \t,;\v\f";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF"; ///< some programs begin UTF-8 with it
constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 53;
constexpr std::uint64_t kHeaderWindow = 1U << 14; ///< nearly every header is shorter ... [bytes]
constexpr std::uint64_t kNextWindow = 16;
constexpr std::uint64_t kLongestHeader = 1U << 22; ///< ... and every one than this, comments included [bytes]

bool
isSeparator(char c)
{
  return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\v' || c == '\f';
}

} // namespace

std::string
headOf(const ByteSource& source, const std::string& path, const std::function<void(TextScanner&)>& readHeader)
{
  for (std::uint64_t window = kHeaderWindow;; window *= kNextWindow) {
    std::string head = source.first(window);
    if (head.size() == source.size())
      return head;
    TextScanner scanner(head, path);
    try {
      readHeader(scanner);
      if (!scanner.rest().empty()) // else its last line may be cut
        return head;
    }
    catch (const IoError& error) {
      if (window >= kLongestHeader && scanner.rest().empty())
        throw IoError(std::string(error.what()) + "; a header may have 4 MiB");
      if (window >= kLongestHeader)
        return head;
    }
  }
}

std::string_view
nextToken(std::string_view& line)
{
  std::size_t begin = 0;
  while (begin < line.size() && isSeparator(line[begin]))
    ++begin;
  std::size_t end = begin;
  while (end < line.size() && !isSeparator(line[end]))
    ++end;
  const std::string_view token = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return token;
}

std::vector<std::string_view>
splitTokens(std::string_view line)
{
  std::vector<std::string_view> tokens;
  for (auto token = nextToken(line); !token.empty(); token = nextToken(line))
    tokens.push_back(token);
  return tokens;
}

std::optional<double>
parseNumber(std::string_view token)
{
  if (token.size() > 1 && token.front() == '+' && token[1] != '-')
    token.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size())
    return std::nullopt;
  return value;
}

std::optional<std::uint64_t>
parseCount(std::string_view token)
{
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size() || value > kMaxCount)
    return std::nullopt;
  return value;
}

bool
isBlankOrComment(std::string_view line)
{
  const std::size_t begin = line.find_first_not_of(kSeparators);
  if (begin == std::string_view::npos)
    return true;
  return line[begin] == '#' || line[begin] == '%' || line.substr(begin, 2) == "//";
}

bool
TextScanner::readMore()
{
  if (!source_ || read_ == source_->size())
    return false;
  window_.erase(0, window_.size() - rest_.size());
  const std::size_t kept = window_.size();
  window_.resize(kept + static_cast<std::size_t>(std::min<std::uint64_t>(block_, source_->size() - read_)));
  source_->read(read_, window_.size() - kept, window_.data() + kept);
  read_ += window_.size() - kept;
  rest_ = window_;
  return true;
}

bool
TextScanner::next()
{
  if (rest_.empty() && !readMore())
    return false;
  ++number_;
  std::size_t end = 0;
  do
    while (end < rest_.size() && rest_[end] != '\n' && rest_[end] != '\r')
      ++end;
  while (end + 1 >= rest_.size() && readMore()); // the end of the line, and what may belong to it, or none is there
  line_ = rest_.substr(0, end);
  if (number_ == 1 && line_.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    line_.remove_prefix(kByteOrderMark.size());
  if (end < rest_.size())
    end += rest_.substr(end, 2) == "\r\n" ? 2 : 1;
  rest_.remove_prefix(end);
  return true;
}

bool
TextScanner::nextData()
{
  while (next())
    if (!isBlankOrComment(line_))
      return true;
  return false;
}

IoError
TextScanner::error(const std::string& message) const
{
  return IoError(path_ + ":" + std::to_string(number_) + ": " + message);
}

std::size_t
TextScanner::appendNumbers(std::vector<double>& values) const
{
  std::size_t count = 0;
  std::string_view line = line_;
  for (auto token = nextToken(line); !token.empty(); token = nextToken(line)) {
    const auto value = parseNumber(token);
    if (!value)
      throw error("column " + std::to_string(count + 1) + ": " + inQuotes(token) + " is not a number");
    values.push_back(*value);
    ++count;
  }
  return count;
}

std::vector<double>
TextScanner::numbers(std::size_t count, const char* what) const
{
  std::vector<double> values;
  if (appendNumbers(values) != count)
    throw error(std::string(what) + " needs " + std::to_string(count) + " numbers, the line is " + inQuotes(line_));
  return values;
}

} // namespace io
} // namespace pcl_ssfr
