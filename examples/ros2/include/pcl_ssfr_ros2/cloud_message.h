// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr_ros2 {

/// One field of the points, as sensor_msgs/PointField has it.
struct PointField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes from the start of a point
  std::uint8_t datatype = 0; ///< as numbered there: 7 is float32, 8 is float64
  std::uint32_t count = 1;
};

constexpr std::uint8_t kFloat32 = 7;
constexpr std::uint8_t kFloat64 = 8;

/// The bytes of a sensor_msgs/PointCloud2, borrowed from the message.
struct CloudMessage {
  std::uint32_t height = 1;
  std::uint32_t width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0; ///< bytes from a point to the next
  std::uint32_t row_step = 0;   ///< bytes from a row to the next
  const std::uint8_t* data = nullptr;
  std::size_t size = 0; ///< bytes behind \ref data
};

/** \brief The points of a message that a scanner measured.
 *
 * x, y and z may be float32 or float64, at any offsets and in either byte order, and rows may be padded; other fields
 * are skipped. Left out are points that are not finite or nearer to the origin than \p least_range: drivers put lost
 * returns there.
 * \param[in] message borrowed until this returns
 * \param[in] least_range [m], >= 0
 * \throw std::invalid_argument naming the field, what is wrong with it and its value
 */
pcl::PointCloud<pcl::PointXYZ>::Ptr
readCloud(const CloudMessage& message, double least_range);

} // namespace pcl_ssfr_ros2
