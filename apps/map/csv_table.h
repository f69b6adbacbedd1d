// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/io_error.h>
#include <apps/io/text_scanner.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A CSV file by the names of its columns. Everything throws io::IoError that names file, line and field.
class CsvTable {
public:
  explicit CsvTable(const std::string& path);
  CsvTable(const CsvTable&) = delete; // the scanner looks into the bytes
  CsvTable&
  operator=(const CsvTable&) = delete;

  bool
  has(const std::string& column) const;
  /// Go to the next row; false: there is none.
  bool
  next();
  const std::string&
  field(const std::string& column) const;
  /// A finite number.
  double
  number(const std::string& column) const;
  io::IoError
  error(const std::string& message) const
  {
    return text_.error(message);
  }

private:
  std::string path_;
  std::string bytes_;
  io::TextScanner text_;
  std::vector<std::string> columns_;
  std::vector<std::string> row_;
};

} // namespace apps
} // namespace pcl_ssfr
