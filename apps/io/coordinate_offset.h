// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <functional>

namespace pcl_ssfr {
namespace io {

/** \brief What is taken off coordinates in double before they become floats, which lose millimetres beyond
 * \ref kLargeCoordinate.
 * \param[in] count number of points
 * \param[in] point the i-th of them [m]; called for about a thousand, which may be not finite
 * \return the median of these in whole metres when it is far from the origin, else zero: stray points do not matter
 */
Eigen::Vector3d
chooseOffset(std::size_t count, const std::function<Eigen::Vector3d(std::size_t)>& point);

/** \brief Step of coordinates that are no finer than floats of 4 bytes: as files of such have them, whatever they were
 * converted to since.
 * \param[in] count, point as above
 * \param[in] offset of chooseOffset()
 * \return at the largest of the offsets [m]; 0 where coordinates along that axis are finer, without an offset, and of
 * fewer points than a scan has
 */
double
floatStep(std::size_t count, const std::function<Eigen::Vector3d(std::size_t)>& point, const Eigen::Vector3d& offset);

} // namespace io
} // namespace pcl_ssfr
