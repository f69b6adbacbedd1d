// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>
#include <cstddef>
#include <iosfwd>
#include <string>

namespace pcl_ssfr::simulation {

/// Shows how far the work is: a bar on a terminal, else a line every few seconds.
class Progress {
public:
  enum class Style { Silent, Lines, Bar };

  /// \param[out] stream outlives the object
  Progress(std::ostream& stream, Style style);
  /// The style for the standard error of this process.
  static Style
  styleFor(bool quiet);
  /// Share \p share of item number \p item (from 0) of \p items is done.
  void
  update(std::size_t item, std::size_t items, double share);
  /// Remove the bar.
  void
  finish();

private:
  using Clock = std::chrono::steady_clock;

  std::ostream& stream_;
  Style style_;
  Clock::time_point start_;
  Clock::time_point shown_;
  std::size_t width_ = 0; ///< of the bar on the screen
};

/// The bar: scans done, share, and the time that is left when it can be estimated [s].
std::string
formatProgress(std::size_t item, std::size_t items, double share, double elapsed);

} // namespace pcl_ssfr::simulation
