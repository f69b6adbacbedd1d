// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/confidence.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

/// Logistic model over the evidence.
struct Coefficients {
  double constant, matched, lead, clear, third;
};
// Fitted by scripts/fit_confidence on 2793 right and 597 wrong answers (real pairs turned at random and as they are,
// such as their makers do not list, with sources thinned, cut to a sector of 240 degrees and cut in range to 80 %, each
// set's sources with the targets of three others, simulated offices, flats, halls and streets); without free space,
// before answers were held against the second effort, on 91 and 23 (such pairs with their origins moved or another scan
// merged).
constexpr Coefficients kWithFreeSpace = {17.217, 0, 1.307, 4.905, 2.092};
constexpr Coefficients kWithoutFreeSpace = {8.019, 0.730, 1.112, 0, 0.575};
constexpr double kMinMatched = 0.02;
constexpr double kMinLead = 0.005;
constexpr double kMinClear = 0.03;
constexpr double kMinThird = 0.001;

} // namespace

double
estimateConfidence(const Candidate& best, double lead, bool free_space)
{
  if (!(best.score > 0))
    return 0;
  const Coefficients& c = free_space ? kWithFreeSpace : kWithoutFreeSpace;
  const double matched = best.evidence.facing_matched;
  const double least_lead = std::min({lead, best.score, best.evidence.facing_score});
  const double clear = best.evidence.facing_score / std::max(matched, kMinMatched);
  const double logit =
      c.constant + c.matched * std::log(matched + kMinMatched) + c.lead * std::log(std::max(least_lead, kMinLead)) +
      c.clear * std::log(std::max(clear, kMinClear)) + c.third * std::log(best.evidence.third_direction + kMinThird);
  return 1 / (1 + std::exp(-logit));
}

double
ambiguousRatio(bool free_space)
{
  return free_space ? 0.96 : 0.9;
}

} // namespace pcl_ssfr
