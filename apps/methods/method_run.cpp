// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/method_run.h>

#include "judgement/overlap.h"
#include "judgement/scored_pose.h"
#include "preparation/thinning.h"

#include <pcl_ssfr/detail/neighbor_index.h>
#include <pcl_ssfr/pipeline.h>
#include <pcl_ssfr/scan_view.h>

#include <apps/common/seconds_since.h>
#include <apps/methods/cloud_view.h>
#include <apps/methods/comparison_methods.h>
#include <apps/methods/file_frames.h>
#include <apps/methods/planar_points.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

namespace {

using Point = MethodPoint;
using Cloud = MethodCloud;

constexpr std::size_t kMinPoints = 40; ///< fewer make GICP and the normals fail
constexpr float kUnitTolerance = 0.1F; ///< of the length of a usable normal

/// What ssfr found, in file coordinates, and what it takes to score other poses.
struct SsfrRun {
  Result result;
  PreparedScan source;
  PreparedScan target;
  FileFrames frames;
};

SsfrRun
runSsfr(const io::LoadedCloud& source,
        const io::LoadedCloud& target,
        const Options& options,
        const std::optional<Eigen::Isometry3d>& guess)
{
  const FileFrames frames(source.offset, target.offset);
  std::optional<Eigen::Isometry3d> cloud_guess;
  if (guess)
    cloud_guess = frames.toClouds(*guess);
  const Deadline deadline = Deadline::after(options.time_limit);
  auto [prepared_source, prepared_target] = prepareScans(viewOf(source), viewOf(target), options, deadline);
  const Result result =
      registerScans(prepared_source, prepared_target, options, cloud_guess ? &*cloud_guess : nullptr, deadline);
  return {frames.toFiles(result), std::move(prepared_source), std::move(prepared_target), frames};
}

/// The evidence that ssfr has for a pose in file coordinates.
Candidate
scored(const SsfrRun& ssfr, const Options& options, const Eigen::Isometry3d& T_files)
{
  Candidate candidate = scorePose(ssfr.source, ssfr.target, options, ssfr.frames.toClouds(T_files));
  candidate.T_target_source = T_files;
  return candidate;
}

/// A thinned scan as a cloud about its origin, with unit normals where the file had some.
Cloud::Ptr
toCloud(const ThinnedCloud& thinned)
{
  auto cloud = pcl::make_shared<Cloud>();
  cloud->resize(static_cast<std::size_t>(thinned.size()));
  for (Eigen::Index i = 0; i < thinned.size(); ++i) {
    Point& point = (*cloud)[static_cast<std::size_t>(i)];
    point.getVector3fMap() = thinned.points.col(i);
    if (thinned.normals.cols() > 0)
      point.getNormalVector3fMap() = thinned.normals.col(i).normalized();
  }
  return cloud;
}

/// The points that have a normal, by PCL where the file gave none.
Cloud::Ptr
withNormals(const Cloud::Ptr& cloud, bool has_normals, const Eigen::Vector3d& sensor, double radius, unsigned threads)
{
  if (!has_normals)
    comparisonMethods().addNormals(cloud, sensor, radius, threads);
  auto result = pcl::make_shared<Cloud>();
  for (const Point& point : *cloud)
    if (std::abs(point.getNormalVector3fMap().norm() - 1) < kUnitTolerance)
      result->push_back(point);
  return result;
}

/// A pose of float precision made a proper rotation again.
Eigen::Isometry3d
toIsometry(const Eigen::Matrix4f& matrix)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(matrix.topLeftCorner<3, 3>().cast<double>()).normalized().toRotationMatrix();
  T.translation() = matrix.topRightCorner<3, 1>().cast<double>();
  return T;
}

/// A place within a scan, in file coordinates [m]: its sensor where that is known, else the middle of its points.
Eigen::Vector3d
placeIn(const io::LoadedCloud& cloud, bool knows_sensor, const Eigen::Vector3d& sensor)
{
  if (knows_sensor)
    return sensor;
  return cloud.offset + measureExtent(viewOf(cloud)).median;
}

/// The scans of a method of PCL, and where they lie.
struct PreparedPair {
  MethodInput input;
  Eigen::Vector3d source_origin; ///< of the cloud, in the coordinates of LoadedCloud::points [m]
  Eigen::Vector3d target_origin;
};

/// Thin both scans by the rule and give them normals where the method needs them: after ssfr, those of planes, which
/// face the sensors that it found.
PreparedPair
preparePair(const Method& method,
            const io::LoadedCloud& source,
            const io::LoadedCloud& target,
            const Options& options,
            const MethodSettings& settings,
            const Result* ssfr,
            Result& result)
{
  PreparedPair pair;
  MethodInput& input = pair.input;
  input.threads = threadCount(options);
  input.seed = settings.seed;
  input.rule = settings.rule;
  if (options.leaf > 0)
    input.rule.leaf = options.leaf;
  if (options.time_limit > 0)
    input.rule.max_seconds = options.time_limit;
  auto clock = std::chrono::steady_clock::now();
  const ScanView source_view = viewOf(source);
  const ScanView target_view = viewOf(target);
  const double suggested = !ssfr                        ? 0
                           : options.overlap_radius > 0 ? options.overlap_radius
                                                        : ssfr->correspondence_distance;
  const ThinnedPair thinned =
      thinPair(source_view, target_view, input.rule, input.threads, suggested / input.rule.polish_distance);
  input.scales = scalesOf(thinned.source.leaf, input.rule);
  if (options.normal_radius > 0)
    input.scales.normal_radius = options.normal_radius;
  input.correspondence_distance = options.overlap_radius > 0 ? options.overlap_radius
                                  : ssfr ? std::max(suggested, input.scales.leaf * input.rule.polish_distance)
                                         : input.scales.refine_distance;
  pair.source_origin = thinned.source.origin;
  pair.target_origin = thinned.target.origin;
  input.source = toCloud(thinned.source);
  input.target = toCloud(thinned.target);
  const auto size = [&input] { return input.source->size() + input.target->size(); };
  result.stages.push_back({"thinning", secondsSince(clock), source_view.size + target_view.size, size()});
  if (ssfr) {
    clock = std::chrono::steady_clock::now();
    const std::size_t before = size();
    const double radius =
        std::max(input.scales.normal_radius, input.rule.polish_normals * input.correspondence_distance);
    const double thickness =
        input.correspondence_distance / options.patch_profile.judgement.uncertainty.bound_deviations;
    const auto keep = [&](Cloud::Ptr& cloud, const Eigen::Vector3d& sensor) {
      cloud = planarPoints(*cloud, sensor, radius, thickness, input.threads);
    };
    const Eigen::Vector3d source_sensor = placeIn(source, ssfr->source_viewpoint_used, ssfr->source_viewpoint);
    const Eigen::Vector3d target_sensor = placeIn(target, ssfr->target_viewpoint_used, ssfr->target_viewpoint);
    keep(input.source, source_sensor - source.offset - pair.source_origin);
    keep(input.target, target_sensor - target.offset - pair.target_origin);
    input.is_planar = true;
    result.stages.push_back({"planar points", secondsSince(clock), before, size()});
  }
  else if (method.needs_normals && std::min(input.source->size(), input.target->size()) >= kMinPoints) {
    clock = std::chrono::steady_clock::now();
    const std::size_t before = size();
    const auto add = [&](Cloud::Ptr& cloud, bool has_normals, const Eigen::Vector3d& sensor) {
      cloud = withNormals(cloud, has_normals, sensor, input.scales.normal_radius, input.threads);
    };
    add(input.source, source.has_normals, source_view.viewpoint - pair.source_origin);
    add(input.target, target.has_normals, target_view.viewpoint - pair.target_origin);
    result.stages.push_back({"normals", secondsSince(clock), before, size()});
  }
  return pair;
}

Points3
pointsOf(const Cloud& cloud)
{
  Points3 points(3, static_cast<Eigen::Index>(cloud.size()));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = cloud[i].getVector3fMap().cast<double>();
  return points;
}

/// What PCL's class found, in the coordinates of its clouds, with the overlap measured for all in the same way.
void
judge(MethodRegistration& registration, const MethodInput& input, const Eigen::Isometry3d& start, Result& result)
{
  result.T_target_source = toIsometry(registration.getFinalTransformation());
  const bool finite = result.T_target_source.matrix().allFinite();
  if (!finite)
    result.T_target_source = start;
  result.status = registration.hasConverged() && finite ? Status::Converged : Status::NoCandidate;
  result.message = result.accepted() ? "the method stopped; that alone does not mean that the pose is right"
                                     : "the method did not converge";
  if (const auto own = comparisonMethods().ownAnswerOf(registration)) {
    result.message = own->message;
    if (!result.accepted() && own->T_target_source.matrix().allFinite())
      result.T_target_source = own->T_target_source;
  }
  const Overlap overlap = computeOverlap(pointsOf(*input.source),
                                         NeighborIndex(pointsOf(*input.target)),
                                         result.T_target_source,
                                         input.scales.threshold,
                                         input.threads);
  result.overlap = overlap.ratio;
  result.rmse = overlap.rmse;
  Candidate candidate;
  candidate.T_target_source = result.T_target_source;
  candidate.score = overlap.ratio;
  candidate.overlap = overlap.ratio;
  result.candidates.push_back(candidate);
}

/// A method of PCL, from a start in file coordinates where it takes one. \param[out] seconds thinning to alignment [s]
Result
runPcl(const Method& method,
       const io::LoadedCloud& source,
       const io::LoadedCloud& target,
       const Options& options,
       const MethodSettings& settings,
       const Result* ssfr,
       const std::optional<Eigen::Isometry3d>& guess,
       double& seconds)
{
  const auto start = std::chrono::steady_clock::now();
  Result result;
  PreparedPair pair = preparePair(method, source, target, options, settings, ssfr, result);
  MethodInput& input = pair.input;
  if (std::min(input.source->size(), input.target->size()) < kMinPoints) {
    result.status = Status::TooFewPoints;
    result.message = "too few usable points: " + std::to_string(input.source->size()) + " in the source, " +
                     std::to_string(input.target->size()) + " in the target, at least " + std::to_string(kMinPoints) +
                     " are needed";
    seconds = secondsSince(start);
    return result;
  }
  const FileFrames frames(source.offset + pair.source_origin, target.offset + pair.target_origin);
  Eigen::Isometry3d cloud_start = Eigen::Isometry3d::Identity(); // a global method starts nowhere
  if (method.kind == MethodKind::Refiner)
    cloud_start = frames.toClouds(ssfr ? ssfr->T_target_source : guess.value_or(Eigen::Isometry3d::Identity()));
  auto clock = std::chrono::steady_clock::now();
  const std::size_t points = input.source->size() + input.target->size();
  const MethodRegistration::Ptr registration = comparisonMethods().make(method.name, input);
  result.stages.push_back({"features and input", secondsSince(clock), points, points});
  clock = std::chrono::steady_clock::now();
  Cloud moved;
  registration->align(moved, cloud_start.matrix().cast<float>());
  result.stages.push_back({method.name, secondsSince(clock), points, moved.size()});
  seconds = secondsSince(start);
  judge(*registration, input, cloud_start, result);
  if (ssfr)
    result.correspondence_distance = input.correspondence_distance;
  return frames.toFiles(result);
}

/// ssfr first, then a refiner of PCL from its answer, which is taken where it is no worse by the evidence of ssfr and
/// at the same place: its sensor moved no farther than correspondences reach. The judgement stays that of ssfr.
Result
runSsfrRefined(const Method& method,
               const io::LoadedCloud& source,
               const io::LoadedCloud& target,
               const Options& options,
               const MethodSettings& settings,
               const std::optional<Eigen::Isometry3d>& guess,
               double& seconds)
{
  const auto start = std::chrono::steady_clock::now();
  const SsfrRun ssfr = runSsfr(source, target, options, guess);
  Result result = ssfr.result;
  seconds = secondsSince(start);
  if (!result.accepted())
    return result;
  double refining = 0;
  const Method& refiner = *findMethod(method.refiner);
  const Result refined = runPcl(refiner, source, target, options, settings, &result, std::nullopt, refining);
  seconds += refining;
  result.stages.insert(result.stages.end(), refined.stages.begin(), refined.stages.end());
  if (!refined.accepted()) {
    result.message += "; " + method.refiner + " gave no pose (" + refined.message + "), the pose is that of ssfr";
    return result;
  }
  const auto clock = std::chrono::steady_clock::now();
  const Candidate ours = scored(ssfr, options, result.T_target_source);
  Candidate moved = scored(ssfr, options, refined.T_target_source);
  const double walked =
      translationBetween(refined.T_target_source, result.T_target_source, referencePoint(source, result));
  seconds += secondsSince(clock);
  if (!isNoWorse(moved, ours) || walked > refined.correspondence_distance) {
    result.message += "; " + method.refiner + " led to no better pose from there, the pose is that of ssfr";
    return result;
  }
  Candidate& best = result.candidates.front();
  moved.probability = best.probability;
  moved.from_guess = best.from_guess;
  best = moved;
  result.T_target_source = best.T_target_source;
  result.overlap = best.overlap;
  result.contradiction = best.contradiction;
  result.rmse = best.rmse;
  return result;
}

} // namespace

MethodRun
runMethod(const std::string& name,
          const io::LoadedCloud& source,
          const io::LoadedCloud& target,
          const Options& options,
          const std::optional<Eigen::Isometry3d>& guess,
          const MethodSettings& settings)
{
  const Method* method = findMethod(name);
  if (!method)
    throw std::invalid_argument("method '" + name + "' " + describeUnknown());
  loadModuleOf(*method);
  MethodRun run;
  if (method->kind == MethodKind::Ssfr) {
    const auto start = std::chrono::steady_clock::now();
    run.result = runSsfr(source, target, options, guess).result;
    run.seconds = secondsSince(start);
    run.judged = options.profile != Profile::Paper2017;
  }
  else if (method->kind == MethodKind::SsfrRefined) {
    run.result = runSsfrRefined(*method, source, target, options, settings, guess, run.seconds);
  }
  else {
    run.result = runPcl(*method, source, target, options, settings, nullptr, guess, run.seconds);
    run.judged = false;
  }
  return run;
}

Eigen::Vector3d
referencePoint(const io::LoadedCloud& source, const Result& result)
{
  return placeIn(source, result.source_viewpoint_used, result.source_viewpoint);
}

FoundSensors::FoundSensors(const Result& result)
{
  if (result.source_viewpoint_found)
    source = result.source_viewpoint;
  if (result.target_viewpoint_found)
    target = result.target_viewpoint;
}

} // namespace apps
} // namespace pcl_ssfr
