// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/pairs/result_row.h>

#include <chrono>
#include <cstddef>
#include <string>

namespace pcl_ssfr {
namespace apps {

/// A result in words: "right, converged, 0.012 deg, 0.004 m"; "not accepted, low_overlap, no pose is right".
std::string
describeOutcome(const ResultRow& row);

/// Says how far a run is, on the standard error: one line that moves on a terminal, a line a result in a log.
class Progress {
public:
  /// \param[in] total results to come
  /// \param[in] kept results of an earlier run
  Progress(std::size_t total, std::size_t kept);
  /// A result has come.
  void
  add(const ResultRow& row);
  /// Nothing has: show the time that is left, on a terminal only.
  void
  tick();
  /// The last line ends.
  void
  finish() const;

private:
  void
  show();

  bool terminal_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
};

} // namespace apps
} // namespace pcl_ssfr
