// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/confidence.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

/// Logistic model over the evidence.
struct Coefficients {
  double constant, score, tightness, ratio, third, contradiction;
};
// Fitted by scripts/fit_confidence on 918 right and 127 wrong answers (real pairs turned at random and as they are,
// scans of different places, simulated offices, flats, halls and streets); without free space on 105 and 95.
constexpr Coefficients kWithFreeSpace = {11.863, 2.588, -1.108, -5.457, 0.327, -117.3};
constexpr Coefficients kWithoutFreeSpace = {6.351, 0.909, -1.489, -0.896, 0.638, 0};
constexpr double kMinScore = 0.02;
constexpr double kMinThird = 0.001;

} // namespace

double
estimateConfidence(const Candidate& best, double rival_ratio, bool free_space)
{
  if (!(best.score > 0))
    return 0;
  const Coefficients& c = free_space ? kWithFreeSpace : kWithoutFreeSpace;
  const double visible = std::max(best.overlap + best.contradiction + best.evidence.unmatched, kMinScore);
  const double logit =
      c.constant + c.score * std::log(std::max(best.score, kMinScore)) + c.tightness * best.evidence.tightness +
      c.ratio * std::clamp(rival_ratio, free_space ? 0.0 : -1.0, 1.0) +
      c.third * std::log(best.evidence.third_direction + kMinThird) + c.contradiction * best.contradiction / visible;
  return 1 / (1 + std::exp(-logit));
}

double
ambiguousRatio(bool free_space)
{
  return free_space ? 0.96 : 0.9;
}

} // namespace pcl_ssfr
