// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_clouds.h>

#include <apps/io/e57_writer.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/output_file.h>
#include <apps/io/pcd_format.h>
#include <apps/map/merged_cloud.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <system_error>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace fs = std::filesystem;

constexpr double kFarFromOrigin = 1e4; // [m] from which on a float is too coarse
constexpr const char* kCopyMark = "written by ssfr_map --pcd, which may replace or remove it";

std::vector<std::size_t>
scansToWrite(const MultiwayMap& map)
{
  std::vector<std::size_t> scans;
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    if (isWritten(map.scans[i]))
      scans.push_back(i);
  return scans;
}

/// Only a copy of an earlier run may be replaced or removed. \throw io::IoError where another file is there
void
requireOwnCopy(const std::string& path)
{
  std::error_code error;
  if (fs::exists(fs::symlink_status(path, error)) && !io::isPcdWithComment(path, kCopyMark))
    throw io::IoError(path + ": is there already, and ssfr_map --pcd did not write it; take another folder");
}

/// A copy that an earlier run left of a scan that has no place now would lie about it.
void
removeStaleCopies(const std::vector<std::string>& copies, const MultiwayMap& map)
{
  for (const std::string& copy : copies)
    requireOwnCopy(copy);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    std::error_code error;
    if (!isWritten(map.scans[i]))
      fs::remove(copies[i], error);
  }
}

/// Paths of the PCD copies of all scans.
std::vector<std::string>
copyPaths(const std::string& folder, const std::vector<MapInputFile>& files)
{
  std::vector<std::string> paths = copyNames(files);
  for (std::string& path : paths)
    path = (fs::path(folder) / path).string();
  return paths;
}

} // namespace

bool
isWritten(const MapScan& scan)
{
  return scan.component == 0 && scan.usable;
}

std::vector<std::string>
shortNames(const std::vector<MapInputFile>& files)
{
  std::vector<std::string> names;
  std::map<std::string, std::size_t> count;
  for (const MapInputFile& file : files) {
    names.push_back(namesOfScan(file.name).back());
    ++count[names.back()];
  }
  for (std::size_t i = 0; i < files.size(); ++i)
    if (count[names[i]] > 1)
      names[i] = files[i].name;
  return names;
}

std::vector<std::string>
copyNames(const std::vector<MapInputFile>& files)
{
  std::vector<std::string> names = shortNames(files);
  std::set<std::string> taken;
  for (std::string& name : names) {
    for (char& c : name) {
      const auto byte = static_cast<unsigned char>(c);
      const bool is_plain = std::isalnum(byte) != 0 || byte >= 0x80 || c == '-' || c == '.' || c == ' ' || c == ',';
      c = is_plain ? c : '_';
    }
    if (name.empty() || name[0] == '.')
      name.insert(0, "_");
    const std::string first = name;
    for (int k = 2; !taken.insert(name).second; ++k)
      name = first + '_' + std::to_string(k);
    name += ".pcd";
  }
  return names;
}

std::vector<std::pair<const char*, std::string>>
outputFiles(const CloudOutputs& outputs, const std::vector<MapInputFile>& files)
{
  std::vector<std::pair<const char*, std::string>> found;
  if (!outputs.merged.empty())
    found.emplace_back("--merged", outputs.merged);
  if (!outputs.e57.empty())
    found.emplace_back("--e57", outputs.e57);
  if (!outputs.pcd.empty())
    for (const std::string& copy : copyPaths(outputs.pcd, files))
      found.emplace_back("--pcd", copy);
  return found;
}

void
checkOutputs(const CloudOutputs& outputs, const std::vector<MapInputFile>& files)
{
  std::error_code error;
  if (!outputs.pcd.empty()) {
    fs::create_directories(outputs.pcd, error);
    if (!fs::is_directory(outputs.pcd))
      throw io::IoError(outputs.pcd + ": the folder cannot be created" + (error ? ": " + error.message() : ""));
    for (const std::string& copy : copyPaths(outputs.pcd, files))
      requireOwnCopy(copy);
  }
  for (const auto& [option, path] : outputFiles(outputs, files))
    io::requireWritable(path);
}

void
writeClouds(const CloudOutputs& outputs,
            const std::vector<MapInputFile>& files,
            const MultiwayMap& map,
            const std::vector<Eigen::Vector3d>& places,
            const std::vector<std::optional<Eigen::Vector3d>>& found,
            const std::function<void(std::size_t done, std::size_t total)>& progress)
{
  const std::vector<std::size_t> scans = scansToWrite(map);
  const std::vector<std::string> names = shortNames(files);
  const std::vector<std::string> copies = copyPaths(outputs.pcd, files);
  std::optional<MergedCloud> merged;
  std::optional<io::E57Writer> e57;
  if (!outputs.merged.empty()) {
    const bool is_wide = std::any_of(scans.begin(), scans.end(), [&](std::size_t i) {
      return (map.scans[i].T_map_scan * places[i]).norm() > kFarFromOrigin;
    });
    merged.emplace(outputs.merged, outputs.merged_leaf, is_wide);
  }
  if (!outputs.e57.empty())
    e57.emplace(outputs.e57);
  if (!outputs.pcd.empty())
    removeStaleCopies(copies, map);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const std::size_t i = scans[k];
    const Eigen::Isometry3d& pose = map.scans[i].T_map_scan;
    io::LoadedCloud cloud = io::loadTable(files[i].path);
    if (found[i])
      cloud.viewpoint = found[i];
    if (merged)
      merged->add(cloud, pose, i);
    if (e57)
      e57->addScan(names[i], cloud, pose);
    if (!outputs.pcd.empty())
      io::saveMovedCloud(copies[i], cloud, pose, kCopyMark);
    progress(k + 1, scans.size());
  }
  if (merged)
    merged->finish();
  if (e57)
    e57->finish();
}

} // namespace apps
} // namespace pcl_ssfr
