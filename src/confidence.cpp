// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/confidence.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

/// Logistic model over the evidence.
struct Coefficients {
  double constant, matched, lead, clear, third;
};
// Fitted by scripts/fit_confidence on 1737 right and 194 wrong answers (real pairs turned at random and as they are,
// with sources thinned, cut to a sector and cut in range, scans of different places, simulated offices, flats, halls
// and streets); without free space on 146 and 34 (such pairs with their origins moved or another scan merged), where
// what contradictions leave tells nothing more. Both when each patch still had one voice, whatever its area: fitted to
// the scores of now, right poses at 30 % overlap were refused (docs/RESULTS.md).
constexpr Coefficients kWithFreeSpace = {12.171, -0.977, 1.759, 0.964, 1.401};
constexpr Coefficients kWithoutFreeSpace = {8.547, 1.775, 1.591, 0, 0.116};
constexpr double kMinMatched = 0.02;
constexpr double kMinLead = 0.005;
constexpr double kMinClear = 0.03;
constexpr double kMinThird = 0.001;

} // namespace

double
estimateConfidence(const Candidate& best, double rival_ratio, bool free_space)
{
  if (!(best.score > 0))
    return 0;
  const Coefficients& c = free_space ? kWithFreeSpace : kWithoutFreeSpace;
  const double matched = best.evidence.patches_matched;
  const double lead = best.score * (1 - std::clamp(rival_ratio, 0.0, 1.0));
  const double clear = best.score / std::max(matched, kMinMatched);
  const double logit = c.constant + c.matched * std::log(matched + kMinMatched) +
                       c.lead * std::log(std::max(lead, kMinLead)) + c.clear * std::log(std::max(clear, kMinClear)) +
                       c.third * std::log(best.evidence.third_direction + kMinThird);
  return 1 / (1 + std::exp(-logit));
}

double
ambiguousRatio(bool free_space)
{
  return free_space ? 0.96 : 0.9;
}

} // namespace pcl_ssfr
