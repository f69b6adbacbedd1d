// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr_ros2/cloud_message.h>

#include <pcl/memory.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace pcl_ssfr_ros2 {

namespace {

bool
isHostBigEndian()
{
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

template <typename Number>
double
numberAt(const std::uint8_t* bytes, bool swapped)
{
  std::array<std::uint8_t, sizeof(Number)> raw{};
  std::copy_n(bytes, raw.size(), raw.begin());
  if (swapped)
    std::reverse(raw.begin(), raw.end());
  Number value = 0;
  std::memcpy(&value, raw.data(), raw.size());
  return static_cast<double>(value);
}

std::size_t
bytesOf(std::uint8_t datatype)
{
  return datatype == kFloat64 ? sizeof(double) : sizeof(float);
}

[[noreturn]] void
fail(const std::string& message)
{
  throw std::invalid_argument("point cloud: " + message);
}

const PointField&
findField(const CloudMessage& message, const std::string& name)
{
  const auto found = std::find_if(
      message.fields.begin(), message.fields.end(), [&](const PointField& field) { return field.name == name; });
  if (found == message.fields.end())
    fail("has no field " + name);
  if (found->datatype != kFloat32 && found->datatype != kFloat64)
    fail("field " + name + " has datatype " + std::to_string(found->datatype) + ", not 7 (float32) or 8 (float64)");
  if (std::uint64_t(found->offset) + bytesOf(found->datatype) > message.point_step)
    fail("field " + name + " at offset " + std::to_string(found->offset) + " does not fit into point_step " +
         std::to_string(message.point_step));
  return *found;
}

/// Rows and their bytes; all products fit into 64 bits.
void
checkSizes(const CloudMessage& message)
{
  const std::uint64_t row = std::uint64_t(message.width) * message.point_step;
  if (message.height > 1 && message.row_step < row)
    fail("row_step " + std::to_string(message.row_step) + " is less than width times point_step, " +
         std::to_string(row));
  const std::uint64_t needed =
      message.height == 0 || message.width == 0 ? 0 : std::uint64_t(message.height - 1) * message.row_step + row;
  if (needed > message.size)
    fail("data has " + std::to_string(message.size) + " bytes, " + std::to_string(needed) + " are needed");
}

} // namespace

pcl::PointCloud<pcl::PointXYZ>::Ptr
readCloud(const CloudMessage& message, double least_range)
{
  if (!(least_range >= 0))
    fail("least_range = " + std::to_string(least_range) + ", must be at least 0");
  const std::array<const PointField*, 3> fields = {
      &findField(message, "x"), &findField(message, "y"), &findField(message, "z")};
  checkSizes(message);
  const bool swapped = message.is_bigendian != isHostBigEndian();
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  if (message.width == 0)
    return cloud;
  cloud->reserve(std::size_t(message.height) * message.width);
  for (std::uint32_t row = 0; row < message.height; ++row)
    for (std::uint32_t column = 0; column < message.width; ++column) {
      const std::uint8_t* point =
          message.data + std::size_t(row) * message.row_step + std::size_t(column) * message.point_step;
      Eigen::Vector3d xyz;
      for (int k = 0; k < 3; ++k) {
        const PointField& field = *fields[static_cast<std::size_t>(k)];
        xyz[k] = field.datatype == kFloat64 ? numberAt<double>(point + field.offset, swapped)
                                            : numberAt<float>(point + field.offset, swapped);
      }
      if (!xyz.allFinite() || xyz.squaredNorm() == 0 || xyz.norm() < least_range)
        continue;
      pcl::PointXYZ kept;
      kept.getVector3fMap() = xyz.cast<float>();
      cloud->push_back(kept);
    }
  return cloud;
}

} // namespace pcl_ssfr_ros2
