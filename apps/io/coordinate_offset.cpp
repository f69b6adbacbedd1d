// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/coordinate_offset.h>

#include <apps/io/field_table.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr std::size_t kOffsetSamples = 1001; ///< points looked at to find the offset
constexpr std::size_t kScan = 50;            ///< points of a scan, at least

} // namespace

Eigen::Vector3d
chooseOffset(std::size_t count, const std::function<Eigen::Vector3d(std::size_t)>& point)
{
  const std::size_t step = count / kOffsetSamples + 1;
  std::array<std::vector<double>, 3> samples;
  for (std::size_t i = 0; i < count; i += step) {
    const Eigen::Vector3d sample = point(i);
    if (sample.allFinite())
      for (std::size_t k = 0; k < 3; ++k)
        samples[k].push_back(sample[static_cast<Eigen::Index>(k)]);
  }
  if (samples[0].empty())
    return Eigen::Vector3d::Zero();
  Eigen::Vector3d median;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto middle = samples[k].begin() + static_cast<std::ptrdiff_t>(samples[k].size() / 2);
    std::nth_element(samples[k].begin(), middle, samples[k].end());
    median[static_cast<Eigen::Index>(k)] = std::round(*middle);
  }
  return median.cwiseAbs().maxCoeff() > kLargeCoordinate ? median : Eigen::Vector3d::Zero();
}

double
floatStep(std::size_t count, const std::function<Eigen::Vector3d(std::size_t)>& point, const Eigen::Vector3d& offset)
{
  if (count < kScan || offset.isZero())
    return 0;
  Eigen::Index axis = 0;
  const auto farthest = static_cast<float>(offset.cwiseAbs().maxCoeff(&axis));
  const std::size_t step = count / kOffsetSamples + 1;
  for (std::size_t i = 0; i < count; i += step) {
    const double value = point(i)[axis];
    if (std::isfinite(value) && static_cast<double>(static_cast<float>(value)) != value)
      return 0;
  }
  return std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest;
}

} // namespace io
} // namespace pcl_ssfr
