// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>

namespace pcl_ssfr {

/** \brief The moment at which work shall end: never, or some seconds after it was made.
 *
 * A value that is handed down by reference. Work that takes one looks at it between its steps, at least every few
 * milliseconds; what it gives when the moment has come is said where it takes the deadline. It never throws for that.
 */
class Deadline {
public:
  using Clock = std::chrono::steady_clock;

  /// Never.
  Deadline() = default;

  /// \p seconds from now [s]; never when that is 0 (an option of 0 means no limit), negative, NaN or beyond a year.
  static Deadline
  after(double seconds)
  {
    constexpr double kForever = 365.0 * 24 * 3600; // [s] beyond, the clock's count may overflow
    Deadline deadline;
    if (seconds > 0 && seconds < kForever) {
      deadline.is_set_ = true;
      deadline.end_ =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    }
    return deadline;
  }

  /// Whether the moment has come; once true, always true.
  bool
  hasPassed() const
  {
    return is_set_ && Clock::now() >= end_;
  }

private:
  bool is_set_ = false;
  Clock::time_point end_;
};

} // namespace pcl_ssfr
