// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "go_icp_problem.h"

#include <pcl_ssfr/deadline.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace pcl_ssfr::baselines {

/// When to stop branching and bounding.
struct GoIcpLimits {
  double tolerance = 0;         ///< of the error, a sum like GoIcpProblem::error(), > 0
  double translation_range = 0; ///< half the edge of the cube of translations, > 0
  int icp_iterations = 100;     ///< > 0
  std::uint64_t nodes = 0;      ///< cubes to evaluate, about; 0: no limit
  Deadline deadline;
};

/// What the branch and bound found.
struct GoIcpOptimum {
  enum class Stop { Certified, NodeLimit, TimeLimit };

  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double error = 0; ///< of \ref T
  double lower = 0; ///< no pose of the domain has a lower error
  Stop stop = Stop::Certified;
  std::uint64_t nodes = 0;     ///< cubes of both kinds
  std::uint64_t rotations = 0; ///< cubes of rotations
  int icp_runs = 0;
};

/** \brief Algorithm 1 of the paper: all rotations, and translations up to the range along each axis.
 *
 * \param[in] starts poses that the local ICP starts from before the search, besides the identity; they and what ICP
 * makes of them may lie outside the domain
 */
GoIcpOptimum
branchAndBound(const GoIcpProblem& problem,
               const std::vector<Eigen::Isometry3d>& starts,
               const GoIcpLimits& limits,
               unsigned threads);

} // namespace pcl_ssfr::baselines
