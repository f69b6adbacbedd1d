// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods.h>

#include <pcl_ssfr/neighbor_index.h>
#include <pcl_ssfr/overlap.h>
#include <pcl_ssfr/pipeline.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/search/kdtree.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

using Point = pcl::PointXYZINormal;
using Cloud = pcl::PointCloud<Point>;
using Registration = pcl::Registration<Point, Point, float>;

// Settings of PCL's refiners, the same for all scenes as their users would have them.
constexpr int kNormalNeighbours = 20;
constexpr int kMinPoints = 2 * kNormalNeighbours; ///< fewer make GICP and the normals fail
constexpr int kMaxIterations = 50;
constexpr double kCorrespondenceDistance = 1;   ///< [m]
constexpr double kPolishDistance = 0.15;        ///< the same when the start is good already [m]
constexpr double kTransformationEpsilon = 1e-8; ///< squared translation [m^2]
constexpr float kNdtResolution = 1;             ///< [m]
constexpr double kNdtStep = 0.1;                ///< [m]
constexpr double kOverlapRadius = 0.2;          ///< of the overlap that is reported for methods that measure none [m]

double
secondsSince(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

ScanView
viewOf(const io::LoadedCloud& cloud)
{
  ScanView view;
  view.size = cloud.points->size();
  view.stride = sizeof(Point) / sizeof(float);
  if (view.size > 0) {
    view.xyz = cloud.points->front().data;
    view.normals = cloud.has_normals ? cloud.points->front().data_n : nullptr;
  }
  view.viewpoint = cloud.viewpoint.value_or(Eigen::Vector3d::Zero()) - cloud.offset;
  return view;
}

/// A pose between offset clouds from a pose between files, and back.
class Frames {
public:
  Frames(const io::LoadedCloud& source, const io::LoadedCloud& target) : source_(source.offset), target_(target.offset)
  {}

  Eigen::Isometry3d
  toClouds(const Eigen::Isometry3d& T_files) const
  {
    return Eigen::Translation3d(-target_) * T_files * Eigen::Translation3d(source_);
  }

  Eigen::Isometry3d
  toFiles(const Eigen::Isometry3d& T_clouds) const
  {
    return Eigen::Translation3d(target_) * T_clouds * Eigen::Translation3d(-source_);
  }

  /// All poses of a result, and its information matrix, which is about the origin of the target.
  Result
  toFiles(Result result) const
  {
    result.T_target_source = toFiles(result.T_target_source);
    for (Candidate& candidate : result.candidates)
      candidate.T_target_source = toFiles(candidate.T_target_source);
    // A motion (w, v) about the file's origin is (w, v + w x offset) about the offset.
    Eigen::Matrix<double, 6, 6> shift = Eigen::Matrix<double, 6, 6>::Identity();
    shift.bottomLeftCorner<3, 3>() << 0, target_.z(), -target_.y(), -target_.z(), 0, target_.x(), target_.y(),
        -target_.x(), 0;
    result.information = shift.transpose() * result.information * shift;
    return result;
  }

private:
  Eigen::Vector3d source_;
  Eigen::Vector3d target_;
};

Result
runSsfr(const io::LoadedCloud& source,
        const io::LoadedCloud& target,
        const Options& options,
        const std::optional<Eigen::Isometry3d>& guess)
{
  const Frames frames(source, target);
  std::optional<Eigen::Isometry3d> cloud_guess;
  if (guess)
    cloud_guess = frames.toClouds(*guess);
  const auto start = std::chrono::steady_clock::now();
  const PreparedScan prepared_source = prepareScan(viewOf(source), options);
  const PreparedScan prepared_target = prepareScan(viewOf(target), options);
  const Options rest = afterSpending(options, secondsSince(start));
  return frames.toFiles(registerScans(prepared_source, prepared_target, rest, cloud_guess ? &*cloud_guess : nullptr));
}

/// The finite points, thinned when the options say to what.
Cloud::Ptr
finitePoints(const io::LoadedCloud& cloud, const Options& options)
{
  auto result = pcl::make_shared<Cloud>();
  for (const Point& point : *cloud.points)
    if (point.getVector3fMap().allFinite())
      result->push_back(point);
  if (options.leaf > 0 && !result->empty()) {
    pcl::VoxelGrid<Point> grid;
    const auto leaf = static_cast<float>(options.leaf);
    grid.setLeafSize(leaf, leaf, leaf);
    grid.setInputCloud(result);
    auto thinned = pcl::make_shared<Cloud>();
    grid.filter(*thinned);
    return thinned;
  }
  return result;
}

/// Normals by PCL where the file gave none; points without a normal are dropped.
Cloud::Ptr
withNormals(const Cloud::Ptr& cloud, bool has_normals, const Options& options)
{
  if (!has_normals) {
    pcl::NormalEstimationOMP<Point, Point> estimation(options.threads);
    estimation.setInputCloud(cloud);
    estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<Point>>());
    if (options.normal_radius > 0)
      estimation.setRadiusSearch(options.normal_radius);
    else
      estimation.setKSearch(kNormalNeighbours);
    Cloud normals;
    estimation.compute(normals);
    for (std::size_t i = 0; i < cloud->size(); ++i)
      (*cloud)[i].getNormalVector3fMap() = normals[i].getNormalVector3fMap();
  }
  auto result = pcl::make_shared<Cloud>();
  for (const Point& point : *cloud)
    if (std::abs(point.getNormalVector3fMap().norm() - 1) < 0.1F)
      result->push_back(point);
  return result;
}

bool
needsNormals(const std::string& name)
{
  return name == "icp_point_to_plane";
}

/// A refiner of PCL by its name.
Registration::Ptr
makeRefiner(const std::string& name, const Options& options)
{
  Registration::Ptr refiner;
  if (name == "icp_point_to_point") {
    refiner = pcl::make_shared<pcl::IterativeClosestPoint<Point, Point>>();
  }
  else if (name == "icp_point_to_plane") {
    refiner = pcl::make_shared<pcl::IterativeClosestPointWithNormals<Point, Point>>();
  }
  else if (name == "gicp") {
    refiner = pcl::make_shared<pcl::GeneralizedIterativeClosestPoint<Point, Point>>();
  }
  else {
    auto ndt = pcl::make_shared<pcl::NormalDistributionsTransform<Point, Point>>();
    ndt->setResolution(kNdtResolution);
    ndt->setStepSize(kNdtStep);
    ndt->setTransformationEpsilon(kTransformationEpsilon);
    ndt->setMaximumIterations(kMaxIterations);
    return ndt;
  }
  refiner->setMaximumIterations(kMaxIterations);
  refiner->setTransformationEpsilon(kTransformationEpsilon);
  refiner->setMaxCorrespondenceDistance(options.overlap_radius > 0 ? options.overlap_radius : kCorrespondenceDistance);
  return refiner;
}

Points3
pointsOf(const Cloud& cloud)
{
  Points3 points(3, static_cast<Eigen::Index>(cloud.size()));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = cloud[i].getVector3fMap().cast<double>();
  return points;
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

/// One of PCL's refiners from a start in file coordinates.
Result
runRefiner(const std::string& name,
           const io::LoadedCloud& source,
           const io::LoadedCloud& target,
           const Options& options,
           const Eigen::Isometry3d& start)
{
  const Frames frames(source, target);
  Result result;
  const auto stage = [&result](const char* stage_name, auto clock, std::size_t in, std::size_t out) {
    result.stages.push_back({stage_name, secondsSince(clock), in, out});
  };
  auto clock = std::chrono::steady_clock::now();
  Cloud::Ptr source_points = finitePoints(source, options);
  Cloud::Ptr target_points = finitePoints(target, options);
  const std::size_t given = source.points->size() + target.points->size();
  stage("thinning", clock, given, source_points->size() + target_points->size());
  const auto too_few = [&] { return source_points->size() < kMinPoints || target_points->size() < kMinPoints; };
  if (!too_few() && needsNormals(name)) {
    clock = std::chrono::steady_clock::now();
    const std::size_t before = source_points->size() + target_points->size();
    source_points = withNormals(source_points, source.has_normals, options);
    target_points = withNormals(target_points, target.has_normals, options);
    stage("normals", clock, before, source_points->size() + target_points->size());
  }
  if (too_few()) {
    result.status = Status::TooFewPoints;
    result.message = "too few usable points: " + std::to_string(source_points->size()) + " in the source, " +
                     std::to_string(target_points->size()) + " in the target, at least " + std::to_string(kMinPoints) +
                     " are needed";
    return result;
  }
  clock = std::chrono::steady_clock::now();
  const Registration::Ptr refiner = makeRefiner(name, options);
  refiner->setInputSource(source_points);
  refiner->setInputTarget(target_points);
  Cloud moved;
  refiner->align(moved, frames.toClouds(start).matrix().cast<float>());
  stage(name.c_str(), clock, source_points->size(), source_points->size());

  result.T_target_source = toIsometry(refiner->getFinalTransformation());
  const bool finite = result.T_target_source.matrix().allFinite();
  if (!finite)
    result.T_target_source = frames.toClouds(start);
  result.status = refiner->hasConverged() && finite ? Status::Converged : Status::NoCandidate;
  result.message = result.accepted() ? "PCL's iteration stopped; that alone does not mean that the pose is right"
                                     : "PCL's iteration did not converge";
  const Overlap overlap = computeOverlap(pointsOf(*source_points),
                                         NeighborIndex(pointsOf(*target_points)),
                                         result.T_target_source,
                                         options.overlap_radius > 0 ? options.overlap_radius : kOverlapRadius,
                                         options.threads);
  result.overlap = overlap.ratio;
  result.rmse = overlap.rmse;
  Candidate candidate;
  candidate.T_target_source = result.T_target_source;
  candidate.score = overlap.ratio;
  candidate.overlap = overlap.ratio;
  result.candidates.push_back(candidate);
  return frames.toFiles(result);
}

/// ssfr first, then PCL's ICP from its answer; the judgement stays that of ssfr.
Result
runSsfrIcp(const io::LoadedCloud& source,
           const io::LoadedCloud& target,
           const Options& options,
           const std::optional<Eigen::Isometry3d>& guess)
{
  Result result = runSsfr(source, target, options, guess);
  if (!result.accepted())
    return result;
  Options polish = options;
  if (polish.overlap_radius <= 0)
    polish.overlap_radius = kPolishDistance;
  const Result refined = runRefiner("icp_point_to_plane", source, target, polish, result.T_target_source);
  result.stages.insert(result.stages.end(), refined.stages.begin(), refined.stages.end());
  if (!refined.accepted()) {
    result.message += "; PCL's ICP did not converge from there, the pose is that of ssfr";
    return result;
  }
  result.T_target_source = refined.T_target_source;
  result.rmse = refined.rmse;
  if (!result.candidates.empty())
    result.candidates.front().T_target_source = refined.T_target_source;
  return result;
}

} // namespace

const std::vector<Method>&
methods()
{
  static const std::vector<Method> kMethods{
      {"ssfr", "planes, 1-D correlations, visibility scoring, polish; no guess needed"},
      {"ssfr_paper2017", "the method as published in 2017"},
      {"ssfr_icp", "ssfr, then PCL's point-to-plane ICP from its answer"},
      {"icp_point_to_point", "PCL's ICP from the guess or the identity"},
      {"icp_point_to_plane", "PCL's point-to-plane ICP from the guess or the identity"},
      {"gicp", "PCL's generalised ICP from the guess or the identity"},
      {"ndt", "PCL's normal distributions transform from the guess or the identity"}};
  return kMethods;
}

const Method*
findMethod(const std::string& name)
{
  for (const Method& method : methods())
    if (method.name == name)
      return &method;
  return nullptr;
}

MethodRun
runMethod(const std::string& name,
          const io::LoadedCloud& source,
          const io::LoadedCloud& target,
          const Options& options,
          const std::optional<Eigen::Isometry3d>& guess)
{
  if (!findMethod(name))
    throw std::invalid_argument("unknown method '" + name + "'");
  MethodRun run;
  const auto start = std::chrono::steady_clock::now();
  if (name == "ssfr" || name == "ssfr_paper2017") {
    run.result = runSsfr(source, target, options, guess);
  }
  else if (name == "ssfr_icp") {
    run.result = runSsfrIcp(source, target, options, guess);
  }
  else {
    run.result = runRefiner(name, source, target, options, guess.value_or(Eigen::Isometry3d::Identity()));
    run.judged = false;
  }
  run.seconds = secondsSince(start);
  return run;
}

} // namespace apps
} // namespace pcl_ssfr
