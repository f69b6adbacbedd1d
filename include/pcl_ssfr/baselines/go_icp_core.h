// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/scan_view.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ssfr::baselines {

/** \brief Parameters of Go-ICP. Both clouds are shifted by their centroids and scaled together into [-1, 1]^3; what is
 * called normalised refers to that, 1 being GoIcpReport::scale.
 */
struct GoIcpOptions {
  int source_points = 1000;       ///< the source is thinned to at most so many points, 3 or more
  double trim_fraction = 0;       ///< share of the source points, the worst ones, left out of the error, [0, 1)
  double mse_threshold = 1e-3;    ///< tolerance of the mean squared error, normalised, > 0
  double translation_range = 0.5; ///< half the edge of the cube of translations searched, normalised, > 0
  int transform_size = 300;       ///< voxels of the distance transform along the target's longest side, 2 to 512
  int icp_iterations = 0;         ///< bound on the steps of each local ICP, >= 0; 0: 100
  std::uint64_t node_limit = 100'000'000; ///< stop after about so many cubes of both searches; 0: no limit
  double inlier_distance = 0;             ///< what counts as overlap [m], >= 0; 0: from the data. No part of the error
  double time_limit = 0;                  ///< stop so long after the start [s]; 0: no limit. With one, runs may differ
  TimeLimitClock time_limit_clock = TimeLimitClock::Wall; ///< what time_limit counts
  unsigned threads = 1;                                   ///< >= 1; the result does not depend on it
};

/// What the search did and how sure it is.
struct GoIcpReport {
  bool certified = false;       ///< no pose searched has a mean squared error lower by more than \ref tolerance
  double error = 0;             ///< mean squared distance of the source points kept, to the target [m^2]
  double gap = 0;               ///< the optimum is proven to be no lower than error - gap [m^2]
  double tolerance = 0;         ///< the gap at which the search stops: mse_threshold scale^2 [m^2]
  double scale = 0;             ///< length of 1 in normalised coordinates [m]
  std::size_t kept = 0;         ///< source points that count in the error, the others are trimmed
  std::uint64_t nodes = 0;      ///< cubes of rotations and of translations evaluated
  std::uint64_t rotations = 0;  ///< of them, cubes of rotations
  int icp_runs = 0;             ///< local searches
  double seconds = 0;           ///< in all
  double transform_seconds = 0; ///< of them, for the distance transform
};

/** \brief Globally optimal ICP: the rigid motion with the least (trimmed) mean squared distance from the thinned source
 * to the target, by nested branch and bound (Yang, Li, Campbell, Jia, "Go-ICP: A Globally Optimal Solution to 3D ICP
 * Point-Set Registration", PAMI 2016).
 *
 * \param[in] source,target borrowed points; non-finite ones are skipped
 * \param[in] options see there
 * \param[in] guess one more start of the local ICP
 * \param[out] report what was done; null: not wanted
 * \return converged only when certified; else the message says what stopped the search and how large the gap is. The
 * search has no answer for fewer than 3 finite points, or points on a line
 * \throw std::invalid_argument for an option out of its range, "name = value, must ..."
 */
PCL_SSFR_EXPORT BaselineResult
registerGoIcp(const ScanView& source,
              const ScanView& target,
              const GoIcpOptions& options,
              const std::optional<Eigen::Isometry3d>& guess = std::nullopt,
              GoIcpReport* report = nullptr);

} // namespace pcl_ssfr::baselines
