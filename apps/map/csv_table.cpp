// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/csv_table.h>

#include <apps/io/csv_line.h>
#include <apps/io/file_bytes.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace pcl_ssfr {
namespace apps {

CsvTable::CsvTable(const std::string& path) : path_(path), bytes_(io::readFile(path)), text_(bytes_, path_)
{
  if (text_.nextData())
    columns_ = io::splitCsvLine(text_.line());
}

bool
CsvTable::has(const std::string& column) const
{
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

bool
CsvTable::next()
{
  if (!text_.nextData())
    return false;
  row_ = io::splitCsvLine(text_.line());
  if (row_.size() != columns_.size())
    throw text_.error("has " + std::to_string(row_.size()) + " fields, the first line names " +
                      std::to_string(columns_.size()));
  return true;
}

const std::string&
CsvTable::field(const std::string& column) const
{
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end())
    throw io::IoError(path_ + ": the column " + column + " is missing");
  return row_[static_cast<std::size_t>(found - columns_.begin())];
}

double
CsvTable::number(const std::string& column) const
{
  const std::optional<double> value = io::parseNumber(field(column));
  if (!value || !std::isfinite(*value))
    throw text_.error("the column " + column + " is " + io::inQuotes(field(column)) + ", no number");
  return *value;
}

} // namespace apps
} // namespace pcl_ssfr
