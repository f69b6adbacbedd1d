// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/merged_cloud.h>

#include <apps/common/format_text.h>
#include <apps/io/io_error.h>
#include <apps/io/loaded_cloud.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_set>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr int kCountWidth = 12; // digits that are kept free for the number of points
constexpr double kGolden = 0.61803398874989485;
constexpr int kBits = 21; // of a voxel's number along an axis

template <typename Value>
void
append(std::string& bytes, Value value)
{
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::uint64_t
voxelOf(const Eigen::Vector3d& p, double leaf)
{
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const auto index = static_cast<std::int64_t>(std::floor(p[i] / leaf));
    key = (key << kBits) | (static_cast<std::uint64_t>(index) & ((std::uint64_t{1} << kBits) - 1));
  }
  return key;
}

} // namespace

Eigen::Matrix<unsigned char, 3, 1>
colourOf(std::size_t number)
{
  const double hue = 6 * std::fmod(0.6 + kGolden * static_cast<double>(number), 1.0);
  Eigen::Matrix<unsigned char, 3, 1> colour;
  for (int i = 0; i < 3; ++i) {
    const double distance = std::abs(std::fmod(hue + 2.0 * i, 6.0) - 3);
    colour[i] = static_cast<unsigned char>(60 + 180 * std::min(1.0, std::max(0.0, distance - 1)));
  }
  return colour;
}

MergedCloud::MergedCloud(const std::string& path, double leaf, bool wide)
    : path_(path), file_(path), leaf_(leaf), wide_(wide), pcd_(io::extensionOf(path) == ".pcd")
{
  file_.write(header());
}

std::string
MergedCloud::header() const
{
  const char* count = "%-*zu";
  const std::string n = format(count, kCountWidth, points_);
  if (pcd_)
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb intensity scan\nSIZE " +
           std::string(wide_ ? "8 8 8" : "4 4 4") + " 4 4 4\nTYPE F F F U F U\nCOUNT 1 1 1 1 1 1\nWIDTH " + n +
           "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA binary\n";
  const std::string type = wide_ ? "double" : "float";
  return "ply\nformat binary_little_endian 1.0\nelement vertex " + n + "\nproperty " + type + " x\nproperty " + type +
         " y\nproperty " + type +
         " z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float intensity\n"
         "property uint scan\nend_header\n";
}

void
MergedCloud::add(const io::LoadedCloud& cloud, const Eigen::Isometry3d& T_map_file, std::size_t number)
{
  const auto xyz = io::findVector(cloud.table, "x", "y", "z");
  if (!xyz)
    throw io::IoError(path_ + ": " + cloud.path + " has no coordinates");
  const pcl::PCLPointField* intensity = cloud.has_intensity ? io::findField(cloud.table, "intensity") : nullptr;
  const Eigen::Matrix<unsigned char, 3, 1> colour = colourOf(number);
  std::unordered_set<std::uint64_t> taken;
  std::string bytes;
  constexpr std::size_t kFlush = std::size_t{1} << 20;
  for (std::size_t i = 0; i < io::pointCount(cloud.table); ++i) {
    const std::uint8_t* point = cloud.table.data.data() + i * cloud.table.point_step;
    const auto value = [point](const pcl::PCLPointField* field) {
      return io::loadValue(point + field->offset, field->datatype);
    };
    const Eigen::Vector3d in_file(value((*xyz)[0]), value((*xyz)[1]), value((*xyz)[2]));
    if (!in_file.allFinite())
      continue;
    const Eigen::Vector3d p = T_map_file * in_file;
    if (leaf_ > 0 && !taken.insert(voxelOf(p, leaf_)).second)
      continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (wide_)
        append(bytes, p[axis]);
      else
        append(bytes, static_cast<float>(p[axis]));
    }
    if (pcd_)
      append(bytes,
             static_cast<std::uint32_t>(colour[0]) << 16 | static_cast<std::uint32_t>(colour[1]) << 8 |
                 static_cast<std::uint32_t>(colour[2]));
    else
      for (int axis = 0; axis < 3; ++axis)
        append(bytes, colour[axis]);
    append(bytes, intensity ? static_cast<float>(value(intensity)) : 0.0F);
    append(bytes, static_cast<std::uint32_t>(number));
    ++points_;
    if (bytes.size() > kFlush) {
      file_.write(bytes);
      bytes.clear();
    }
  }
  file_.write(bytes);
}

std::size_t
MergedCloud::finish()
{
  if (fseeko(file_.stream(), 0, SEEK_SET) != 0)
    file_.fail();
  file_.write(header()); // as long as the one before it
  file_.finish();
  return points_;
}

} // namespace apps
} // namespace pcl_ssfr
