// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A place that is known in the frame of the site.
struct ControlPoint {
  std::string scan;                               ///< as in the file
  std::string point;                              ///< its name; may be empty: the setup
  std::optional<Eigen::Vector3d> in_scan;         ///< where the scan has it [m]; none: it is the sensor
  Eigen::Vector3d site = Eigen::Vector3d::Zero(); ///< [m]

  /// The scan, with the point where that has a name.
  std::string
  label() const
  {
    return point.empty() ? scan : scan + " " + point;
  }
};

/** \brief Control points: a CSV file with the columns scan, x, y, z [m] and, for points that a scan shows, point (a
 * name) and sx, sy, sz: where the scan has it, in its own coordinates [m]; empty ones are setups.
 * \throw io::IoError for a file that is none, that has a place twice, and where no motion follows from the places: it
 * takes three or more that are not on a line
 */
std::vector<ControlPoint>
readControl(const std::string& path);

/// A map laid onto its control points.
struct ControlFit {
  Eigen::Isometry3d T_site_map = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector3d> residuals; ///< where the map has each point, less where it is in the site [m]
  /// A point that contradicts the others: they agree far better without it. Looked for among four and more.
  std::optional<std::size_t> misfit;
  double misfit_distance = 0; ///< of it from where the others put it [m]
  double others = 0;          ///< root mean square residual of the others among themselves [m]
  Eigen::Isometry3d T_site_map_of_others = Eigen::Isometry3d::Identity();
};

/// The vertical of a map.
struct MapVertical {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ(); ///< unit, map frame
  bool is_signed = false;                        ///< else it may be down
};

/// Places of a map and where they are in the site, N each.
struct ControlledPlaces {
  std::vector<std::string> labels;   ///< ControlPoint::label()
  std::vector<Eigen::Vector3d> map;  ///< [m]
  std::vector<Eigen::Vector3d> site; ///< [m]
  std::vector<double> sigma;         ///< standard deviations of those in the map [m]
};

/** \brief The best rigid motion of places in the map onto those in the site, N each [m].
 * \throw std::invalid_argument for fewer than three places, and for places on a line
 */
ControlFit
fitControl(const std::vector<Eigen::Vector3d>& map, const std::vector<Eigen::Vector3d>& site);

/** \brief What speaks against a fit, for people: a point that contradicts the others; else the largest residual, where
 * it is far more than what map and site are known to, and whether the distances are in another unit; and a vertical of
 * the map that does not go up in the site, by more than \p tolerance [rad].
 * \param[in] fit fitControl() of these places
 * \param[in] vertical none: it is not known
 */
std::vector<std::string>
doubtsOfControl(const ControlledPlaces& places,
                const ControlFit& fit,
                const std::optional<MapVertical>& vertical,
                double tolerance);

} // namespace apps
} // namespace pcl_ssfr
