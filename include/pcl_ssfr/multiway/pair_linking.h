// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Linking pairs elsewhere: in other processes, on other machines. See MultiwayRegistration::setLinker().

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/prepared_scan.h>
#include <pcl_ssfr/scan_view.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// What is known of the pose of a pair beforehand.
struct PairGuess {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< maps source points into the target's frame
  GuessTolerance tolerance;                                          ///< it is right within this
};

/// A pair of scans that is to be linked.
struct PairTask {
  int source = 0;                 ///< number of a scan, less than target
  int target = 0;                 ///< number of the other scan
  std::uint64_t source_hash = 0;  ///< hashOfScan() of the source: other points would give another link
  std::uint64_t target_hash = 0;  ///< the same of the target
  std::optional<PairGuess> guess; ///< from the priors of both poses
};

/// Takes a link that was found.
using OnLink = std::function<void(const PairLink& link)>;

/** \brief Links pairs by any means: calls \p on_link once for each task, in any order, from any thread.
 *
 * Each link must be what linkPair() gives: then the map has the same bits, whoever linked. It may be called several
 * times for one map. What it throws, or \p on_link throws through it, ends MultiwayRegistration::run(); links until
 * then are in the project.
 */
using PairLinker = std::function<void(const std::vector<PairTask>& tasks, const OnLink& on_link)>;

/** \brief Link one pair in this thread, as MultiwayRegistration::run() does. Same scans, same bits.
 * \param[in] task which scans these are, and what is known of their pose beforehand
 * \param[in] source,target not empty(): prepareScan() of the points of the task with MultiwayOptions::registration
 * \param[in] options those of the registration that the link is for; threads are not read
 */
PCL_SSFR_EXPORT PairLink
linkPair(const PairTask& task, const PreparedScan& source, const PreparedScan& target, const MultiwayOptions& options);

/// A number that differs where points differ.
PCL_SSFR_EXPORT std::uint64_t
hashOfPoints(const ScanView& scan);

/// A number that differs where points, given normals or the viewpoint differ, as in MapScan::hash.
PCL_SSFR_EXPORT std::uint64_t
hashOfScan(const ScanView& scan);
/// The same where hashOfPoints() is known.
PCL_SSFR_EXPORT std::uint64_t
hashOfScan(const ScanView& scan, std::uint64_t points);

/// Tasks as bytes, for a message between processes of one build on machines of one kind.
PCL_SSFR_EXPORT std::string
toBytes(const std::vector<PairTask>& tasks);
/// The tasks again, bit for bit. \throw std::runtime_error when these are not the bytes of tasks, or not all of them
PCL_SSFR_EXPORT std::vector<PairTask>
tasksFromBytes(const std::string& bytes);
/// Links as bytes.
PCL_SSFR_EXPORT std::string
toBytes(const std::vector<PairLink>& links);
/// The links again, bit for bit. \throw std::runtime_error when these are not the bytes of links, or not all of them
PCL_SSFR_EXPORT std::vector<PairLink>
linksFromBytes(const std::string& bytes);

} // namespace pcl_ssfr
