// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/pose_uncertainty.h"
#include "preparation/planar_patches.h"
#include "refinement/refinement.h"

#include <pcl_ssfr/patch_config.h>

namespace pcl_ssfr {

/// Spacing of the thinned points on the patches of a scan [m]: half of its surface in patches has its points closer
/// together. 0 without patches.
double
spacingOf(const PlanarPatches& patches);

/** \brief The maximum correspondence distance that suits a local refiner which starts from a polished pose [m].
 *
 * Points that belong together lie apart by three things, which are independent: by what the polish left between their
 * planes (Refinement::rms: noise, and what the planes do not follow), by the error of the pose where it moves the
 * surface (the deviations of PoseUncertainty::motions; motions that nothing determines are left out: no refiner mends
 * them), and within the plane by half the diagonal of the square that each point stands for. Of the first two it covers
 * UncertaintyConfig::bound_deviations.
 * \param[in] spacing of the sparser scan [m], >= 0
 * \param[in] most bound on the error of the pose [m], > 0: as far as the polish itself looked for matches
 * \return 0 when the polish had no match
 */
double
correspondenceDistance(const Refinement& polish,
                       const PoseUncertainty& uncertainty,
                       double spacing,
                       double most,
                       const UncertaintyConfig& config = {});

} // namespace pcl_ssfr
