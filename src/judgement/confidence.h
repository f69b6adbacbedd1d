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
 * A logistic model of the lead over the best rival, what contradictions leave of the score (where they cannot be seen:
 * the share of the patches that matched), and the surface that faces the third direction. Its coefficients were fitted
 * to right and wrong answers on real scan pairs, on simulated ones and on unrelated scans (scripts/fit_confidence).
 * \param[in] lead by how much \p best scores more than any distinct rival, by all patches and by those that face their
 * sensor, whichever is less. More than its own scores counts as these: a rival that contradicts itself away is no more
 * than none (infinity) \param[in] free_space whether contradictions could be
 * seen (both viewpoints believed) \return [0, 1]
 */
double
estimateConfidence(const Candidate& best, double lead, bool free_space);

} // namespace pcl_ssfr
