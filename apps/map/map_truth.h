// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_map.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How far a scan is from the truth, after the frames of its component were laid onto each other.
struct ScanError {
  double rotation_deg = 0;
  double translation_m = 0; ///< of the sensor
  double consistency = 0;   ///< squared error over its covariance and six, 1 in the mean where the covariance is right
  bool wrong = false;       ///< placed, and not where it belongs
};

/// How far the map is from the true poses.
struct MapErrors {
  std::vector<std::optional<ScanError>> scans; ///< none: not placed, or not in the truth
  std::size_t placed = 0;                      ///< scans with an error
  std::size_t wrong = 0;
  std::size_t wrong_coarsely = 0; ///< the same by bounds of 5 degrees and 2 m, as others count
  double median_translation_m = 0, largest_translation_m = 0; ///< of those that are not wrong
  double median_rotation_deg = 0, largest_rotation_deg = 0;
  double graph_median_m = 0; ///< the same of the pose graph alone [m]
  double chain_median_m = 0; ///< and of a chain of links [m]
  double pairs_median_m = 0; ///< of the used links, each by itself [m]
  double consistency = 0;    ///< mean of ScanError::consistency
};

/** \brief Compare a map with true poses.
 *
 * Each component is laid onto the truth by the rigid motion that most of its scans agree with within the bound (so that
 * a part in the wrong place is wrong, not all), then by least squares over these.
 * \param[in] truth pose of each scan, where it is known
 * \param[in] places of the sensors in the scans' frames [m]
 */
MapErrors
compareWithTruth(const MultiwayMap& map,
                 const std::vector<std::optional<Eigen::Isometry3d>>& truth,
                 const std::vector<Eigen::Vector3d>& places,
                 double rotation_bound_deg = 2,
                 double translation_bound_m = 0.3);

} // namespace apps
} // namespace pcl_ssfr
