// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/vote_count.h"

#include <algorithm>

namespace pcl_ssfr {

void
findMostVoted(const VoteCounter& counter,
              const ShiftLine& line,
              const SearchConfig& config,
              int& best_screened,
              std::vector<VotedTranslation>& found)
{
  // Patches are found from about two steps away: every second shift shows whether those around it are worth counting.
  const std::vector<int> screened = counter.screen(line.everySecond());
  std::vector<int> counts(line.count, 0);
  for (std::size_t s = 0; s < line.count; s += 2) {
    best_screened = std::max(best_screened, screened[s / 2]);
    if (screened[s / 2] < config.screening_share * best_screened)
      continue;
    counts[s] = screened[s / 2] + counter.otherVotesFor(line[s]);
    if (s > 0 && counts[s - 1] == 0)
      counts[s - 1] = counter.votesFor(line[s - 1]);
    if (s + 1 < line.count)
      counts[s + 1] = counter.votesFor(line[s + 1]);
  }
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = counts[s];
    if (count == 0 || (s > 0 && counts[s - 1] > count) || (s + 1 < line.count && counts[s + 1] >= count))
      continue;
    found.push_back({line[s], count, count - config.contradiction_weight * counter.votesAgainst(line[s])});
  }
}

void
findLeastContradicted(const VoteCounter& counter, const ShiftLine& line, std::vector<VotedTranslation>& found)
{
  const std::vector<int> screened = counter.screen(line.everySecond());
  for (std::size_t s = 0; s < line.count; ++s) {
    // The shifts with an even number are screened, the others count where a neighbour does.
    const int before = screened[s / 2], after = screened[std::min(s / 2 + s % 2, screened.size() - 1)];
    if (std::max(before, after) == 0)
      continue;
    const int count = s % 2 == 0 ? before + counter.otherVotesFor(line[s]) : counter.votesFor(line[s]);
    if (count > 0)
      found.push_back({line[s], count, count / (1.0 + counter.votesAgainst(line[s]))});
  }
}

} // namespace pcl_ssfr
