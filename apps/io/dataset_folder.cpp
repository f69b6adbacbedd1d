// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/dataset_folder.h>

#include <apps/io/csv_line.h>
#include <apps/io/e57_format.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/text_scanner.h>
#include <apps/io/transform_file.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <unistd.h>

namespace pcl_ssfr {
namespace io {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Columns of pairs.csv by their place; npos for a bottom row of the matrix that is left out.
struct PairColumns {
  std::size_t source = std::string::npos;
  std::size_t target = std::string::npos;
  std::vector<std::size_t> matrix; ///< 12 or 16, row major
};

std::string
matrixColumn(std::size_t i)
{
  return "T" + std::to_string(i / 4) + std::to_string(i % 4);
}

PairColumns
findColumns(const TextScanner& scanner, const std::vector<std::string>& names)
{
  const auto find = [&](const std::string& name, bool needed) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end() && needed)
      throw scanner.error("column '" + name + "' is missing in the header");
    return at == names.end() ? std::string::npos : static_cast<std::size_t>(at - names.begin());
  };
  PairColumns columns;
  columns.source = find("source", true);
  columns.target = find("target", true);
  const bool has_bottom = find("T30", false) != std::string::npos;
  for (std::size_t i = 0; i < (has_bottom ? 16U : 12U); ++i)
    columns.matrix.push_back(find(matrixColumn(i), true));
  return columns;
}

/// Whether a scan can be read, and if not, why.
std::string
problemOfScan(const std::string& folder, const std::string& scan)
{
  if (scan.empty())
    return "is empty";
  const std::string path = scanPath(folder, scan);
  std::error_code error;
  const std::string file = fileOfScan(path);
  if (!fs::is_regular_file(file, error))
    return inQuotes(scan) + " is no file in " + folder + " or its scans/";
  if (access(file.c_str(), R_OK) != 0)
    return inQuotes(scan) + " is not readable";
  if (!isReadableFormat(path))
    return inQuotes(scan) + " is of no format that is read here (" + readableFormats() + ")";
  return {};
}

ScanPair
readPair(const TextScanner& scanner, const PairColumns& columns, std::size_t count, const std::string& folder)
{
  const std::vector<std::string> fields = splitCsvLine(scanner.line());
  if (fields.size() != count)
    throw scanner.error(std::to_string(fields.size()) + " columns, the header has " + std::to_string(count));
  ScanPair pair;
  pair.source = fields[columns.source];
  pair.target = fields[columns.target];
  for (const auto& [name, scan] : {std::pair{"source", pair.source}, std::pair{"target", pair.target}}) {
    const std::string problem = problemOfScan(folder, scan);
    if (!problem.empty())
      throw scanner.error(std::string("column ") + name + ": " + problem);
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < columns.matrix.size(); ++i) {
    const std::string& field = fields[columns.matrix[i]];
    const auto value = parseNumber(field);
    if (!value || !std::isfinite(*value))
      throw scanner.error("column " + matrixColumn(i) + ": " + inQuotes(field) + " is not a finite number");
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = *value;
  }
  try {
    pair.T_target_source = toRigidMotion(matrix);
  }
  catch (const std::invalid_argument& error) {
    throw scanner.error("columns T00 to T" + std::string(columns.matrix.size() > 12 ? "33" : "23") + ": the matrix " +
                        error.what());
  }
  return pair;
}

std::vector<ScanPair>
readPairs(const std::string& folder)
{
  const std::string path = (fs::path(folder) / "pairs.csv").string();
  const std::string content = readFile(path);
  TextScanner scanner(content, path);
  if (!scanner.next())
    throw IoError(path + ": is empty");
  const std::vector<std::string> names = splitCsvLine(scanner.line());
  const PairColumns columns = findColumns(scanner, names);
  std::vector<ScanPair> pairs;
  while (scanner.next())
    if (!isBlankOrComment(scanner.line()))
      pairs.push_back(readPair(scanner, columns, names.size(), folder));
  if (pairs.empty())
    throw IoError(path + ": holds no pair");
  return pairs;
}

double
positiveNumber(const Json& json, const char* key, double fallback, const std::string& path)
{
  if (!json.contains(key))
    return fallback;
  if (!json[key].is_number() || !(json[key].get<double>() > 0))
    throw IoError(path + ": success." + key + ": " + inQuotes(json[key].dump()) + " is not a number above 0");
  return json[key].get<double>();
}

std::string
textValue(const Json& json, const char* key, const std::string& fallback, const std::string& path)
{
  if (!json.contains(key))
    return fallback;
  if (!json[key].is_string())
    throw IoError(path + ": " + key + ": " + inQuotes(json[key].dump()) + " is not a text");
  return json[key].get<std::string>();
}

void
readDescription(const std::string& path, DatasetFolder& dataset)
{
  Json json;
  try {
    json = Json::parse(readFile(path));
  }
  catch (const Json::exception& error) {
    throw IoError(path + ": is not JSON: " + error.what());
  }
  if (!json.is_object())
    throw IoError(path + ": is not a JSON object");
  dataset.name = textValue(json, "name", dataset.name, path);
  if (dataset.name.empty() || std::any_of(dataset.name.begin(), dataset.name.end(), isControl))
    throw IoError(path + ": name: " + json["name"].dump() + " is empty or holds more than a line");
  dataset.sensor = textValue(json, "sensor", "", path);
  dataset.note = textValue(json, "note", "", path);
  const std::string viewpoint = textValue(json, "viewpoint", "sensor", path);
  if (viewpoint != "sensor" && viewpoint != "unknown")
    throw IoError(path + ": viewpoint: " + inQuotes(viewpoint) + " is not sensor or unknown");
  dataset.sensor_at_origin = viewpoint == "sensor";
  if (json.contains("success")) {
    if (!json["success"].is_object())
      throw IoError(path + ": success: " + inQuotes(json["success"].dump()) + " is not an object");
    dataset.success_rotation_deg = positiveNumber(json["success"], "rotation_deg", dataset.success_rotation_deg, path);
    dataset.success_translation_m =
        positiveNumber(json["success"], "translation_m", dataset.success_translation_m, path);
  }
}

} // namespace

std::string
scanPath(const std::string& folder, const std::string& scan)
{
  const fs::path in_folder = fs::path(folder) / scan;
  std::error_code error;
  return fs::exists(fileOfScan(in_folder.string()), error) ? in_folder.string()
                                                           : (fs::path(folder) / "scans" / scan).string();
}

DatasetFolder
readDatasetFolder(const std::string& path)
{
  std::error_code error;
  if (!fs::is_directory(path, error))
    throw IoError(path + ": is not a folder");
  DatasetFolder dataset;
  dataset.path = path;
  dataset.name = fs::weakly_canonical(path, error).filename().string();
  const std::string description = (fs::path(path) / "dataset.json").string();
  if (fs::exists(description, error))
    readDescription(description, dataset);
  dataset.pairs = readPairs(path);
  return dataset;
}

} // namespace io
} // namespace pcl_ssfr
