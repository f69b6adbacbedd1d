// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>

namespace pcl_ssfr {

/** \brief Point in time at which work must stop: never, or some seconds after it was made.
 *
 * Work that takes one checks it between its steps, at least every few milliseconds, and stops without throwing; what is
 * returned then is said there.
 */
class Deadline {
public:
  /// The clock that counts: it never goes backwards.
  using Clock = std::chrono::steady_clock;

  /// A deadline that never passes.
  Deadline() = default;

  /** \brief A deadline some time from now.
   * \param[in] seconds [s]; 0 (an option of 0 means no limit), negative, NaN or beyond a year: it never passes
   */
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

  /// Whether it has passed; once true, always true.
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
