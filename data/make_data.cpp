// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Writes the scans of this folder, their pairs with ground truth and dataset.json. See README.md.

#include "synthetic_scene.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ssfr::testing;

constexpr double kDegree = 3.14159265358979323846 / 180;

/// A scan and how it is made.
struct ScanRecipe {
  std::string file;
  Scene scene;
  Eigen::Isometry3d T_world_sensor;
  SensorPattern pattern;
  std::uint64_t noise_seed;
};

/// Source and target of a pair, as indices into the scans.
struct Pair {
  std::size_t source;
  std::size_t target;
};

void
requireGood(const std::ostream& stream, const std::filesystem::path& file)
{
  if (!stream)
    throw std::runtime_error("cannot write " + file.string());
}

/// Little-endian bytes of a float, whatever the machine.
void
appendFloat(std::string& bytes, float value)
{
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  for (unsigned shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<char>((bits >> shift) & 0xffU));
}

/// Coordinates are stored in whole millimetres, as scanners give them.
float
toWholeMillimetres(float metres)
{
  return static_cast<float>(std::round(static_cast<double>(metres) * 1000) / 1000);
}

/// Binary PCD with x, y, z as floats.
void
writePcd(const std::filesystem::path& file, const Eigen::Matrix3Xf& points)
{
  std::ofstream out(file, std::ios::binary);
  out << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
      << "WIDTH " << points.cols() << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << points.cols()
      << "\nDATA binary\n";
  std::string bytes;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k)
      appendFloat(bytes, toWholeMillimetres(points(k, i)));
  }
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  requireGood(out, file);
}

/// A number with nine decimals; never "-0".
std::string
formatNumber(double value)
{
  std::ostringstream out;
  out << std::fixed << std::setprecision(9) << (std::abs(value) < 5e-10 ? 0.0 : value);
  return out.str();
}

void
writePairs(const std::filesystem::path& file, const std::vector<ScanRecipe>& scans, const std::vector<Pair>& pairs)
{
  std::ofstream out(file);
  out << "source,target,rot_deg,trans_m";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      out << ",T" << row << column;
  }
  out << '\n';
  for (const Pair& pair : pairs) {
    const Eigen::Isometry3d T_target_source =
        relativePose(scans[pair.target].T_world_sensor, scans[pair.source].T_world_sensor);
    out << scans[pair.source].file << ',' << scans[pair.target].file << std::fixed << std::setprecision(2) << ','
        << Eigen::AngleAxisd(T_target_source.linear()).angle() / kDegree << ',' << T_target_source.translation().norm();
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column)
        out << ',' << formatNumber(T_target_source(row, column));
    }
    out << '\n';
  }
  out.close();
  requireGood(out, file);
}

void
writePoses(const std::filesystem::path& file, const std::vector<ScanRecipe>& scans)
{
  std::ofstream out(file);
  out << "# scan tx ty tz qx qy qz qw (world from scan)\n";
  for (const ScanRecipe& scan : scans) {
    const Eigen::Vector3d t = scan.T_world_sensor.translation();
    const Eigen::Quaterniond q(scan.T_world_sensor.linear());
    out << scan.file;
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
      out << ' ' << formatNumber(value);
    out << '\n';
  }
  out.close();
  requireGood(out, file);
}

void
writeDescription(const std::filesystem::path& file)
{
  std::ofstream out(file);
  out << "{\n"
         "  \"name\": \"synthetic_pairs\",\n"
         "  \"sensor\": \"simulated: see README.md\",\n"
         "  \"viewpoint\": \"sensor\",\n"
         "  \"success\": {\"rotation_deg\": 2, \"translation_m\": 0.3},\n"
         "  \"note\": \"apartment, hall and street with exact ground truth, written by pcl_ssfr_make_data\"\n"
         "}\n";
  out.close();
  requireGood(out, file);
}

std::vector<ScanRecipe>
makeRecipes()
{
  // Angular steps keep each file under 2 MB.
  SensorPattern room = roomScanner(0.65 * kDegree);
  room.drop_rate = 0.02;
  SensorPattern hall = terrestrialScanner(0.6 * kDegree);
  hall.drop_rate = 0.02;
  SensorPattern street = vehicleScanner(64);
  street.drop_rate = 0.05;
  const Scene apartment = makeFurnishedRoom(1);
  const Scene factory = makeHall(2);
  const Scene town = makeStreet(3);
  const auto pose = [](const Scene& scene, std::size_t station, double yaw, double tilt) {
    return sensorPose(scene.stations[station], yaw * kDegree, tilt * kDegree);
  };
  return {
      {"apartment_0.pcd", apartment, pose(apartment, 0, 10, 0), room, 101},
      {"apartment_1.pcd", apartment, pose(apartment, 1, 130, 15), room, 102},
      {"hall_0.pcd", factory, pose(factory, 0, -20, 0), hall, 201},
      {"hall_1.pcd", factory, pose(factory, 1, 75, 3), hall, 202},
      {"street_0.pcd", town, pose(town, 1, 0, 1), street, 301},
      {"street_1.pcd", town, pose(town, 2, 160, -1), street, 302},
  };
}

/// A flat of three rooms as a small job for a map: the frame of each scan is rotated at random.
std::vector<ScanRecipe>
makeBuilding()
{
  // Light scans: 8 of them take less than 1.5 MB.
  SensorPattern sensor = roomScanner(1.95 * kDegree);
  sensor.drop_rate = 0.02;
  const Scene flat = makeFurnishedRoom(7);
  Random random(70);
  std::vector<ScanRecipe> scans;
  for (int i = 0; i < 8; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = flat.stations[static_cast<std::size_t>(i) % flat.stations.size()];
    for (Eigen::Index k = 0; k < 3; ++k)
      pose.translation()[k] += random.uniform(-0.25, 0.25);
    pose.linear() = randomRotation(random);
    scans.push_back({"scan_" + std::to_string(i) + ".pcd", flat, pose, sensor, 700 + static_cast<std::uint64_t>(i)});
  }
  return scans;
}

void
writeBuilding(const std::filesystem::path& folder)
{
  const std::vector<ScanRecipe> scans = makeBuilding();
  std::filesystem::create_directories(folder);
  for (const ScanRecipe& scan : scans) {
    Eigen::Isometry3d upright = Eigen::Isometry3d::Identity();
    upright.translation() = scan.T_world_sensor.translation();
    // The sensor stands upright; its points are given in the rotated frame.
    const Eigen::Matrix3Xd points = castScan(scan.scene, upright, scan.pattern, scan.noise_seed).cast<double>();
    writePcd(folder / scan.file, (scan.T_world_sensor.linear().transpose() * points).cast<float>());
  }
  writePoses(folder / "poses.txt", scans);
}

void
writeAll(const std::filesystem::path& folder)
{
  const std::vector<ScanRecipe> scans = makeRecipes();
  std::filesystem::create_directories(folder);
  for (const ScanRecipe& scan : scans)
    writePcd(folder / scan.file, castScan(scan.scene, scan.T_world_sensor, scan.pattern, scan.noise_seed));
  writePairs(folder / "pairs.csv", scans, {{1, 0}, {3, 2}, {5, 4}});
  writePoses(folder / "poses.txt", scans);
  writeDescription(folder / "dataset.json");
  writeBuilding(folder / "building");
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc != 2) {
    std::cerr << "usage: pcl_ssfr_make_data FOLDER\n";
    return 2;
  }
  try {
    writeAll(argv[1]);
  }
  catch (const std::exception& error) {
    std::cerr << "pcl_ssfr_make_data: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
