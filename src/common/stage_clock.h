// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/result.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// Wall clock that reports the time since it was made or last asked.
class StageClock {
public:
  using Clock = std::chrono::steady_clock;

  StageReport
  lap(std::string name, std::uint64_t count_in, std::uint64_t count_out)
  {
    const Clock::time_point now = Clock::now();
    StageReport report;
    report.name = std::move(name);
    report.seconds = std::chrono::duration<double>(now - last_).count();
    report.count_in = count_in;
    report.count_out = count_out;
    last_ = now;
    return report;
  }

  /// Seconds since it was made.
  double
  elapsed() const
  {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

private:
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

/// Reports stages one after the other, each with the time since the one before it.
class StageLog {
public:
  explicit StageLog(std::vector<StageReport>& reports) : reports_(reports) {}

  void
  report(const char* stage, std::uint64_t count_in, std::uint64_t count_out)
  {
    reports_.push_back(clock_.lap(stage, count_in, count_out));
  }

private:
  std::vector<StageReport>& reports_;
  StageClock clock_;
};

} // namespace pcl_ssfr
