// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/text_formats.h>

#include <apps/io/text_scanner.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

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

/// Whether numbers are a unit vector, or zeros or NaN where there is none.
bool
isNormal(const double* v)
{
  const double length = std::hypot(v[0], v[1], v[2]);
  return !(length > 0) || std::abs(length - 1) < kUnitTolerance;
}

/// Whether numbers are integers of 0..255.
bool
isColour(const double* v)
{
  return std::all_of(v, v + 3, [](double c) { return c >= 0 && c <= 255 && c == std::floor(c); });
}

/// The rows of a table of numbers: those columns that are kept, and what columns without names may hold.
class TableRows {
public:
  /// \param[in] names of the columns, empty where the file has none \param[in] first row
  TableRows(const std::vector<std::string>& names, FieldChoice choice, const std::vector<double>& first)
      : columns_(first.size()), names_(names)
  {
    if (names_.empty())
      for (std::size_t at = columns_ % 3 == 1 ? 4 : 3; at + 3 <= columns_; at += 3)
        triples_.push_back({at, true, true});
    look(first);
    for (std::size_t column = 0; column < columns_; ++column)
      if (choice == FieldChoice::kAll || (names_.empty() ? mayBeGeometry(column) : isKept(choice, names_[column])))
        kept_.push_back(column);
  }

  /// Make room for so many rows.
  void
  reserve(std::size_t rows)
  {
    values_.reserve(rows * kept_.size());
  }

  /// A number for each column.
  void
  add(const std::vector<double>& row)
  {
    look(row);
    for (const std::size_t column : kept_)
      values_.push_back(row[column]);
    ++rows_;
  }

  std::size_t
  rows() const
  {
    return rows_;
  }

  pcl::PCLPointCloud2
  table() const
  {
    const std::vector<std::string> all = names_.empty() ? guessedNames() : names_;
    std::vector<std::string> names;
    for (const std::size_t column : kept_)
      names.push_back(all[column]);
    return tableFromColumns(names, values_);
  }

private:
  /// Three columns without names, and what they still may be.
  struct Triple {
    std::size_t first;
    bool normals, colours;
  };

  void
  look(const std::vector<double>& row)
  {
    for (Triple& triple : triples_) {
      triple.normals = triple.normals && isNormal(row.data() + triple.first);
      triple.colours = triple.colours && isColour(row.data() + triple.first);
    }
  }

  bool
  mayBeGeometry(std::size_t column) const
  {
    return column < 3 || std::any_of(triples_.begin(), triples_.end(), [&](const Triple& triple) {
             return triple.normals && column >= triple.first && column < triple.first + 3;
           });
  }

  /// What the columns of a file without names hold, inferred from their number and values.
  std::vector<std::string>
  guessedNames() const
  {
    std::vector<std::string> names{"x", "y", "z"};
    const auto add = [&names](std::initializer_list<std::string> more) { names.insert(names.end(), more); };
    if (columns_ % 3 == 1)
      add({"intensity"});
    for (const Triple& triple : triples_) {
      if (!contains(names, "normal_x") && triple.normals)
        add({"normal_x", "normal_y", "normal_z"});
      else if (!contains(names, "red") && triple.colours)
        add({"red", "green", "blue"});
      else
        break;
    }
    while (names.size() < columns_)
      names.push_back("column_" + std::to_string(names.size() + 1));
    return names;
  }

  std::size_t columns_;
  std::vector<std::string> names_;
  std::vector<Triple> triples_;
  std::vector<std::size_t> kept_;
  std::vector<double> values_;
  std::size_t rows_ = 0;
};

/// Lines of a file with one kind of line ends.
std::uint64_t
countLines(const ByteSource& source)
{
  std::uint64_t feeds = 0, returns = 0;
  std::string block;
  for (std::uint64_t at = 0; at < source.size(); at += block.size()) {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, source.size() - at)));
    source.read(at, block.size(), block.data());
    feeds += static_cast<std::uint64_t>(std::count(block.begin(), block.end(), '\n'));
    returns += static_cast<std::uint64_t>(std::count(block.begin(), block.end(), '\r'));
  }
  return std::max(feeds, returns) + 1;
}

/// A first data line that holds one count and nothing else.
std::optional<std::uint64_t>
pointCountLine(std::string_view line)
{
  const auto tokens = splitTokens(line);
  return tokens.size() == 1 ? parseCount(tokens[0]) : std::nullopt;
}

/// Whether blanks separate the columns of a line, none has a point, and some have a comma between digits: "0,72 2
/// -1,25".
bool
hasDecimalCommas(std::string_view line)
{
  constexpr std::string_view kBlanks = " \t";
  constexpr std::string_view kDigits = "0123456789";
  bool found = false;
  std::size_t columns = 0;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty())
      return found && columns >= 3;
    std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    line.remove_prefix(word.size());
    ++columns;
    if (word.front() == '-' || word.front() == '+')
      word.remove_prefix(1);
    const std::size_t comma = word.find(',');
    const std::string_view before = word.substr(0, comma);
    const std::string_view after = comma == std::string_view::npos ? "0" : word.substr(comma + 1);
    for (const std::string_view digits : {before, after})
      if (digits.empty() || digits.find_first_not_of(kDigits) != std::string_view::npos)
        return false;
    found = found || comma != std::string_view::npos;
  }
}

bool
startsWithNumber(std::string_view line)
{
  return parseNumber(nextToken(line)).has_value();
}

} // namespace

RawCloud
readTextTable(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  TextScanner scanner(source, path);
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

  std::optional<TableRows> rows;
  std::vector<double> row;
  std::size_t columns = 0;
  do {
    const std::string_view line = scanner.line();
    if (isBlankOrComment(line))
      continue;
    if (line.find(';') != std::string_view::npos && line.find(',') != std::string_view::npos)
      throw scanner.error("both ',' and ';' in one line: decimal commas are not supported");
    if (!rows && hasDecimalCommas(line))
      throw scanner.error(inQuotes(line) + " has commas within its columns: decimal commas are not supported");
    if (const auto count = declared ? pointCountLine(line) : std::nullopt; count && *count <= UINT32_MAX) {
      *declared += *count; // the next scan of a PTS file
      continue;
    }
    row.clear();
    const std::size_t got = scanner.appendNumbers(row);
    if (!rows) {
      if (names_in_comment && got != names.size())
        names.clear();
      if (!names.empty() && got != names.size())
        throw scanner.error(std::to_string(got) + " columns, but there are " + std::to_string(names.size()) + " names");
      if (got < 3)
        throw scanner.error(std::to_string(got) + " columns, at least x, y and z are needed");
      if (got > kMaxFields)
        throw scanner.error(std::to_string(got) + " columns, at most " + std::to_string(kMaxFields) + " are supported");
      columns = got;
      rows.emplace(names, fields, row);
      // Each number takes a byte and a separator; the last one may lack it.
      rows->reserve(static_cast<std::size_t>(std::min(countLines(source), (scanner.left() + 1) / (2 * columns) + 1)));
    }
    if (got != columns)
      throw scanner.error(std::to_string(got) + " columns, expected " + std::to_string(columns) +
                          " as in the first line of points");
    rows->add(row);
  } while (scanner.next());
  const std::size_t points = rows ? rows->rows() : 0;
  if (declared && *declared != points)
    throw IoError(path + ": declares " + std::to_string(*declared) + " points, holds " + std::to_string(points));
  return {rows ? rows->table() : tableFromColumns({"x", "y", "z"}, {}), std::nullopt, std::nullopt};
}

} // namespace io
} // namespace pcl_ssfr
