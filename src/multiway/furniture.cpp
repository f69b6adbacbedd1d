// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/furniture.h"

#include "preparation/planar_patches.h"
#include "profiles/prepared_data.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pcl_ssfr {

namespace {

constexpr int kShareRounds = 30;
// Right ones, before any was seen: with five a single pair stays below FurnitureConfig::least_false.
constexpr double kPairsBefore = 5;

/// std::lgamma() leaves the sign in a variable of all threads.
double
logGamma(double x)
{
  int sign = 1;
  return ::lgamma_r(x, &sign);
}

/// Logarithm of the probability that n of v are seen through when the share is drawn from Beta(1, b) with that mean, up
/// to what does not depend on the mean.
double
logProbability(double n, double v, double mean)
{
  const double b = (1 - mean) / mean;
  return std::log(b) + logGamma(v - n + b) - logGamma(v + b + 1);
}

} // namespace

bool
isWalled(const PreparedScan& scan, const Furniture& furniture)
{
  return 2 * furniture.patches.size() < patchesOf(scan).patches.samples.size();
}

double
furnitureLogOdds(const FurnitureEvidence& pair, const FurnitureConfig& config)
{
  const double v = pair.in_view;
  const double n = std::clamp(pair.seen_through, 0.0, v);
  return logProbability(n, v, config.seen_through) - logProbability(n, v, config.seen_through_alike);
}

double
logOddsAmongMany(const FurnitureEvidence& pair, const FurnitureConfig& config)
{
  const double odds = furnitureLogOdds(pair, config);
  return odds > 0 ? config.agreement * odds : odds;
}

double
shareOfPlacesAlike(const std::vector<FurnitureEvidence>& pairs, const FurnitureConfig& config)
{
  std::vector<double> odds;
  odds.reserve(pairs.size());
  for (const FurnitureEvidence& pair : pairs)
    odds.push_back(std::exp(furnitureLogOdds(pair, config)));
  double share = 0.5;
  for (int round = 0; round < kShareRounds; ++round) {
    double alike = 0;
    for (const double for_one_place : odds)
      alike += share / (share + for_one_place * (1 - share));
    share = alike / (kPairsBefore + static_cast<double>(pairs.size()));
  }
  return share;
}

Furniture
furnitureOf(const PreparedScan& scan, const MultiwayOptions& options)
{
  const FurnitureConfig& config = options.furniture;
  const PatchScan& patches = patchesOf(scan);
  const OrientedSamples& all = patches.patches.samples;
  const double scale = patches.scale;
  const double most_area = config.most_area * scale * scale;
  std::vector<Eigen::Index> furniture;
  for (Eigen::Index i = 0; i < all.size(); ++i) {
    const Eigen::Vector3d normal = all.normals.col(i).cast<double>();
    double plane = 0;
    for (Eigen::Index j = 0; j < all.size() && plane < most_area; ++j) {
      const Eigen::Vector3d offset = (all.points.col(j) - all.points.col(i)).cast<double>();
      if (offset.norm() < config.reach * scale && std::abs(normal.dot(offset)) < config.thickness * scale &&
          std::abs(normal.dot(all.normals.col(j).cast<double>())) > config.parallel)
        plane += all.weights[j];
    }
    if (plane < most_area)
      furniture.push_back(i);
  }
  return {selectPatches(patches.patches, furniture).samples, solidClutter(scan, options)};
}

} // namespace pcl_ssfr
