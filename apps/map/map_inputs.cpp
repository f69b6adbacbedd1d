// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_inputs.h>

#include <apps/io/e57_format.h>
#include <apps/io/loaded_cloud.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace fs = std::filesystem;

/// Files that go with scans and hold none, though their extension may be that of one.
const std::set<std::string>&
companions()
{
  static const std::set<std::string> names = {"pairs.csv",
                                              "poses.csv",
                                              "poses.txt",
                                              "links.csv",
                                              "control.csv",
                                              "results.csv",
                                              "readme.txt",
                                              "license.txt",
                                              "license",
                                              "timestamps.txt"};
  return names;
}

bool
isScan(const fs::path& path)
{
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return name.front() != '.' && companions().count(name) == 0 && io::isReadableFormat(name);
}

std::vector<std::string>
scansIn(const fs::path& folder)
{
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->is_regular_file() && isScan(entry->path()))
      found.push_back(entry->path().string());
  if (error)
    throw io::IoError(folder.string() + ": the folder cannot be read: " + error.message());
  std::sort(found.begin(), found.end());
  return found;
}

/// The last \p parts of a path.
std::string
tailOf(const std::string& path, std::size_t parts)
{
  std::size_t at = path.size();
  for (std::size_t i = 0; i < parts && at != std::string::npos && at > 0; ++i)
    at = path.find_last_of('/', at - 1);
  return at == std::string::npos || at == 0 ? path : path.substr(at + 1);
}

/// A scan, its file and what its name has behind that of the file.
struct FoundScan {
  std::string path;
  std::string file;
  std::string pick; ///< empty, or with its "#"
};

/// The scans of a file; of an E57 file those that are in it.
std::vector<FoundScan>
scansOf(const std::string& path)
{
  const std::string file = io::fileOfScan(path);
  if (!io::isE57(path))
    return {{path, path, ""}};
  std::vector<io::E57Scan> scans;
  try {
    scans = io::listE57Scans(file);
  }
  catch (const io::IoError&) {
    return {{path, file, path.substr(file.size())}};
  }
  if (file != path) {
    const std::size_t picked = io::findE57Scan(file, path.substr(file.size() + 1), scans);
    return {{scans[picked].path, file, '#' + scans[picked].pick}};
  }
  if (scans.size() == 1)
    return {{file, file, ""}};
  std::vector<FoundScan> found;
  found.reserve(scans.size());
  for (const io::E57Scan& scan : scans)
    found.push_back({scan.path, file, '#' + scan.pick});
  return found;
}

} // namespace

std::vector<std::string>
namesOfScan(const std::string& name)
{
  const std::string file = tailOf(io::fileOfScan(name), 1);
  const std::string pick = name.substr(io::fileOfScan(name).size());
  std::vector<std::string> names = {name, file + pick, file.substr(0, file.find_last_of('.')) + pick};
  if (!pick.empty())
    names.push_back(pick.substr(1));
  return names;
}

std::vector<MapInputFile>
findScans(const std::vector<std::string>& inputs)
{
  std::vector<std::string> paths;
  for (const std::string& input : inputs) {
    std::error_code error;
    if (!fs::is_directory(input, error)) {
      if (!fs::exists(io::fileOfScan(input), error))
        throw io::IoError(input + ": no such file or folder");
      paths.push_back(input);
      continue;
    }
    std::vector<std::string> found = scansIn(input);
    if (const fs::path scans = fs::path(input) / "scans"; fs::is_directory(scans, error)) {
      const std::vector<std::string> more = scansIn(scans);
      found.insert(found.end(), more.begin(), more.end());
    }
    if (found.empty())
      throw io::IoError(input + ": the folder holds no scan (" + std::string(io::readableFormats()) + ")");
    paths.insert(paths.end(), found.begin(), found.end());
  }
  std::set<std::string> seen;
  std::vector<FoundScan> scans;
  std::vector<MapInputFile> files;
  for (const std::string& path : paths)
    for (FoundScan& scan : scansOf(path)) {
      std::error_code error;
      const std::string file = fs::weakly_canonical(scan.file, error).string();
      if (!seen.insert(file + scan.path.substr(scan.file.size())).second)
        continue;
      files.push_back({scan.path, tailOf(scan.file, 1) + scan.pick});
      scans.push_back(std::move(scan));
    }
  // As much of the folders as it takes, of those that share a name only.
  for (std::size_t parts = 2;; ++parts) {
    std::map<std::string, std::size_t> count;
    for (const MapInputFile& file : files)
      ++count[file.name];
    bool is_done = true;
    for (std::size_t i = 0; i < files.size(); ++i)
      if (count[files[i].name] > 1 && files[i].name != scans[i].file + scans[i].pick) {
        files[i].name = tailOf(scans[i].file, parts) + scans[i].pick;
        is_done = false;
      }
    if (is_done)
      return files;
  }
}

} // namespace apps
} // namespace pcl_ssfr
