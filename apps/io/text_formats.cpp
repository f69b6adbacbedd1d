// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/text_formats.h>

#include <apps/io/text_scanner.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr double kUnitTolerance = 0.02; ///< of the length of a normal written with few digits

bool
contains(const std::vector<std::string>& names, const char* name)
{
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The names on a line of words, canonical and distinct; one more than a file may have where there are more.
std::vector<std::string>
headerNames(std::string_view line)
{
  // Names may hold blanks ("Time in sec, x [m]"): where there are commas only they separate.
  std::vector<std::string> names;
  const char separator = line.find(',') != std::string_view::npos   ? ','
                         : line.find(';') != std::string_view::npos ? ';'
                                                                    : ' ';
  std::map<std::string, int> last; // number that a name was given, of all that are taken
  const auto add = [&](std::string_view token) {
    const std::string name = canonicalName(token);
    std::string distinct = name;
    for (int i = last.count(name) > 0 ? last[name] + 1 : 1; last.count(distinct) > 0; ++i) {
      last[name] = i;
      distinct = name + "_" + std::to_string(i);
    }
    last.emplace(distinct, 1);
    names.push_back(distinct);
  };
  if (separator == ' ') {
    for (auto token = nextToken(line); !token.empty() && names.size() <= kMaxFields; token = nextToken(line))
      if (token != "//" && token != "#" && token != "%")
        add(token);
    return names;
  }
  while (!line.empty() && names.size() <= kMaxFields) {
    const std::size_t end = std::min(line.find(separator), line.size());
    add(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return names;
}

/// True when three columns from \p column on hold unit vectors (or zeros, or NaN) in every row.
bool
areNormals(const std::vector<double>& values, std::size_t columns, std::size_t column)
{
  for (std::size_t i = column; i < values.size(); i += columns) {
    const double length = std::hypot(values[i], values[i + 1], values[i + 2]);
    if (length > 0 && !(std::abs(length - 1) < kUnitTolerance))
      return false;
  }
  return true;
}

/// True when three columns from \p column on hold integers of 0..255 in every row.
bool
areColours(const std::vector<double>& values, std::size_t columns, std::size_t column)
{
  for (std::size_t i = column; i < values.size(); i += columns)
    for (std::size_t k = i; k < i + 3; ++k)
      if (!(values[k] >= 0 && values[k] <= 255 && values[k] == std::floor(values[k])))
        return false;
  return true;
}

/// What the columns of a file without names hold, inferred from their number and values.
std::vector<std::string>
guessNames(const std::vector<double>& values, std::size_t columns)
{
  std::vector<std::string> names{"x", "y", "z"};
  const auto add = [&names](std::initializer_list<std::string> more) { names.insert(names.end(), more); };
  if (columns % 3 == 1)
    add({"intensity"});
  while (names.size() + 3 <= columns) {
    const std::size_t next = names.size();
    if (!contains(names, "normal_x") && areNormals(values, columns, next))
      add({"normal_x", "normal_y", "normal_z"});
    else if (!contains(names, "red") && areColours(values, columns, next))
      add({"red", "green", "blue"});
    else
      break;
  }
  while (names.size() < columns)
    names.push_back("column_" + std::to_string(names.size() + 1));
  return names;
}

/// Numbers that lines of \p columns each hold at most: each takes a byte and a separator.
std::size_t
mostNumbers(std::string_view lines, std::size_t columns)
{
  const auto count = static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')) + 1;
  return std::min(columns * count, lines.size() / 2 + 1);
}

/// A first data line that holds one count and nothing else.
std::optional<std::uint64_t>
pointCountLine(std::string_view line)
{
  const auto tokens = splitTokens(line);
  return tokens.size() == 1 ? parseCount(tokens[0]) : std::nullopt;
}

bool
startsWithNumber(std::string_view line)
{
  return parseNumber(nextToken(line)).has_value();
}

} // namespace

RawCloud
readTextTable(const std::string& path, std::string_view bytes)
{
  TextScanner scanner(bytes, path);
  std::vector<std::string> names;
  bool names_in_comment = false; // a remark that may mean something else
  std::optional<std::uint64_t> declared;
  bool more = scanner.next();
  // Comments, names and the count come before the points.
  for (; more; more = scanner.next()) {
    const std::string_view line = scanner.line();
    if (isBlankOrComment(line)) {
      const auto candidate = headerNames(line);
      if (contains(candidate, "x") && contains(candidate, "y") && contains(candidate, "z")) {
        names = candidate;
        names_in_comment = true;
      }
    }
    else if (const auto count = pointCountLine(line); count && !declared) {
      declared = count;
    }
    else if (!startsWithNumber(line) && (names.empty() || names_in_comment)) {
      names = headerNames(line);
      names_in_comment = false;
      if (names.size() > kMaxFields)
        throw scanner.error("more than " + std::to_string(kMaxFields) + " names of columns");
      for (const char* needed : {"x", "y", "z"})
        if (!contains(names, needed))
          throw scanner.error("neither numbers nor a line of column names with '" + std::string(needed) +
                              "': " + inQuotes(line));
    }
    else {
      break;
    }
  }
  if (!more)
    throw IoError(path + ": holds no points");

  std::vector<double> values;
  std::size_t columns = 0;
  do {
    const std::string_view line = scanner.line();
    if (isBlankOrComment(line))
      continue;
    if (line.find(';') != std::string_view::npos && line.find(',') != std::string_view::npos)
      throw scanner.error("both ',' and ';' in one line: decimal commas are not supported");
    if (const auto count = declared ? pointCountLine(line) : std::nullopt; count && *count <= UINT32_MAX) {
      *declared += *count; // the next scan of a PTS file
      continue;
    }
    const std::size_t got = scanner.appendNumbers(values);
    if (columns == 0) {
      if (names_in_comment && got != names.size())
        names.clear();
      if (!names.empty() && got != names.size())
        throw scanner.error(std::to_string(got) + " columns, but there are " + std::to_string(names.size()) + " names");
      if (got < 3)
        throw scanner.error(std::to_string(got) + " columns, at least x, y and z are needed");
      if (got > kMaxFields)
        throw scanner.error(std::to_string(got) + " columns, at most " + std::to_string(kMaxFields) + " are supported");
      columns = got;
      values.reserve(columns + mostNumbers(scanner.rest(), columns));
    }
    if (got != columns)
      throw scanner.error(std::to_string(got) + " columns, expected " + std::to_string(columns) +
                          " as in the first line of points");
  } while (scanner.next());
  const std::size_t points = columns == 0 ? 0 : values.size() / columns;
  if (declared && *declared != points)
    throw IoError(path + ": declares " + std::to_string(*declared) + " points, holds " + std::to_string(points));
  return {tableFromColumns(names.empty() ? guessNames(values, columns) : names, values), std::nullopt, std::nullopt};
}

} // namespace io
} // namespace pcl_ssfr
