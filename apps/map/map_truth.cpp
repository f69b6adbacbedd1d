// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_truth.h>

#include "common/rotation_math.h"

#include <apps/common/degrees.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kCoarseDegrees = 5; // what others count as right ...
constexpr double kCoarse = 2;        // [m]

using Poses = std::vector<Eigen::Isometry3d>;

double
median(std::vector<double> values)
{
  if (values.empty())
    return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double
largest(const std::vector<double>& values)
{
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : *std::max_element(values.begin(), values.end());
}

double
angle(const Eigen::Matrix3d& R)
{
  return Eigen::AngleAxisd(R).angle() * kDegreesPerRadian;
}

/// The rigid motion from the map to the truth in the least squares sense: rotations and places of some scans.
Eigen::Isometry3d
fit(const std::vector<std::size_t>& scans,
    const Poses& map,
    const Poses& truth,
    const std::vector<Eigen::Vector3d>& places)
{
  Eigen::Vector3d mean_map = Eigen::Vector3d::Zero(), mean_truth = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(scans.size());
  for (const std::size_t i : scans) {
    mean_map += map[i] * places[i] / n;
    mean_truth += truth[i] * places[i] / n;
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::size_t i : scans) {
    sum += (truth[i] * places[i] - mean_truth) * (map[i] * places[i] - mean_map).transpose();
    sum += truth[i].linear() * map[i].linear().transpose(); // as places one metre around the sensor
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(sum);
  T.translation() = mean_truth - T.linear() * mean_map;
  return T;
}

} // namespace

MapErrors
compareWithTruth(const MultiwayMap& map,
                 const std::vector<std::optional<Eigen::Isometry3d>>& truth,
                 const std::vector<Eigen::Vector3d>& places,
                 double rotation_bound_deg,
                 double translation_bound_m)
{
  MapErrors errors;
  errors.scans.resize(map.scans.size());
  Poses found, known(map.scans.size(), Eigen::Isometry3d::Identity());
  std::map<int, std::vector<std::size_t>> components;
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    found.push_back(map.scans[i].T_map_scan);
    if (truth[i]) {
      known[i] = *truth[i];
      components[map.scans[i].component].push_back(i);
    }
  }
  const auto errorOf = [&](std::size_t i, const Eigen::Isometry3d& T_truth_map, const Poses& poses) {
    const Eigen::Isometry3d T = T_truth_map * poses[i];
    return std::pair(angle(T.linear().transpose() * known[i].linear()), (T * places[i] - known[i] * places[i]).norm());
  };
  // The scans of a component that agree on where it lies in the truth: most of them.
  const auto rightOnes = [&](const std::vector<std::size_t>& scans, double rotation_deg, double translation_m) {
    std::vector<std::size_t> right;
    for (const std::size_t held : scans) {
      Eigen::Isometry3d T = known[held] * found[held].inverse();
      for (bool has_grown = true; has_grown;) {
        std::vector<std::size_t> near;
        for (const std::size_t i : scans) {
          const auto [rotation, translation] = errorOf(i, T, found);
          if (rotation < rotation_deg && translation < translation_m)
            near.push_back(i);
        }
        // The frame of one scan leaves a long street within the bound only near it.
        has_grown = near.size() > right.size();
        if (has_grown) {
          right = near;
          T = fit(right, found, known, places);
        }
      }
    }
    return right;
  };
  std::vector<double> translations, rotations, graph, chain, consistency;
  for (const auto& [component, scans] : components) {
    if (scans.size() < 2)
      continue;
    const std::vector<std::size_t> right = rightOnes(scans, rotation_bound_deg, translation_bound_m);
    errors.wrong_coarsely += scans.size() - rightOnes(scans, kCoarseDegrees, kCoarse).size();
    const Eigen::Isometry3d T = fit(right, found, known, places);
    const Eigen::Isometry3d T_graph = fit(right, map.graph_poses, known, places);
    const Eigen::Isometry3d T_chain = fit(right, map.chain_poses, known, places);
    for (const std::size_t i : scans) {
      ScanError error;
      std::tie(error.rotation_deg, error.translation_m) = errorOf(i, T, found);
      error.wrong = std::find(right.begin(), right.end(), i) == right.end();
      ++errors.placed;
      errors.wrong += error.wrong ? 1 : 0;
      if (!error.wrong) {
        translations.push_back(error.translation_m);
        rotations.push_back(error.rotation_deg);
        graph.push_back(errorOf(i, T_graph, map.graph_poses).second);
        chain.push_back(errorOf(i, T_chain, map.chain_poses).second);
      }
      errors.scans[i] = error;
    }
    // The covariance is that of a scan relative to the one that holds the frame: so is this error.
    const auto held =
        std::find_if(right.begin(), right.end(), [&](std::size_t i) { return map.scans[i].covariance.isZero(0); });
    if (held == right.end())
      continue;
    const Eigen::Isometry3d T_map_truth = found[*held] * known[*held].inverse();
    for (const std::size_t i : right) {
      if (i == *held || map.scans[i].covariance.isZero(0))
        continue;
      const Eigen::Isometry3d expected = T_map_truth * known[i];
      const Eigen::AngleAxisd rotation(found[i].linear() * expected.linear().transpose());
      Eigen::Matrix<double, 6, 1> motion;
      motion << rotation.angle() * rotation.axis(), found[i] * places[i] - expected * places[i];
      errors.scans[i]->consistency = motion.dot(map.scans[i].covariance.ldlt().solve(motion)) / 6;
      consistency.push_back(errors.scans[i]->consistency);
    }
  }
  std::vector<double> pairs;
  for (const MapLink& link : map.links) {
    const auto s = static_cast<std::size_t>(link.source);
    const auto t = static_cast<std::size_t>(link.target);
    if (link.status == LinkStatus::Used && errors.scans[s] && errors.scans[t])
      pairs.push_back((link.T_target_source * places[s] - known[t].inverse() * known[s] * places[s]).norm());
  }
  errors.median_translation_m = median(translations);
  errors.largest_translation_m = largest(translations);
  errors.median_rotation_deg = median(rotations);
  errors.largest_rotation_deg = largest(rotations);
  errors.graph_median_m = median(graph);
  errors.chain_median_m = median(chain);
  errors.pairs_median_m = median(pairs);
  double sum = 0;
  for (const double value : consistency)
    sum += value;
  errors.consistency =
      consistency.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(consistency.size());
  return errors;
}

} // namespace apps
} // namespace pcl_ssfr
