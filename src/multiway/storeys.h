// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/prepared_scan.h>

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace pcl_ssfr {

/// A scan of a part of the map, as the test for storeys alike needs it.
struct StoreyScan {
  const OrientedSamples* surface = nullptr;                        ///< patches with normals towards the sensor
  Eigen::Isometry3d T_map_surface = Eigen::Isometry3d::Identity(); ///< of the frame of the patches
  Eigen::Vector3d place = Eigen::Vector3d::Zero();                 ///< of the sensor in the map [m]
};

/// \param[in] scan which outlives it, of patches
StoreyScan
storeyScan(const PreparedScan& scan, const Eigen::Isometry3d& T_map_scan);

/// Why a part may be several storeys laid onto one another.
struct StoreyDoubt {
  std::vector<std::size_t> level; ///< scans of the storey that may be several
  std::vector<std::size_t> above; ///< scans on the way up from it
  std::vector<std::size_t> below; ///< and on the way down
};

/** \brief The vertical of a part of a building, of either sign: the axis of sensors that look around but not all the
 * way up and down, made exact by level surfaces, or the direction in which floors lie equally far from most sensors.
 * None: there is no such direction, as with sensors carried by hand.
 */
std::optional<Eigen::Vector3d>
findUp(const std::vector<StoreyScan>& scans, const AliasConfig& config);
/// The one that is given, up in the frames of the scans, where there is one; else the same.
std::optional<Eigen::Vector3d>
findUp(const std::vector<StoreyScan>& scans, const std::optional<Eigen::Vector3d>& gravity, const AliasConfig& config);

/** \brief Whether a storey of a part may be two or more that look alike.
 *
 * Storeys that are alike in all that was seen can be laid onto one another without any contradiction: links between
 * them agree in every loop. What gives it away is the way between them, if it was scanned: in such a map stairs lead up
 * to nowhere, and others lead down to nowhere, or scans that belong to the way stand apart. That is so as well where a
 * single storey was scanned and a few steps of both stairs: the scans do not tell, and neither is assumed.
 * A scan at another height whose floor is that of the level does not stand between levels. A level has scans at several
 * places: of stairs laid onto one another those of each landing are at one.
 * \param[in] scans of the part
 * \param[in] others whether usable scans of the job are not placed in it
 * \param[in] same_place distance of two sensors that are at one place [m]
 */
std::optional<StoreyDoubt>
findStoreyDoubt(const std::vector<StoreyScan>& scans,
                const Eigen::Vector3d& up,
                bool others,
                double same_place,
                const AliasConfig& config);

/** \brief The scans that are not to be trusted where a storey may be several: those of the storey; of the ways up and
 * down the fewer, as both may be one, or both where they are as many; and those of a way that stand where another one
 * of it does.
 *
 * \param[in] scans of the part
 * \param[in] same_place distance of two sensors that are at one place [m]
 * \return ascending
 */
std::vector<std::size_t>
scansInDoubt(const std::vector<StoreyScan>& scans, const StoreyDoubt& doubt, double same_place);

} // namespace pcl_ssfr
