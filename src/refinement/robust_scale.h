// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <vector>

namespace pcl_ssfr {

/// Plane distances of matches and what the matches weigh before the robust weight.
struct WeightedDistances {
  std::vector<double> distances; ///< [m], of either sign
  std::vector<double> weights;   ///< > 0, of the same number
};

/// What the plane distance of a match follows from, between \ref least and \ref most [m], 0 < least <= most.
struct NoiseRule {
  double deviations = 3;     ///< of what leaves the planes of matches apart that it is to cover, > 1
  double pose_deviation = 0; ///< standard deviation by which the pose may move the surface [m], >= 0
  double least = 0.006, most = 0.1;
};

/** \brief The plane distance of a match, twice the robust scale, that follows from the noise of the matches.
 *
 * Where matches are good to millimetres, what lies centimetres off a plane is not of that plane, and pulls. So it is
 * the smallest distance that takes in most of the matches and is at least twice NoiseRule::deviations times what leaves
 * their planes apart: the root mean square distance, robustly weighted as by addMatches(), and what the pose may be off
 * by. Without the latter the very matches that could tell a rotation would be left out as too far. Fewer than most may
 * meet by chance. Matches beyond NoiseRule::most are none; without any the distance is the most.
 */
double
matchDistanceByNoise(const WeightedDistances& matches, const NoiseRule& rule);

} // namespace pcl_ssfr
