// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/result.h>

namespace pcl_ssfr {

/** \brief Score of the best distinct rival, as a share of the winner's, from which on an answer is called ambiguous.
 * Without free space (a viewpoint unknown) scores tell less, and a smaller share will do.
 */
double
ambiguousRatio(bool free_space);

/** \brief Estimated probability that a pose of the default profile is right, from the evidence for it.
 *
 * A logistic model of the share of the patches that matched, the lead over the best rival, what contradictions leave of
 * the score, and the surface that faces the third direction. Its coefficients were fitted to right and wrong answers on
 * real scan pairs, on simulated ones and on unrelated scans (scripts/fit_confidence). \param[in] rival_ratio score of
 * the best distinct rival over that of this pose, <= 1 \param[in] free_space whether contradictions could be seen (both
 * viewpoints believed) \return [0, 1]
 */
double
estimateConfidence(const Candidate& best, double rival_ratio, bool free_space);

} // namespace pcl_ssfr
