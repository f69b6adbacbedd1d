// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "profiles/paper_profile.h"
#include "profiles/patch_profile.h"

#include <pcl_ssfr/prepared_scan.h>

#include <variant>

namespace pcl_ssfr {

/// What the stages need of one scan: of Profile::Default or of Profile::Paper2017.
struct PreparedData {
  Options options; ///< that it was prepared with
  std::variant<PatchScan, PaperScan> scan;
};

/// The scan as the default profile prepared it. \throw std::bad_variant_access when another one did
inline const PatchScan&
patchesOf(const PreparedScan& scan)
{
  return std::get<PatchScan>(scan.data().scan);
}

} // namespace pcl_ssfr
