// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <chrono>
#include <ctime>

namespace pcl_ssfr {

/// What a time limit measures.
enum class TimeLimitClock {
  Wall,     ///< time that passes
  Processor ///< processor time of the whole process, all threads: does not depend on what else runs on the machine
};

/** \brief Point in time at which work must stop. One that is default-constructed never passes.
 *
 * A function that takes one checks it between its steps, at least every few milliseconds, and returns early without
 * throwing; its own documentation says what it returns then.
 */
class Deadline {
public:
  /// The clock of TimeLimitClock::Wall: it never goes backwards.
  using Clock = std::chrono::steady_clock;

  /// A deadline that never passes.
  Deadline() = default;

  /** \brief A deadline some time from now.
   * \param[in] seconds [s]; 0 (an option of 0 means no limit), negative, NaN or beyond a century: it never passes
   * \param[in] clock which time is limited
   */
  static Deadline
  after(double seconds, TimeLimitClock clock = TimeLimitClock::Wall)
  {
    const double forever = std::chrono::duration<double>(Clock::duration::max()).count() / 2; // about 146 years
    Deadline deadline;
    if (seconds > 0 && seconds < forever) {
      deadline.counts_ = clock;
      deadline.is_set_ = true;
      deadline.end_ =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
      deadline.processor_end_ = processorTime() + seconds;
    }
    return deadline;
  }

  /// Whether it has passed; once true, always true.
  bool
  hasPassed() const
  {
    if (!is_set_)
      return false;
    return counts_ == TimeLimitClock::Wall ? Clock::now() >= end_ : processorTime() >= processor_end_;
  }

private:
  /// Of the whole process [s].
  static double
  processorTime()
  {
    return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
  }

  bool is_set_ = false;
  TimeLimitClock counts_ = TimeLimitClock::Wall;
  Clock::time_point end_;
  double processor_end_ = 0; ///< of the processor time [s]
};

} // namespace pcl_ssfr
