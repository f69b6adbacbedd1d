// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/confidence.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

double
estimateConfidence(const Candidate& best, double rival_ratio, bool free_space)
{
  const double visible = best.overlap + best.contradiction + best.evidence.unmatched;
  if (!(visible > 0))
    return 0;
  const double overlap = std::log(std::max(best.overlap, 0.01));
  const double contradiction = std::log(best.contradiction / visible + 0.003);
  const double precision = std::log(std::max(best.overlap / visible, 0.05));
  const double weakest = std::log(best.evidence.weakest_direction + 0.05);
  const double third = std::log(best.evidence.third_direction + 0.001);
  const double ratio = std::clamp(rival_ratio, -1.0, 1.0);
  const double logit = free_space ? 12.33 + 3.89 * overlap - 1.26 * contradiction - 2.11 * precision -
                                        1.45 * best.evidence.tightness - 1.54 * weakest - 0.12 * ratio + 2.64 * third
                                  : 12.33 + 3.89 * overlap + 2.64 * third;
  return 1 / (1 + std::exp(-logit));
}

} // namespace pcl_ssfr
