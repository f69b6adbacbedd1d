// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// Says how far a map is, on the standard error: one line that moves on a terminal, a line per tenth in a log.
class MapProgress {
public:
  MapProgress();
  ~MapProgress();
  MapProgress(const MapProgress&) = delete;
  MapProgress&
  operator=(const MapProgress&) = delete;

  void
  show(const std::string& stage, std::size_t done, std::size_t total);

private:
  using Clock = std::chrono::steady_clock;

  bool terminal_;
  bool open_ = false; ///< the last line has no end yet
  std::string stage_;
  std::size_t first_ = 0; ///< done when the stage began
  std::size_t tenth_ = 0; ///< of the total, that was shown last
  std::size_t total_ = 0; ///< more is to be done in each round of candidates
  Clock::time_point began_;
  Clock::time_point shown_;
};

} // namespace apps
} // namespace pcl_ssfr
