// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/fast_global_registration.h>

#include "baseline_scan.h"
#include "fast_global_pose.h"
#include "fpfh_features.h"
#include "judgement/overlap.h"
#include "option_checks.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace pcl_ssfr::baselines {

namespace {

constexpr double kNormalRadiusPerLeaf = 2;
constexpr double kFeatureRadiusPerLeaf = 5;
constexpr double kThresholdPerLeaf = 1.5;

void
requireValid(const FastGlobalOptions& options)
{
  const auto share = [](double value, const char* name) {
    checkOption(value >= 0 && value <= 1, name, value, "be in [0, 1]");
  };
  checkLength("leaf", options.leaf);
  checkLength("normal_radius", options.normal_radius);
  checkLength("feature_radius", options.feature_radius);
  checkLength("distance_threshold", options.distance_threshold);
  checkOption(options.tuple_similarity > 0 && options.tuple_similarity <= 1,
              "tuple_similarity",
              options.tuple_similarity,
              "be in (0, 1]");
  checkOption(options.max_tuples > 0, "max_tuples", static_cast<double>(options.max_tuples), "be > 0");
  checkOption(options.iterations >= 0, "iterations", options.iterations, "be >= 0");
  share(options.min_inlier_ratio, "min_inlier_ratio");
  share(options.min_overlap, "min_overlap");
  checkOption(options.threads > 0, "threads", options.threads, "be > 0");
}

/// Why the pose is no answer; empty when it is one.
std::string
weakness(const FastGlobalOptions& options, const FastGlobalPose& pose, double overlap)
{
  const auto matches = static_cast<double>(pose.matches);
  if (pose.inliers < options.min_inliers || static_cast<double>(pose.inliers) < options.min_inlier_ratio * matches)
    return "only " + std::to_string(pose.inliers) + " of " + std::to_string(pose.matches) +
           " matches agree with the best pose";
  if (pose.inlier_spread <= options.distance_threshold)
    return "the matches that agree lie on one line";
  if (overlap < options.min_overlap)
    return "the best pose puts only " + shortNumber(overlap) + " of the source on the target";
  return {};
}

} // namespace

BaselineResult
registerFastGlobal(const ScanView& source,
                   const ScanView& target,
                   const FastGlobalOptions& options,
                   const std::optional<Eigen::Isometry3d>& guess)
{
  requireValid(options);
  FastGlobalOptions used = options;
  BaselineResult result;
  const std::optional<BaselinePair> scans = thinPair(source, target, used.leaf, used.threads, kPosePoints, result);
  if (!scans)
    return result;
  const BaselineScan& source_scan = scans->source;
  const BaselineScan& target_scan = scans->target;
  used.leaf = result.leaf;
  const auto or_leafs = [&used](double value, double leafs) { return value > 0 ? value : leafs * used.leaf; };
  used.normal_radius = or_leafs(used.normal_radius, kNormalRadiusPerLeaf);
  used.feature_radius = or_leafs(used.feature_radius, kFeatureRadiusPerLeaf);
  used.distance_threshold = or_leafs(used.distance_threshold, kThresholdPerLeaf);
  result.inlier_distance = used.distance_threshold;

  // Section 3.1: descriptors, reciprocity test, tuple test.
  const auto describe = [&used](const BaselineScan& scan) {
    return computeFpfh(scan.points, scan.viewpoint, used.normal_radius, used.feature_radius, used.threads);
  };
  const std::vector<PointMatch> mutual = matchReciprocally(describe(source_scan), describe(target_scan), used.threads);
  TupleTestOptions tuple_options;
  tuple_options.similarity = used.tuple_similarity;
  tuple_options.max_tuples = used.max_tuples;
  tuple_options.seed = used.seed;
  const std::vector<PointMatch> matches = tupleTest(source_scan.points, target_scan.points, mutual, tuple_options);
  if (matches.empty()) {
    result.message = "no three of " + std::to_string(mutual.size()) + " matches of descriptors agree with each other";
    return result;
  }

  // Section 3.2: the pose.
  FastGlobalPoseOptions pose_options;
  pose_options.distance_threshold = used.distance_threshold;
  pose_options.iterations = used.iterations;
  for (const Points3* points : {&source_scan.points, &target_scan.points}) {
    const Eigen::Vector3d mean = points->rowwise().mean();
    const double radius = std::sqrt((points->colwise() - mean).colwise().squaredNorm().maxCoeff());
    pose_options.diameter = std::max(pose_options.diameter, 2 * radius);
  }
  std::optional<Eigen::Isometry3d> centred_guess;
  if (guess)
    centred_guess = centred(*guess, source_scan, target_scan);
  const FastGlobalPose pose = optimizeFastGlobalPose(
      source_scan.points, target_scan.points, matches, pose_options, centred_guess ? &*centred_guess : nullptr);

  result.T_target_source = uncentred(pose.T_target_source, source_scan, target_scan);
  result.correspondences = pose.matches;
  result.inliers = pose.inliers;
  result.iterations = pose.iterations;
  result.overlap = computeOverlap(source_scan.points,
                                  NeighborIndex(target_scan.points),
                                  pose.T_target_source,
                                  used.distance_threshold,
                                  used.threads)
                       .ratio;
  result.message = weakness(used, pose, result.overlap);
  result.converged = result.message.empty();
  if (result.converged)
    result.message = std::to_string(pose.inliers) + " of " + std::to_string(pose.matches) + " matches agree, overlap " +
                     shortNumber(result.overlap);
  return result;
}

} // namespace pcl_ssfr::baselines
