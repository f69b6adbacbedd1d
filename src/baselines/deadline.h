// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/time_limit_clock.h>

#include <chrono>
#include <ctime>

namespace pcl_ssfr::baselines {

/// The moment at which a method stops by itself.
class Deadline {
public:
  /// Never.
  Deadline() = default;
  /// So long from now [s]; 0 or infinite: never.
  Deadline(double seconds, TimeLimitClock clock) : seconds_(seconds), clock_(clock) {}

  bool
  isPast() const
  {
    return seconds_ > 0 && spent() >= seconds_;
  }

private:
  double
  spent() const
  {
    if (clock_ == TimeLimitClock::Processor)
      return static_cast<double>(std::clock() - processor_start_) / CLOCKS_PER_SEC;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
  }

  double seconds_ = 0;
  TimeLimitClock clock_ = TimeLimitClock::Wall;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  std::clock_t processor_start_ = std::clock();
};

} // namespace pcl_ssfr::baselines
