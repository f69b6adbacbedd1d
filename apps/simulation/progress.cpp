// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/progress.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>

namespace pcl_ssfr::simulation {

namespace {

constexpr std::chrono::milliseconds kBarInterval(100);
constexpr std::chrono::seconds kLineInterval(5);
constexpr std::size_t kFields = 30;
constexpr double kLeastElapsed = 1; // before the time that is left is estimated [s]

} // namespace

std::string
formatProgress(std::size_t item, std::size_t items, double share, double elapsed)
{
  const double done =
      items == 0 ? 1 : std::clamp((static_cast<double>(item) + share) / static_cast<double>(items), 0.0, 1.0);
  const auto full = static_cast<std::size_t>(done * kFields);
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "] scan %zu of %zu, %.0f %%", std::min(item + 1, items), items, 100 * done);
  std::string line = "[" + std::string(full, '#') + std::string(kFields - full, '.') + text.data();
  if (elapsed >= kLeastElapsed && done > 0 && done < 1) {
    std::snprintf(text.data(), text.size(), ", %.0f s left", std::ceil(elapsed * (1 - done) / done));
    line += text.data();
  }
  return line;
}

Progress::Progress(std::ostream& stream, Style style)
    : stream_(stream), style_(style), start_(Clock::now()), shown_(start_)
{}

Progress::Style
Progress::styleFor(bool quiet)
{
  if (quiet)
    return Style::Silent;
  return isatty(STDERR_FILENO) != 0 ? Style::Bar : Style::Lines;
}

void
Progress::update(std::size_t item, std::size_t items, double share)
{
  const auto now = Clock::now();
  if (style_ == Style::Silent ||
      now - shown_ < (style_ == Style::Bar ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval)))
    return;
  shown_ = now;
  const std::string line = formatProgress(item, items, share, std::chrono::duration<double>(now - start_).count());
  if (style_ == Style::Lines) {
    stream_ << line.substr(line.find(']') + 2) << '\n' << std::flush;
    return;
  }
  const std::size_t blanks = width_ > line.size() ? width_ - line.size() : 0;
  stream_ << '\r' << line << std::string(blanks, ' ') << std::flush;
  width_ = line.size();
}

void
Progress::finish()
{
  if (width_ > 0)
    stream_ << '\r' << std::string(width_, ' ') << '\r' << std::flush;
  width_ = 0;
}

} // namespace pcl_ssfr::simulation
