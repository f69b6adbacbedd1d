// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Writes small good files for each reader, for scripts/fuzz to begin with: fuzz_seeds DIR makes DIR/las/a.las, ...

#include <e57_files.h>
#include <las_files.h>

#include <apps/io/e57_writer.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace {

using namespace pcl_ssfr;
using namespace pcl_ssfr::testing;

class Seeds {
public:
  explicit Seeds(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void
  add(const std::string& reader, const std::string& content)
  {
    io::writeFile(next(reader), content);
  }
  std::string
  next(const std::string& reader)
  {
    std::filesystem::create_directories(folder_ / reader);
    return (folder_ / reader / ("seed" + std::to_string(count_++) + '.' + reader)).string();
  }

private:
  std::filesystem::path folder_;
  int count_ = 0;
};

void
addE57(Seeds& seeds)
{
  const std::vector<std::uint64_t> bits{1, 0, 1, 1, 0, 1, 1, 0};
  E57Made all;
  all.head = "<name>a</name><pose><rotation><w>1</w><x>.1</x></rotation><translation><x>3</x></translation></pose>"
             "<colorLimits><colorRedMaximum>9</colorRedMaximum></colorLimits>";
  all.columns = {singleColumn("cartesianX", {1, 2, 3, 4, 5, 6, 7, 8}),
                 integerColumn("cartesianY", "minimum=\"-9\" maximum=\"900\" scale=\"0.1\" offset=\"1\"", 10, bits),
                 doubleColumn("cartesianZ", {1, 2, 3, 4, 5, 6, 7, 8}),
                 integerColumn("cartesianInvalidState", "minimum=\"0\" maximum=\"1\"", 1, bits),
                 integerColumn("intensity", "minimum=\"5\" maximum=\"5\"", 0, bits),
                 integerColumn("rowIndex", "", 64, bits)};
  for (const char* color : {"colorRed", "colorGreen", "colorBlue"})
    all.columns.push_back(integerColumn(color, "minimum=\"0\" maximum=\"65535\"", 16, bits));
  all.columns.push_back({"text type=\"String\"", 0, {}, std::string("\4ab\0\0\0", 6)});
  E57Made sphere;
  sphere.columns = {doubleColumn("sphericalRange", {1, 2}),
                    doubleColumn("sphericalElevation", {0, 1}),
                    doubleColumn("sphericalAzimuth", {0, 3})};
  seeds.add("e57", makeE57({all}, 64));
  all.other_packets = true;
  all.piece = [](std::size_t k, std::size_t packet) { return k + packet; };
  seeds.add("e57", makeE57({all, sphere}));
  seeds.add("e57", makeE57({sphere, all}, 128));
}

/// The first points of a real scan in each format.
void
addReal(Seeds& seeds, const std::string& path)
{
  constexpr std::size_t kPoints = 50;
  io::LoadedCloud cloud = io::loadCloud(path);
  const auto bytes = cloud.table.data;
  io::resizeTable(cloud.table, std::min(kPoints, io::pointCount(cloud.table)));
  std::copy_n(bytes.begin(), cloud.table.data.size(), cloud.table.data.begin());
  for (const char* format : {"pcd", "ply", "e57"})
    io::saveMovedCloud(seeds.next(format), cloud, Eigen::Isometry3d::Identity());
  std::string lines, scan, floats;
  for (std::size_t i = 0; i < kPoints && i < cloud.points->size(); ++i) {
    const auto& p = (*cloud.points)[i];
    lines += std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n';
    scan += std::to_string(p.x * 100) + ' ' + std::to_string(p.y * 100) + ' ' + std::to_string(p.z * 100) + '\n';
    floats += bytesOf(p.x) + bytesOf(p.y) + bytesOf(p.z) + bytesOf(0.5F);
  }
  seeds.add("csv", "x y z\n" + lines);
  seeds.add("pts", std::to_string(kPoints) + '\n' + lines);
  seeds.add("ptx",
            std::to_string(kPoints) + "\n1\n1 2 3\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n" + lines);
  seeds.add("3d", scan);
  seeds.add("bin", floats);
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds DIR\n";
    return 2;
  }
  try {
    Seeds seeds(argv[1]);
    addE57(seeds);
    for (const char* scan : {"apartment_0.pcd", "street_0.pcd"})
      addReal(seeds, std::string(PCL_SSFR_DATA_DIR) + '/' + scan);
    for (unsigned format = 0; format < 11; ++format) {
      const std::uint16_t bytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
      seeds.add("las", makeLas(format < 6 ? 2 : 4, format, bytes[format], 3, format % 2 == 0 ? 0 : 5e6));
    }
    std::string floats;
    for (int i = 0; i < 12; ++i)
      floats += bytesOf(static_cast<float>(i));
    seeds.add("bin", floats);
    const std::string pcd = "VERSION 0.7\nFIELDS x y z _ ring\nSIZE 4 4 4 1 2\nTYPE F F F U U\nCOUNT 1 1 1 3 1\n"
                            "WIDTH 2\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 2\nDATA ";
    seeds.add("pcd", pcd + "ascii\n1 2 3 0 0 0 4\nnan 2 3 0 0 0 5\n");
    seeds.add("pcd", pcd + "binary\n" + floats.substr(0, 34));
    // LZF: literals of 32 and 2 bytes.
    seeds.add("pcd",
              pcd + "binary_compressed\n" + bytesOf(36U) + bytesOf(34U) + '\37' + floats.substr(0, 32) + '\1' +
                  floats.substr(0, 2));
    const std::string ply = " 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty double z\nproperty "
                            "uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    seeds.add("ply", "ply\nformat ascii" + ply + "1 2 3 4\n5 6 7 8\n3 0 1 1\n");
    std::string vertices;
    for (int i = 0; i < 2; ++i)
      vertices += floats.substr(0, 8) + bytesOf(1.0) + '\7';
    seeds.add("ply", "ply\nformat binary_little_endian" + ply + vertices + '\1' + bytesOf(1));
    seeds.add("csv", "timestamp, x, y, z, intensity\n1e9, 1, 2, 3, 0.5\n2e9,4,5,6,7\n");
    seeds.add("csv", "# x y z nx ny nz\n1;2;3;0;0;1\n");
    seeds.add("pts", "2\n1 2 3 -500 1 2 3\n4 5 6 7 255 0 0\n");
    seeds.add("ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n1 2 3 0.5\n0 0 0 0\n");
    seeds.add("3d", "1 2 3\n4 5 6 7\n");
  }
  catch (const std::exception& error) {
    std::cerr << "fuzz_seeds: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
