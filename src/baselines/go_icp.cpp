// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baseline_scan.h"
#include "common/types.h"
#include "go_icp_branch_and_bound.h"
#include "go_icp_problem.h"
#include "option_checks.h"
#include "preparation/thinning.h"

#include <pcl_ssfr/baselines/go_icp_core.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::baselines {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kOnALine = 1e-6;      ///< width against length below which points lie on a line
constexpr double kSmallestLeaf = 1e-3; ///< of the radius of a scan
constexpr int kLeafSteps = 10;         ///< halvings of the range that the voxel edge is looked for in
constexpr double kInlierPerRms = 2;    ///< distance threshold against the error, where none is given
constexpr int kIcpSteps = 100;         ///< of a local search, where the caller gives none

/// A scan thinned to about as many points as wanted.
struct Sample {
  Points3 points;  ///< [m]
  double leaf = 0; ///< edge of the voxels [m]; 0: all returns
};

Points3
returnsOf(const ScanView& scan)
{
  Points3 points(3, static_cast<Eigen::Index>(scan.count()));
  Eigen::Index used = 0;
  for (std::size_t i = 0; i < scan.count(); ++i) {
    if (scan.isReturn(i))
      points.col(used++) = scan.point(i).cast<double>();
  }
  points.conservativeResize(3, used);
  return points;
}

/// At most \p count points of equally large voxels, as many as possible.
Sample
drawSample(const ScanView& scan, std::size_t count, unsigned threads)
{
  Sample sample;
  const ScanExtent extent = measureExtent(scan);
  const double diagonal = (extent.max - extent.min).norm();
  if (extent.returns <= count || !(diagonal > 0)) {
    sample.points = returnsOf(scan);
    return sample;
  }
  double low = std::log(kSmallestLeaf * (extent.radius > 0 ? extent.radius : diagonal));
  double high = std::log(2 * diagonal); // the origin is a corner of voxels: no more than eight
  ThinnedCloud best;
  for (int step = 0; step < kLeafSteps; ++step) {
    const double middle = (low + high) / 2;
    ThinnedCloud cloud = thinScan(scan, std::exp(middle), extent.median, 0, threads);
    if (static_cast<std::size_t>(cloud.size()) <= count) {
      high = middle;
      best = std::move(cloud);
    }
    else {
      low = middle;
    }
  }
  if (best.size() == 0)
    best = thinScan(scan, std::exp(high), extent.median, 0, threads);
  sample.leaf = best.leaf;
  const Eigen::Index size = std::min(best.size(), static_cast<Eigen::Index>(count));
  sample.points = best.points.leftCols(size).cast<double>().colwise() + best.origin;
  return sample;
}

/// Columns 0 to n-1 in an order that every beginning of is spread over all: by their bits reversed.
std::vector<Eigen::Index>
spreadOrder(Eigen::Index n)
{
  std::vector<Eigen::Index> order;
  order.reserve(static_cast<std::size_t>(n));
  Eigen::Index size = 1;
  while (size < n)
    size *= 2;
  for (Eigen::Index i = 0; i < size; ++i) {
    Eigen::Index reversed = 0;
    for (Eigen::Index bit = 1; bit < size; bit *= 2)
      reversed = 2 * reversed + ((i & bit) != 0 ? 1 : 0);
    if (reversed < n)
      order.push_back(reversed);
  }
  return order;
}

/// True when the columns lie on a line or in a point.
bool
isLine(const Points3& points)
{
  const Points3 centred = points.colwise() - points.rowwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(centred * centred.transpose());
  return !(solver.eigenvalues()[1] > kOnALine * kOnALine * solver.eigenvalues()[2]);
}

void
checkOptions(const GoIcpOptions& options)
{
  const auto is_positive = [](double value) { return value > 0 && std::isfinite(value); };
  checkOption(options.source_points >= kPosePoints, "source_points", options.source_points, "be 3 or more");
  checkOption(options.trim_fraction >= 0 && options.trim_fraction < 1,
              "trim_fraction",
              options.trim_fraction,
              "be 0 or more and less than 1");
  checkOption(is_positive(options.mse_threshold), "mse_threshold", options.mse_threshold, "be > 0");
  checkOption(is_positive(options.translation_range), "translation_range", options.translation_range, "be > 0");
  checkOption(options.transform_size >= 2 && options.transform_size <= DistanceTransform::kMaxVoxels,
              "transform_size",
              options.transform_size,
              "be 2 to 512");
  checkOption(options.icp_iterations >= 0, "icp_iterations", options.icp_iterations, "be 0 or more");
  checkOption(options.inlier_distance >= 0, "inlier_distance", options.inlier_distance, "be 0 or more");
  checkOption(options.time_limit >= 0, "time_limit", options.time_limit, "be 0 or more");
  checkOption(options.threads >= 1, "threads", options.threads, "be 1 or more");
}

std::string
describeGap(const GoIcpReport& report)
{
  std::ostringstream text;
  text << "mean squared error " << shortNumber(report.error) << " m^2, certified gap " << shortNumber(report.gap)
       << " m^2, tolerance " << shortNumber(report.tolerance) << " m^2";
  return text.str();
}

} // namespace

BaselineResult
registerGoIcp(const ScanView& source,
              const ScanView& target,
              const GoIcpOptions& options,
              const std::optional<Eigen::Isometry3d>& guess,
              GoIcpReport* report_wanted)
{
  checkOptions(options);
  const Clock::time_point start = Clock::now();
  const Deadline deadline = Deadline::after(options.time_limit, options.time_limit_clock);
  const auto since_start = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  GoIcpReport unwanted;
  GoIcpReport& report = report_wanted != nullptr ? *report_wanted : unwanted;
  report = GoIcpReport();
  BaselineResult result;

  const auto most = static_cast<std::size_t>(options.source_points);
  const Sample sample = drawSample(source, most, options.threads);
  Points3 target_points = returnsOf(target);
  result.leaf = sample.leaf;
  result.source_points = static_cast<std::size_t>(sample.points.cols());
  result.target_points = static_cast<std::size_t>(target_points.cols());
  for (const bool is_source : {true, false}) {
    const Points3& points = is_source ? sample.points : target_points;
    const std::string name = is_source ? "source" : "target";
    if (points.cols() < kPosePoints) {
      result.message = "the " + name + " has fewer than 3 finite points";
      return result;
    }
    if (isLine(points)) {
      result.message = "the points of the " + name + " lie on a line: the rotation is not determined";
      return result;
    }
  }

  // Both about their centroids, thinned alike so that near walls do not draw them, and into [-1, 1]^3.
  const Eigen::Vector3d source_centre = sample.points.rowwise().mean();
  const Eigen::Vector3d target_centre = drawSample(target, most, options.threads).points.rowwise().mean();
  Points3 source_points(3, sample.points.cols());
  const std::vector<Eigen::Index> order = spreadOrder(sample.points.cols());
  for (std::size_t i = 0; i < order.size(); ++i)
    source_points.col(static_cast<Eigen::Index>(i)) = sample.points.col(order[i]) - source_centre;
  target_points.colwise() -= target_centre;
  const double scale = std::max(source_points.cwiseAbs().maxCoeff(), target_points.cwiseAbs().maxCoeff());
  if (!(scale > 0 && std::isfinite(scale))) {
    result.message = "the clouds have no extent that can be computed with";
    return result;
  }
  source_points /= scale;
  target_points /= scale;

  const double before_transform = since_start();
  const GoIcpProblem problem(
      source_points, target_points, options.trim_fraction, options.transform_size, options.threads);
  report.transform_seconds = since_start() - before_transform;

  GoIcpLimits limits;
  const auto kept = static_cast<double>(problem.kept());
  limits.tolerance = options.mse_threshold * kept;
  limits.translation_range = options.translation_range;
  limits.icp_iterations = options.icp_iterations > 0 ? options.icp_iterations : kIcpSteps;
  limits.nodes = options.node_limit;
  limits.deadline = deadline;
  std::vector<Eigen::Isometry3d> starts;
  if (guess) {
    Eigen::Isometry3d normalised = *guess;
    normalised.translation() = (guess->translation() + guess->linear() * source_centre - target_centre) / scale;
    starts.push_back(normalised);
  }
  const GoIcpOptimum optimum = branchAndBound(problem, starts, limits, options.threads);

  result.T_target_source.linear() = optimum.T.linear();
  result.T_target_source.translation() =
      target_centre + scale * optimum.T.translation() - optimum.T.linear() * source_centre;
  const double to_metres = scale * scale / kept;
  report.error = optimum.error * to_metres;
  report.gap = (optimum.error - optimum.lower) * to_metres;
  report.tolerance = options.mse_threshold * scale * scale;
  report.scale = scale;
  report.kept = static_cast<std::size_t>(problem.kept());
  report.nodes = optimum.nodes;
  report.rotations = optimum.rotations;
  report.icp_runs = optimum.icp_runs;
  report.certified = optimum.stop == GoIcpOptimum::Stop::Certified;

  result.converged = report.certified;
  result.iterations = static_cast<int>(
      std::min<std::uint64_t>(optimum.nodes, static_cast<std::uint64_t>(std::numeric_limits<int>::max())));
  result.inlier_distance = options.inlier_distance > 0 ? options.inlier_distance
                                                       : std::max(sample.leaf, kInlierPerRms * std::sqrt(report.error));
  result.inliers = problem.countWithin(optimum.T, result.inlier_distance / scale);
  result.overlap = static_cast<double>(result.inliers) / static_cast<double>(result.source_points);
  std::ostringstream text;
  if (optimum.stop == GoIcpOptimum::Stop::Certified)
    text << "global optimum: ";
  else if (optimum.stop == GoIcpOptimum::Stop::TimeLimit)
    text << "cut off by the time limit of " << shortNumber(options.time_limit)
         << (options.time_limit_clock == TimeLimitClock::Processor ? " s of processor time: " : " s: ");
  else
    text << "cut off by the limit of " << options.node_limit << " nodes: ";
  text << describeGap(report);
  result.message = text.str();
  report.seconds = since_start();
  return result;
}

} // namespace pcl_ssfr::baselines
