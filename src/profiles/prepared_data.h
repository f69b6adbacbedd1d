// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "profiles/paper_profile.h"
#include "profiles/patch_profile.h"

#include <pcl_ssfr/prepared_scan.h>

namespace pcl_ssfr {

/// What the stages need of one scan, by profile.
struct PreparedData {
  Profile profile = Profile::Default;
  PatchScan patches; ///< Profile::Default
  PaperScan paper;   ///< Profile::Paper2017
};

} // namespace pcl_ssfr
