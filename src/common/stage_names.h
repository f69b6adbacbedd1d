// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

namespace pcl_ssfr {

// Names of stages (StageReport::name) that reports are searched for.

constexpr const char* kThinningStage = "thinning";         ///< of a scan; "source thinning" in a result
constexpr const char* kPaperNormalsStage = "normals";      ///< of a scan, paper profile; "source_normals" in a result
constexpr const char* kTranslationsStage = "translations"; ///< one of each pass of the search

} // namespace pcl_ssfr
