// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/threedtk_format.h>

#include <apps/io/text_scanner.h>

#include <algorithm>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr double kMetresPerCentimetre = 0.01;

} // namespace

RawCloud
readThreedtk(const std::string& path, std::string_view bytes)
{
  TextScanner scanner(bytes, path);
  std::vector<double> values;
  std::vector<double> line;
  std::size_t columns = 0;
  bool first = true;
  while (scanner.nextData()) {
    // The first line may be the number of points, or the resolution ("361 x 245").
    if (first) {
      first = false;
      const auto tokens = splitTokens(scanner.line());
      if (tokens.size() < 3 || tokens[1] == "x")
        continue;
    }
    line.clear();
    const std::size_t got = scanner.appendNumbers(line);
    if (columns == 0)
      columns = got;
    if (got != columns || got < 3 || got > 7)
      throw scanner.error(std::to_string(got) + " values, expected x y z, reflectance and colour like the first point");
    const double x = line[0];
    line[0] = line[2] * kMetresPerCentimetre;
    line[2] = line[1] * kMetresPerCentimetre;
    line[1] = -x * kMetresPerCentimetre;
    values.insert(values.end(), line.begin(), line.end());
  }
  if (values.empty())
    throw IoError(path + ": holds no points");
  std::vector<std::string> names{"x", "y", "z"};
  if (columns == 4 || columns == 7)
    names.emplace_back("intensity");
  if (columns >= 6)
    names.insert(names.end(), {"red", "green", "blue"});
  while (names.size() < columns)
    names.push_back("column_" + std::to_string(names.size() + 1));
  return {tableFromColumns(names, values), std::nullopt, std::nullopt};
}

} // namespace io
} // namespace pcl_ssfr
