// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/common/point_tests.h>
#include <pcl/point_cloud.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What is taken away from a scan, to make it harder than it was recorded.
struct Degradation {
  std::size_t every = 1;   ///< keep every k-th point, at least 1
  double sector_deg = 360; ///< keep a sector of this width about z through the sensor, at a random place, [0, 360]
  double nearest = 1;      ///< keep this share of the points, those nearest to the sensor, [0, 1]

  bool
  keepsAll() const
  {
    return every == 1 && sector_deg >= 360 && nearest >= 1;
  }
};

/** \brief Indices of the points that are left, ascending: of the sector, the nearest; of these, every k-th.
 * \param[in] points about the sensor, 3 x N, all finite [m]
 * \param[in] seed of the place of the sector
 * \throw std::invalid_argument naming the value that is out of range
 */
std::vector<std::size_t>
remainingPoints(const Eigen::Matrix3Xf& points, const Degradation& degradation, std::uint64_t seed);

/// The finite points of a scan that are left, in its order; \p sensor in its frame [m]. See remainingPoints().
template <typename Point>
typename pcl::PointCloud<Point>::Ptr
degraded(const pcl::PointCloud<Point>& scan,
         const Degradation& degradation,
         std::uint64_t seed,
         const Eigen::Vector3f& sensor = Eigen::Vector3f::Zero())
{
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (pcl::isXYZFinite(scan[i]))
      finite.push_back(i);
  Eigen::Matrix3Xf points(3, static_cast<Eigen::Index>(finite.size()));
  for (std::size_t k = 0; k < finite.size(); ++k)
    points.col(static_cast<Eigen::Index>(k)) = scan[finite[k]].getVector3fMap() - sensor;
  auto out = pcl::make_shared<pcl::PointCloud<Point>>();
  for (const std::size_t k : remainingPoints(points, degradation, seed))
    out->push_back(scan[finite[k]]);
  return out;
}

} // namespace apps
} // namespace pcl_ssfr
