// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "refinement/robust_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ssfr {

namespace {

/// Root mean square of the distances below \p farthest, which is twice the scale of their weight (Geman-McClure); 0
/// where there are none.
double
rmsWithin(const std::vector<double>& squares, const std::vector<double>& weights, double farthest)
{
  const double square = 0.25 * farthest * farthest;
  double weight = 0, sum = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double q = square / (square + squares[i]);
    const double w = squares[i] < 4 * square ? weights[i] * (q * q) : 0;
    weight += w;
    sum += w * squares[i];
  }
  return weight > 0 ? std::sqrt(sum / weight) : 0;
}

} // namespace

double
matchDistanceByNoise(const WeightedDistances& matches, const NoiseRule& rule)
{
  constexpr double kSettled = 1.01; // of a distance over the one before: less is no news
  std::vector<double> squares, weights;
  for (std::size_t i = 0; i < matches.distances.size(); ++i)
    if (std::abs(matches.distances[i]) < rule.most) {
      squares.push_back(matches.distances[i] * matches.distances[i]);
      weights.push_back(matches.weights[i]);
    }
  if (squares.empty())
    return rule.most;
  std::vector<double> ordered = squares;
  const auto middle = ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2);
  std::nth_element(ordered.begin(), middle, ordered.end());
  // From below: the root mean square grows with the distance, so this ends at the smallest one.
  double distance = std::max(rule.least, std::sqrt(*middle));
  while (distance < rule.most) {
    const double apart = std::hypot(rmsWithin(squares, weights, distance), rule.pose_deviation);
    const double next = 2 * rule.deviations * apart;
    if (next <= kSettled * distance)
      return std::min(rule.most, std::max(distance, next));
    distance = next;
  }
  return rule.most;
}

} // namespace pcl_ssfr
