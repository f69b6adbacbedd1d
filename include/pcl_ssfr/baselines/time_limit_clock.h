// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

namespace pcl_ssfr::baselines {

/// What the time limit of a method counts.
enum class TimeLimitClock {
  Wall,      ///< time that passes
  Processor, ///< processor time of the whole process, all threads: does not depend on what else runs on the machine
};

} // namespace pcl_ssfr::baselines
