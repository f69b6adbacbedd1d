// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/dataset_simulation.h>

#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// One of the data sets of Sanchez et al. 2017, as it is simulated.
struct PaperSet {
  std::string description; ///< one line, for the list
  DatasetPlan plan;
};

/// basic_model, ds1h, ds2l, ds3v, ds4s.
std::vector<std::string>
paperSetNames();

/** \brief The plan of one of the paper's sets: its scans, points a scan and size of motion (docs/METHOD.md), pairs of
 * consecutive scans; basic_model has no noise and three motions of growing size onto one target.
 * \param[in] reduced three scans (basic_model: all four) of less than 2 MB each
 * \throw SimulationError naming an unknown set
 */
PaperSet
makePaperSet(const std::string& name, bool reduced);

} // namespace pcl_ssfr::simulation
