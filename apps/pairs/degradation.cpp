// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/degradation.h>

#include <apps/common/degrees.h>
#include <apps/common/random_stream.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {
namespace apps {

namespace {

void
require(bool holds, const char* name, double value, const char* range)
{
  if (!holds)
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + ", but must be " + range);
}

} // namespace

std::vector<std::size_t>
remainingPoints(const Eigen::Matrix3Xf& points, const Degradation& degradation, std::uint64_t seed)
{
  require(degradation.every >= 1, "every", static_cast<double>(degradation.every), "at least 1");
  require(degradation.sector_deg >= 0 && degradation.sector_deg <= 360, "sector", degradation.sector_deg, "0 to 360");
  require(degradation.nearest >= 0 && degradation.nearest <= 1, "nearest", degradation.nearest, "0 to 1");
  const double begin = RandomStream(seed).uniform(0, 360);
  std::vector<std::size_t> left;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double angle = kDegreesPerRadian * static_cast<double>(std::atan2(points(1, i), points(0, i))) - begin;
    if (degradation.sector_deg >= 360 || angle - 360 * std::floor(angle / 360) < degradation.sector_deg)
      left.push_back(static_cast<std::size_t>(i));
  }
  if (degradation.nearest < 1) {
    const auto range = [&points](std::size_t i) { return points.col(static_cast<Eigen::Index>(i)).squaredNorm(); };
    std::stable_sort(left.begin(), left.end(), [&range](std::size_t a, std::size_t b) { return range(a) < range(b); });
    left.resize(static_cast<std::size_t>(std::ceil(degradation.nearest * static_cast<double>(left.size()))));
    std::sort(left.begin(), left.end());
  }
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < left.size(); k += degradation.every)
    kept.push_back(left[k]);
  return kept;
}

} // namespace apps
} // namespace pcl_ssfr
