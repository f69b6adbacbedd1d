// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/super4pcs.h>

#include "baseline_scan.h"
#include "common/angles.h"
#include "congruent_sets.h"
#include "lcp_verifier.h"
#include "option_checks.h"
#include "preparation/thinning.h"
#include "surface_normals.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace pcl_ssfr::baselines {

namespace {

constexpr double kThresholdPerLeaf = 1.5;
constexpr double kNormalRadiusPerLeaf = 2;
constexpr double kMinLcpPerOverlap = 0.75;
constexpr double kFailureProbability = 0.01; ///< that no base lies in the overlap
constexpr double kBaseHasQuad = 0.25;        ///< a base in the overlap has its points in the sample this often, about
constexpr int kMaxBases = 1000;              ///< however small the overlap is
constexpr double kMaxAngleTolerance = 0.2;   ///< between the segments of a quad [rad]
constexpr std::size_t kVerifiedAtOnce = 512; ///< quads that compete with the same best pose

void
requireValid(const Super4PcsOptions& options)
{
  const auto share = [](double value, const char* name) {
    checkOption(value > 0 && value <= 1, name, value, "be in (0, 1]");
  };
  checkLength("leaf", options.leaf);
  checkLength("distance_threshold", options.distance_threshold);
  share(options.overlap, "overlap");
  share(options.target_lcp, "target_lcp");
  checkOption(options.min_lcp >= 0 && options.min_lcp <= 1, "min_lcp", options.min_lcp, "be in [0, 1]");
  checkOption(options.normal_tolerance > 0 && options.normal_tolerance <= kPi / 2,
              "normal_tolerance",
              options.normal_tolerance,
              "be in (0, pi/2] [rad]");
  checkOption(options.sample_size >= kBasePoints, "sample_size", static_cast<double>(options.sample_size), "be >= 4");
  checkOption(options.max_quads > 0, "max_quads", static_cast<double>(options.max_quads), "be > 0");
  checkOption(options.max_bases >= 0, "max_bases", options.max_bases, "be >= 0");
  checkOption(options.time_limit >= 0, "time_limit", options.time_limit, "be >= 0 [s]");
  checkOption(options.threads > 0, "threads", options.threads, "be > 0");
}

/// Bases after which one of them lay in the overlap, and its quad in the sample, almost surely.
int
basesFor(double overlap)
{
  const double hit = kBaseHasQuad * std::pow(overlap, 4);
  const double bases = std::log(kFailureProbability) / std::log(1 - hit);
  return static_cast<int>(std::ceil(std::min<double>(bases, kMaxBases)));
}

/// \p count of the numbers below \p size in random order; all of them when there are no more.
std::vector<Eigen::Index>
randomColumns(Eigen::Index size, std::size_t count, std::mt19937_64& engine)
{
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(size));
  std::iota(columns.begin(), columns.end(), Eigen::Index{0});
  const std::size_t kept = std::min(count, columns.size());
  for (std::size_t i = 0; i < kept; ++i)
    std::swap(columns[i], columns[i + static_cast<std::size_t>(engine() % (columns.size() - i))]);
  columns.resize(kept);
  return columns;
}

/// The named columns of a matrix.
Points3
columnsOf(const Points3& matrix, const std::vector<Eigen::Index>& columns)
{
  Points3 result(3, static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i)
    result.col(i) = matrix.col(columns[static_cast<std::size_t>(i)]);
  return result;
}

/// Twice the 90th percentile of the distance to the median point.
double
robustDiameter(const Points3& points)
{
  const Eigen::Matrix3Xf floats = points.cast<float>();
  ScanView view;
  view.xyz = floats.data();
  view.size = static_cast<std::size_t>(floats.cols());
  return 2 * measureExtent(view).radius;
}

struct Candidate {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  Eigen::Index inliers = 0;
};

/// The least-squares pose of a quad on the base.
Eigen::Isometry3d
quadPose(const Points3& source, const Quad& quad, const Eigen::Matrix<double, 3, 4>& base_points)
{
  Eigen::Matrix<double, 3, 4> quad_points;
  for (int k = 0; k < 4; ++k)
    quad_points.col(k) = source.col(quad[static_cast<std::size_t>(k)]);
  return Eigen::Isometry3d(Eigen::umeyama(quad_points, base_points, false));
}

/// Verify the quads of one base and keep the best pose; which one it is does not depend on the threads.
void
verifyQuads(const Points3& source,
            const std::vector<Quad>& quads,
            const Eigen::Matrix<double, 3, 4>& base_points,
            const LcpVerifier& verifier,
            const Super4PcsOptions& options,
            Candidate& best)
{
  const double share = static_cast<double>(quads.size()) / static_cast<double>(options.max_quads);
  const std::size_t count = std::min(quads.size(), options.max_quads);
  const double squared_fit = 4 * options.distance_threshold * options.distance_threshold; // of all four points
  [[maybe_unused]] const int workers = static_cast<int>(options.threads);
  for (std::size_t begin = 0; begin < count; begin += kVerifiedAtOnce) {
    std::vector<Candidate> slots(std::min(kVerifiedAtOnce, count - begin));
    const Eigen::Index floor = best.inliers;
    const auto slot_count = static_cast<std::ptrdiff_t>(slots.size());
#pragma omp parallel for num_threads(workers) schedule(dynamic, 8) if (workers > 1)
    for (std::ptrdiff_t i = 0; i < slot_count; ++i) {
      const std::size_t place = begin + static_cast<std::size_t>(i);
      const std::size_t number =
          quads.size() > count ? static_cast<std::size_t>(share * static_cast<double>(place)) : place;
      const Quad& quad = quads[number];
      const Eigen::Isometry3d T = quadPose(source, quad, base_points);
      double squared_sum = 0;
      for (int k = 0; k < 4; ++k)
        squared_sum += (T * source.col(quad[static_cast<std::size_t>(k)]) - base_points.col(k)).squaredNorm();
      if (squared_sum <= squared_fit) {
        slots[static_cast<std::size_t>(i)].T_target_source = T;
        slots[static_cast<std::size_t>(i)].inliers = verifier.count(T, floor);
      }
    }
    for (const Candidate& slot : slots) {
      if (slot.inliers > best.inliers)
        best = slot;
    }
  }
}

} // namespace

BaselineResult
registerSuper4Pcs(const ScanView& source,
                  const ScanView& target,
                  const Super4PcsOptions& options,
                  const std::optional<Eigen::Isometry3d>& guess)
{
  const Deadline deadline = Deadline::after(options.time_limit, options.time_limit_clock);
  requireValid(options);
  Super4PcsOptions used = options;
  BaselineResult result;
  const std::optional<BaselinePair> scans = thinPair(source, target, used.leaf, used.threads, kBasePoints, result);
  if (!scans)
    return result;
  const BaselineScan& source_scan = scans->source;
  const BaselineScan& target_scan = scans->target;
  used.leaf = result.leaf;
  if (!(used.distance_threshold > 0))
    used.distance_threshold = kThresholdPerLeaf * used.leaf;
  const double delta = used.distance_threshold;
  result.inlier_distance = delta;

  std::mt19937_64 engine(used.seed);
  const auto normals_of = [&used](const BaselineScan& scan) {
    return estimateSurfaceNormals(scan.points, scan.viewpoint, kNormalRadiusPerLeaf * used.leaf, used.threads);
  };
  const Points3 target_normals = normals_of(target_scan);
  const std::vector<Eigen::Index> columns = randomColumns(source_scan.points.cols(), used.sample_size, engine);
  const Points3 sample = columnsOf(source_scan.points, columns);
  const Points3 sample_normals = columnsOf(normals_of(source_scan), columns);
  const PairExtractor extractor(sample);
  const LcpVerifier verifier(sample, target_scan.points, delta);
  const double max_diameter = used.overlap * robustDiameter(target_scan.points);
  const int max_bases = used.max_bases > 0 ? used.max_bases : basesFor(used.overlap);
  const auto wanted = static_cast<Eigen::Index>(std::ceil(used.target_lcp * static_cast<double>(verifier.size())));

  Candidate best;
  if (guess) {
    best.T_target_source = centred(*guess, source_scan, target_scan);
    best.inliers = verifier.count(best.T_target_source, 0);
  }
  int bases = 0;
  for (; result.iterations < max_bases && best.inliers < wanted && !deadline.hasPassed(); ++result.iterations) {
    const std::optional<CoplanarBase> base = selectBase(target_scan.points, max_diameter, delta, engine);
    if (!base)
      continue;
    ++bases;
    // Both ends of a pair are off by up to delta, mostly in different directions.
    const auto pairs_like = [&](Eigen::Index first, Eigen::Index second, double length) {
      return filterByNormals(sample,
                             sample_normals,
                             extractor.extract(length, delta, used.threads),
                             measureNormals(target_scan.points, target_normals, {first, second}),
                             used.normal_tolerance);
    };
    const std::vector<PointPair> first_pairs = pairs_like(base->points[0], base->points[1], base->first_length);
    const std::vector<PointPair> second_pairs = pairs_like(base->points[2], base->points[3], base->second_length);
    QuadTolerance tolerance;
    tolerance.distance = delta;
    tolerance.angle = std::min(delta / base->first_length + delta / base->second_length, kMaxAngleTolerance);
    const std::vector<Quad> quads =
        findCongruentQuads(sample, first_pairs, second_pairs, *base, tolerance, used.threads);
    Eigen::Matrix<double, 3, 4> base_points;
    for (int k = 0; k < 4; ++k)
      base_points.col(k) = target_scan.points.col(base->points[static_cast<std::size_t>(k)]);
    verifyQuads(sample, quads, base_points, verifier, used, best);
  }

  result.T_target_source = uncentred(best.T_target_source, source_scan, target_scan);
  result.overlap = static_cast<double>(best.inliers) / static_cast<double>(verifier.size());
  const double least = used.min_lcp > 0 ? used.min_lcp : kMinLcpPerOverlap * used.overlap;
  result.converged = best.inliers > 0 && result.overlap >= least;
  result.message = (result.converged ? "LCP " : "the best LCP is ") + shortNumber(result.overlap) +
                   (result.converged ? "" : ", " + shortNumber(least) + " needed") + ", " + std::to_string(bases) +
                   " bases" + (deadline.hasPassed() ? ", stopped by the time limit" : "");
  return result;
}

} // namespace pcl_ssfr::baselines
