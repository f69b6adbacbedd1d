// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>
#include <pcl_ssfr/search_trace.h>

#include <apps/pairs/measures.h>
#include <apps/pairs/pair_input.h>

#include <Eigen/Geometry>

#include <string>

namespace pcl_ssfr {
namespace apps {

/// What it takes to say where a search lost the true pose; all poses in the frames of the same clouds.
struct LostSearch {
  Result result;     ///< of the search
  SearchTrace trace; ///< of the same search
  Result from_truth; ///< of a search that was given the true pose as a guess
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(); ///< of the source, see poseError() [m]
  SuccessBound bound{2, 0.3};
};

/** \brief The first stage after which the true pose was lost:
 *
 * - `preparation`: nothing was searched, since a scan holds too few points or directions
 * - `evidence`: another pose is the most probable one, though a right one was found, or the truth was given as a guess:
 *   whatever is proposed, the evidence is for another place
 * - `rotation`: no rotation within 5 degrees of the true one was searched
 * - `translation`: no pose within 5 degrees and 1 m, which is what refinements come home from, was proposed
 * - `not refined`: such a pose was proposed, but the posterior had decided before its turn
 * - `refinement`: such a pose was refined, and went elsewhere
 *
 * \return empty: the answer is right
 */
std::string
lostStage(const LostSearch& search);

/** \brief Search a pair again, with a trace and from the truth.
 * \param[in] options of Profile::Default
 * \return as above; empty where no pose is right, or none is known. \throw std::invalid_argument for other options
 */
std::string
findLostStage(const PairInput& pair, const Options& options, const SuccessBound& bound);

} // namespace apps
} // namespace pcl_ssfr
