// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/decisions.h"

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>

#include <Eigen/Geometry>

#include <vector>

namespace pcl_ssfr {

/// A pose of a pair, weighed against all other pairs.
struct WeighedHypothesis {
  std::size_t link = 0; ///< in the list of links
  std::size_t rank = 0; ///< among the hypotheses of the link
  double prior = 0;     ///< probability by the pair alone, or as a person decided
  double belief = 0;    ///< by the loops that it is part of as well
};

/// The links of a job, weighed against each other.
struct HypothesisGraph {
  std::vector<WeighedHypothesis> hypotheses; ///< by link, then rank
  std::vector<std::size_t> first;            ///< of each link: its hypotheses are [first[k], first[k + 1])
};

/// Whether two poses of a pair agree: rotations within the bound, and where they put \p place (source frame) as well.
bool
agree(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& place, const ChoiceConfig& config);

/// Whether two poses of a pair are two places, not one that was found inexactly: they do not agree even loosely.
bool
areDistinct(const Eigen::Isometry3d& a,
            const Eigen::Isometry3d& b,
            const Eigen::Vector3d& place,
            const ChoiceConfig& config);

/** \brief How probable each hypothesis is.
 *
 * As their pairs say, and then loops speak: with hypotheses i-c and c-j, a hypothesis i-j either closes the loop or
 * does not, and what the surer ones say counts more. False links that agree with each other by chance do not form
 * loops; places alike do, and are not found out here. How many pairs of the job share nothing does not count: what is
 * probable and wrong is a place that looks alike, of the job or not (FINDINGS, "A pair among many that share nothing").
 *
 * \param[in] links by source, then target, source < target
 * \param[in] places of the sensors, in the scans' frames [m]
 */
HypothesisGraph
weighHypotheses(const std::vector<PairLink>& links,
                const std::vector<Eigen::Vector3d>& places,
                const Decisions& decisions,
                const MultiwayOptions& options);

} // namespace pcl_ssfr
