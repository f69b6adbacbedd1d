// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "dataset_folder.h"

#include <pcl/common/point_tests.h>
#include <pcl/io/pcd_io.h>

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace pcl_ssfr::benchmarks {

namespace {

std::vector<std::string>
splitAtCommas(const std::string& line)
{
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');)
    fields.push_back(field);
  return fields;
}

} // namespace

std::vector<ScanPair>
readPairs(const std::filesystem::path& folder)
{
  const std::string file = (folder / "pairs.csv").string();
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line))
    throw std::runtime_error(file + ": cannot read");
  std::map<std::string, std::size_t> columns;
  for (const std::string& name : splitAtCommas(line))
    columns.emplace(name, columns.size());

  std::vector<ScanPair> pairs;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.empty())
      continue;
    try {
      const std::vector<std::string> fields = splitAtCommas(line);
      const auto field = [&](const std::string& name) { return fields.at(columns.at(name)); };
      ScanPair pair;
      pair.source = field("source");
      pair.target = field("target");
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column)
          pair.T_target_source.matrix()(row, column) =
              std::stod(field("T" + std::to_string(row) + std::to_string(column)));
      }
      pairs.push_back(pair);
    }
    catch (const std::logic_error&) { // a missing column or no number
      throw std::runtime_error(file + ":" + std::to_string(number) + ": not a pair with ground truth");
    }
  }
  return pairs;
}

pcl::PointCloud<pcl::PointXYZ>::Ptr
loadScan(const std::filesystem::path& folder, const std::string& name)
{
  const std::filesystem::path beside = folder / name;
  const std::string file = std::filesystem::exists(beside) ? beside.string() : (folder / "scans" / name).string();
  pcl::PointCloud<pcl::PointXYZ> all;
  if (pcl::io::loadPCDFile(file, all) < 0)
    throw std::runtime_error(file + ": cannot read");
  auto finite = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const pcl::PointXYZ& point : all) {
    if (pcl::isXYZFinite(point))
      finite->push_back(point);
  }
  return finite;
}

} // namespace pcl_ssfr::benchmarks
