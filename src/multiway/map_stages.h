// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/hypothesis_graph.h"

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <optional>
#include <vector>

namespace pcl_ssfr {

/// What a map is made from, besides the links.
struct MapInput {
  const std::vector<PreparedScan>& prepared;
  const std::vector<int>& original; ///< of each scan: the first one with its points
  const std::vector<std::optional<PosePrior>>& priors;
  const Decisions& decisions;
  const MultiwayOptions& options;
};

/** \brief Choose, adjust and describe: all after linking.
 * \param[in,out] map has its scans; the rest is filled in
 * \throw std::invalid_argument when accepted links do not agree
 */
void
makeMap(const MapInput& input,
        const std::vector<PairLink>& links,
        MultiwayMap& map,
        const MultiwayRegistration::Progress& progress);

} // namespace pcl_ssfr
