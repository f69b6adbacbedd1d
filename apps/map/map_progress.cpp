// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_progress.h>

#include <apps/common/format_text.h>

#include <unistd.h>

#include <iostream>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kEvery = 0.2; // [s] between two lines on a terminal
constexpr std::size_t kTenths = 10;

} // namespace

MapProgress::MapProgress() : terminal_(isatty(STDERR_FILENO) != 0), began_(Clock::now()), shown_(began_)
{}

MapProgress::~MapProgress()
{
  if (open_)
    std::cerr << '\n';
}

void
MapProgress::show(const std::string& stage, std::size_t done, std::size_t total)
{
  const Clock::time_point now = Clock::now();
  const std::size_t tenth = total > 0 ? kTenths * done / total : kTenths;
  if (stage != stage_) {
    if (open_)
      std::cerr << '\n';
    open_ = false;
    stage_ = stage;
    first_ = done;
    total_ = total;
    tenth_ = tenth;
    began_ = shown_ = now;
  }
  if (total != total_) {
    total_ = total;
    tenth_ = tenth;
  }
  const bool is_due = terminal_ ? std::chrono::duration<double>(now - shown_).count() > kEvery || done == total
                                : tenth > tenth_ && done > first_;
  if (!is_due)
    return;
  tenth_ = tenth;
  shown_ = now;
  const double seconds = std::chrono::duration<double>(now - began_).count();
  std::string line = format("ssfr_map: %s %zu of %zu", stage.c_str(), done, total);
  if (done > first_ && seconds > 0) {
    const double rate = static_cast<double>(done - first_) / seconds;
    line += format(", %.1f a second", rate);
    if (done < total)
      line += format(", %.0f s left", static_cast<double>(total - done) / rate);
  }
  if (terminal_)
    std::cerr << '\r' << line << "   " << std::flush;
  else
    std::cerr << line << '\n';
  open_ = terminal_;
}

} // namespace apps
} // namespace pcl_ssfr
