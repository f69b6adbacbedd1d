// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/vote_count.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

void
findMostVoted(const Ballot& ballot,
              const ShiftLine& line,
              double contradiction_weight,
              int& best_screened,
              std::vector<Verdict>& found)
{
  // Patches are found from about two steps away: every second shift tells whether those around it are worth counting.
  const std::vector<int> glanced = ballot.glance(line.everySecond());
  std::vector<int> counts(line.count, 0);
  for (std::size_t s = 0; s < line.count; s += 2) {
    const Eigen::Vector3f t = line[s];
    const int screened = ballot.screenedVotesFor(t, glanced[s / 2], best_screened);
    best_screened = std::max(best_screened, screened);
    if (screened < kScreeningShare * best_screened)
      continue;
    counts[s] = screened + ballot.otherVotesFor(t);
    if (s > 0 && counts[s - 1] == 0)
      counts[s - 1] = ballot.votesFor(line[s - 1]);
    if (s + 1 < line.count)
      counts[s + 1] = ballot.votesFor(line[s + 1]);
  }
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = counts[s];
    if (count == 0 || (s > 0 && counts[s - 1] > count) || (s + 1 < line.count && counts[s + 1] >= count))
      continue;
    found.push_back({line[s], count, count - contradiction_weight * ballot.votesAgainst(line[s])});
  }
}

void
findUncontradicted(const Ballot& ballot,
                   const ShiftLine& line,
                   double contradiction_weight,
                   std::vector<Verdict>& found)
{
  const std::vector<int> glanced = ballot.glance(line.everySecond());
  std::vector<bool> wanted(line.count, false);
  for (std::size_t s = 0; s < line.count; s += 2)
    if (ballot.isWorthCounting(line[s], glanced[s / 2]))
      for (std::size_t k = s - std::min<std::size_t>(s, 1); k <= std::min(s + 1, line.count - 1); ++k)
        wanted[k] = true;
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = wanted[s] ? ballot.votesFor(line[s]) : 0;
    if (count < kLeastShare * static_cast<double>(ballot.size()))
      continue;
    const int most =
        static_cast<int>(std::min(std::ceil(count / contradiction_weight), static_cast<double>(ballot.size()) + 1));
    const int against = ballot.votesAgainst(line[s], most);
    if (against < most)
      found.push_back({line[s], count, count - contradiction_weight * against});
  }
}

} // namespace pcl_ssfr
