// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/vote_count.h"

#include <algorithm>
#include <iterator>

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
  std::vector<std::int32_t> facing(static_cast<std::size_t>(counter.size()));
  const auto against = [&](std::size_t s) {
    counter.findVotesFor(line[s], facing);
    return counter.votesAgainst(line[s], facing, static_cast<double>(facing.size()));
  };
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = counts[s];
    if (count == 0 || (s > 0 && counts[s - 1] > count) || (s + 1 < line.count && counts[s + 1] >= count))
      continue;
    found.push_back({line[s], count, count - config.contradiction_weight * against(s)});
  }
}

void
findLeastContradicted(const VoteCounter& counter,
                      const ShiftLine& line,
                      const SearchConfig& config,
                      double least_score,
                      std::vector<VotedTranslation>& found)
{
  const std::vector<int> screened = counter.screen(line.everySecond());
  const auto all = static_cast<double>(counter.size());
  const double promising = config.screening_share * least_score * all;
  std::vector<std::int32_t> facing(static_cast<std::size_t>(counter.size()));
  std::vector<VotedTranslation> seen(line.count);
  const auto look = [&](std::size_t s, double least) {
    const int count = counter.findVotesFor(line[s], facing);
    if (count > 0)
      seen[s] = {line[s], count, count / (1.0 + counter.votesAgainst(line[s], facing, count / least))};
  };
  for (std::size_t s = 0; s < line.count; s += 2)
    if (screened[s / 2] > 0)
      look(s, promising);
  for (std::size_t s = 1; s < line.count; s += 2) {
    const std::size_t after = std::min(s + 1, line.count - 1);
    const auto promises = [&](std::size_t k) { return screened[k / 2] > 0 && seen[k].score >= promising; };
    if (promises(s - 1) || (after > s && promises(after)))
      look(s, least_score * all);
  }
  std::copy_if(seen.begin(), seen.end(), std::back_inserter(found), [&](const VotedTranslation& shift) {
    return shift.votes > 0 && shift.score / all >= least_score;
  });
}

} // namespace pcl_ssfr
