// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "preparation/patch_index.h"

#include <Eigen/Core>

#include <vector>

namespace pcl_ssfr {

/** \brief The samples that are in none of the three planes that determine a pose.
 *
 * A pose has as many degrees of freedom as it takes to lay three planes on three others, so that these match says
 * little: any corner fits any corner. The planes are those of the largest sample, of the one with most surface across
 * the first, and of the one with most surface across both.
 * \param[in] chosen indices of samples, such as those that match
 * \param[in] tolerance a sample lies in the plane of another one when it is within its distance from it and their
 * normals within its angle, whatever their signs
 * \return those of \p chosen that are left, in their order
 */
std::vector<Eigen::Index>
beyondThreePlanes(const OrientedSamples& samples,
                  std::vector<Eigen::Index> chosen,
                  const PatchIndex::Tolerance& tolerance);

} // namespace pcl_ssfr
