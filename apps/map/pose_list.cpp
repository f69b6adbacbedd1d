// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/pose_list.h>

#include "common/rotation_math.h"

#include <apps/io/e57_format.h>
#include <apps/io/file_bytes.h>
#include <apps/io/text_scanner.h>
#include <apps/io/transform_file.h>
#include <apps/map/csv_table.h>
#include <apps/map/map_inputs.h>

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr std::size_t kQuaternion = 7; // numbers of a pose with a quaternion ...
constexpr std::size_t kMatrix = 16;    // ... and as a matrix, row after row

template <typename Value>
void
insertNew(std::map<std::string, Value>& values, const std::string& name, const Value& value, const io::IoError& twice)
{
  if (!values.emplace(name, value).second)
    throw twice;
}

std::map<std::string, Eigen::Isometry3d>
readTable(CsvTable& table)
{
  std::map<std::string, Eigen::Isometry3d> poses;
  const bool has_components = table.has("component");
  while (table.next()) {
    if (has_components && table.number("component") != 0)
      continue;
    Eigen::Matrix4d m;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c)
        m(r, c) = table.number("T" + std::to_string(r) + std::to_string(c));
    try {
      const std::string& name = table.field("scan");
      insertNew(poses, name, io::toRigidMotion(m), table.error("a second pose of " + io::inQuotes(name)));
    }
    catch (const std::invalid_argument& problem) {
      throw table.error(std::string("the pose ") + problem.what());
    }
  }
  return poses;
}

std::map<std::string, Eigen::Isometry3d>
readLines(const std::string& path)
{
  std::map<std::string, Eigen::Isometry3d> poses;
  const std::string bytes = io::readFile(path);
  io::TextScanner text(bytes, path);
  while (text.nextData()) {
    const std::vector<std::string_view> tokens = io::splitTokens(text.line());
    std::vector<double> values;
    for (std::size_t i = 1; i < tokens.size(); ++i)
      values.push_back(io::parseNumber(tokens[i]).value_or(std::nan("")));
    const bool is_finite = std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    if (is_finite && values.size() == kMatrix) {
      try {
        T = io::toRigidMotion(Eigen::Map<const Eigen::Matrix4d>(values.data()).transpose());
      }
      catch (const std::invalid_argument& problem) {
        throw text.error(std::string("the pose ") + problem.what());
      }
    }
    else if (is_finite && values.size() == kQuaternion) {
      const Eigen::Quaterniond q(values[6], values[3], values[4], values[5]);
      if (std::abs(q.norm() - 1) > 0.01)
        throw text.error("the quaternion has the length " + std::to_string(q.norm()) + ", not 1");
      T.linear() = q.normalized().toRotationMatrix();
      T.translation() << values[0], values[1], values[2];
    }
    else
      throw text.error("is neither \"scan tx ty tz qx qy qz qw\" nor a scan and the 16 numbers of a matrix");
    const std::string name(tokens[0]);
    insertNew(poses, name, T, text.error("a second pose of " + io::inQuotes(name)));
  }
  return poses;
}

/// By number and by name, and with the name of the file before these.
std::map<std::string, Eigen::Isometry3d>
readE57Poses(const std::string& path)
{
  std::map<std::string, Eigen::Isometry3d> poses;
  const std::string file = path.substr(path.find_last_of('/') + 1) + '#';
  std::size_t number = 0;
  for (const io::E57Scan& scan : io::listE57Scans(path)) {
    ++number;
    if (scan.T_file_scan)
      for (const std::string& name : {std::to_string(number), scan.pick}) {
        poses[name] = *scan.T_file_scan;
        poses[file + name] = *scan.T_file_scan;
      }
  }
  return poses;
}

std::map<std::string, Eigen::Isometry3d>
readTableOrLines(const std::string& path)
{
  CsvTable table(path);
  return table.has("scan") && table.has("T00") ? readTable(table) : readLines(path);
}

} // namespace

std::map<std::string, Eigen::Isometry3d>
readPoses(const std::string& path)
{
  std::map<std::string, Eigen::Isometry3d> poses = io::isE57(path) ? readE57Poses(path) : readTableOrLines(path);
  if (poses.empty())
    throw io::IoError(path + ": holds no pose");
  return poses;
}

std::vector<std::optional<Eigen::Isometry3d>>
posesOfScans(const std::map<std::string, Eigen::Isometry3d>& poses,
             const std::vector<std::string>& names,
             const std::string& file)
{
  std::map<std::string, std::vector<std::size_t>> answering; // scans by what they may be called
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const std::string& key : namesOfScan(names[i]))
      if (std::vector<std::size_t>& scans = answering[key]; scans.empty() || scans.back() != i)
        scans.push_back(i);
  std::vector<std::optional<Eigen::Isometry3d>> found(names.size());
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const std::string& key : namesOfScan(names[i])) {
      const auto pose = poses.find(key);
      if (pose == poses.end())
        continue;
      const std::vector<std::size_t>& scans = answering[key];
      if (key == names[i] || scans.size() == 1) {
        found[i] = pose->second;
        break;
      }
      const auto owns = [&](std::size_t scan) { return names[scan] == key; };
      const bool is_pick = names[i].size() > key.size() && names[i][names[i].size() - key.size() - 1] == '#';
      if (!is_pick && std::none_of(scans.begin(), scans.end(), owns))
        throw io::IoError(file + ": " + io::inQuotes(key) + " may be " + names[scans[0]] + " or " + names[scans[1]]);
    }
  return found;
}

Eigen::Isometry3d
fitPlaces(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to)
{
  Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    mean_from += from[i] / static_cast<double>(from.size());
    mean_to += to[i] / static_cast<double>(to.size());
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    sum += (to[i] - mean_to) * (from[i] - mean_from).transpose();
  const Eigen::Vector3d extents = Eigen::JacobiSVD<Eigen::Matrix3d>(sum).singularValues(); // squared
  constexpr double kLine = 1e-3; // second extent over the first one: points on a line leave a rotation open
  if (from.size() < 3 || !(extents[1] > kLine * kLine * extents[0]))
    throw std::invalid_argument("it takes three places or more that are not on a line");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(sum);
  T.translation() = mean_to - T.linear() * mean_from;
  return T;
}

} // namespace apps
} // namespace pcl_ssfr
