// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/progress.h>

#include <apps/common/format_text.h>
#include <apps/common/seconds_since.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kRefresh = 1; ///< of the line on a terminal [s]

std::string
duration(double seconds)
{
  const auto whole = static_cast<long long>(std::ceil(seconds));
  char text[40];
  if (whole >= 3600)
    std::snprintf(text, sizeof(text), "%lld h %02lld min", whole / 3600, whole / 60 % 60);
  else if (whole >= 60)
    std::snprintf(text, sizeof(text), "%lld min %02lld s", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof(text), "%lld s", whole);
  return text;
}

} // namespace

std::string
describeOutcome(const ResultRow& row)
{
  const bool none_is_right = row.variation.mirror_source || row.variation.pairs_from == PairsFrom::Unrelated;
  const bool is_unknown = none_is_right || (row.T_target_source && !row.truth);
  const char* verdict = is_unknown ? (row.converged ? "accepted" : "not accepted") : (row.success ? "right" : "wrong");
  std::string text = std::string(verdict) + ", " + row.status + ", ";
  if (!row.T_target_source)
    return text + "no pose";
  if (is_unknown)
    return text + (none_is_right ? "no pose is right" : "the true pose is not known");
  return text + format("%.3f deg, %.3f m", row.rotation_error_deg, row.translation_error_m);
}

Progress::Progress(std::size_t total, std::size_t kept)
    : terminal_(isatty(STDERR_FILENO) == 1), total_(total), start_(Clock::now()), shown_(start_)
{
  std::fprintf(stderr, "%zu to run%s\n", total, kept > 0 ? (", " + std::to_string(kept) + " done before").c_str() : "");
}

void
Progress::add(const ResultRow& row)
{
  ++done_;
  if (terminal_)
    return show();
  std::fprintf(
      stderr,
      "%zu/%zu %s %s->%s%s%s %s: %s, %.2f s; %s left\n",
      done_,
      total_,
      row.dataset.c_str(),
      row.source.c_str(),
      row.target.c_str(),
      describeVariation(row.variation) == "as it is" ? "" : " ",
      describeVariation(row.variation) == "as it is" ? "" : ("(" + describeVariation(row.variation) + ")").c_str(),
      row.method.c_str(),
      describeOutcome(row).c_str(),
      row.time_s,
      duration(secondsSince(start_) / static_cast<double>(done_) * static_cast<double>(total_ - done_)).c_str());
}

void
Progress::tick()
{
  if (terminal_ && secondsSince(shown_) > kRefresh)
    show();
}

void
Progress::show()
{
  shown_ = Clock::now();
  const double seconds = secondsSince(start_);
  const double rate = static_cast<double>(done_) / std::max(seconds, 1e-9);
  std::fprintf(stderr,
               "\r%zu/%zu (%.0f %%), %.2f a second, %s left\033[K",
               done_,
               total_,
               100 * static_cast<double>(done_) / static_cast<double>(std::max<std::size_t>(total_, 1)),
               rate,
               done_ == 0 ? "?" : duration(static_cast<double>(total_ - done_) / rate).c_str());
  std::fflush(stderr);
}

void
Progress::finish() const
{
  if (terminal_)
    std::fprintf(stderr, "\n");
}

} // namespace apps
} // namespace pcl_ssfr
