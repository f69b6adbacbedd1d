// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/pair_input.h>

#include "preparation/thinning.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <apps/common/random_stream.h>
#include <apps/io/transform_file.h>
#include <apps/pairs/measures.h>
#include <apps/pairs/pair_truth.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

/// Streams of random numbers of a pair, one per purpose: a change of one leaves the others alone.
enum Stream : std::uint64_t {
  kMotionStream = 1,
  kNoiseStream,
  kOutlierStream,
  kCutStream,
  kDegradationStream,
  kOriginStream
};

/// Replace a scan by one averaged point per voxel.
void
thin(io::LoadedCloud& cloud, double leaf)
{
  const ScanView view = viewOf(cloud);
  const ThinnedCloud thinned = thinScan(view, leaf, measureExtent(view).median);
  auto points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>();
  points->resize(static_cast<std::size_t>(thinned.size()));
  for (Eigen::Index i = 0; i < thinned.size(); ++i) {
    auto& point = (*points)[static_cast<std::size_t>(i)];
    point.getVector3fMap() = (thinned.points.col(i).cast<double>() + thinned.origin).cast<float>();
    if (thinned.normals.cols() > 0)
      point.getNormalVector3fMap() = thinned.normals.col(i).normalized();
  }
  cloud.points = points;
  cloud.has_intensity = false; // not averaged
}

void
addNoise(io::LoadedCloud& cloud, double sigma, RandomStream random)
{
  for (auto& point : *cloud.points)
    for (float* coordinate : {&point.x, &point.y, &point.z})
      *coordinate += static_cast<float>(sigma * random.gaussian());
}

void
addOutliers(io::LoadedCloud& cloud, double share, RandomStream random)
{
  const ScanExtent extent = measureExtent(viewOf(cloud));
  for (auto& point : *cloud.points) {
    if (random.uniform() >= share)
      continue;
    for (int axis = 0; axis < 3; ++axis)
      point.data[axis] = static_cast<float>(random.uniform(extent.min[axis], extent.max[axis]));
    if (cloud.has_normals)
      point.getNormalVector3fMap() = random.rotation().col(2).cast<float>();
  }
}

/// Keep the side of a random plane on which the wanted share of the source still has counterparts.
void
cutTarget(PairInput& pair, double overlap, RandomStream random)
{
  const Correspondences at_truth = correspondencesAtTruth(pair);
  const Eigen::Vector3d direction = random.rotation().col(0);
  std::vector<double> places;
  for (Eigen::Index i = 0; i < at_truth.target.cols(); ++i)
    places.push_back(direction.dot(at_truth.target.col(i)));
  const auto wanted = static_cast<std::size_t>(overlap * static_cast<double>(at_truth.samples));
  if (wanted >= places.size())
    return; // the scans overlap less than that as they are
  std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(wanted), places.end());
  const double limit = places[wanted];
  auto kept = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>();
  for (const auto& point : *pair.target.points)
    if (direction.dot(point.getVector3fMap().cast<double>()) < limit)
      kept->push_back(point);
  pair.target.points = kept;
}

/// Move the points of a cloud, and their normals.
void
movePoints(io::LoadedCloud& cloud, const Eigen::Isometry3d& motion)
{
  for (auto& point : *cloud.points) {
    point.getVector3fMap() = (motion * point.getVector3fMap().cast<double>()).cast<float>();
    if (cloud.has_normals)
      point.getNormalVector3fMap() = (motion.linear() * point.getNormalVector3fMap().cast<double>()).cast<float>();
  }
}

/// Move the source by a rigid motion of its points about the origin of its cloud; sensor and truth follow.
void
move(PairInput& pair, Perturbation perturbation, RandomStream random)
{
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = random.rotation();
  if (perturbation == Perturbation::Se3) {
    const Eigen::Vector3d direction = random.rotation().col(0);
    motion.translation() = random.uniform() * measureExtent(viewOf(pair.source)).radius * direction;
  }
  movePoints(pair.source, motion);
  const Eigen::Isometry3d in_file =
      Eigen::Translation3d(pair.source.offset) * motion * Eigen::Translation3d(-pair.source.offset);
  if (pair.T_target_source)
    pair.T_target_source = *pair.T_target_source * in_file.inverse();
  const bool sensor_moves = pair.source.viewpoint || perturbation == Perturbation::Se3;
  if (sensor_moves)
    pair.source.viewpoint = in_file * pair.source.viewpoint.value_or(Eigen::Vector3d::Zero());
  pair.reference = in_file * pair.reference;
}

/// Lay another scan into the target. What only one of the two has, normals or intensity, is dropped.
void
merge(io::LoadedCloud& target, const PosedScan& other)
{
  io::LoadedCloud scan = io::loadCloud(other.path);
  movePoints(scan, Eigen::Translation3d(-target.offset) * other.T_target_scan * Eigen::Translation3d(scan.offset));
  auto points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>(*target.points);
  *points += *scan.points;
  target.points = points;
  target.has_normals = target.has_normals && scan.has_normals;
  target.has_intensity = target.has_intensity && scan.has_intensity;
}

/// Mirror the source as a file with left-handed coordinates is: y changes its sign. No pose is right any more.
void
mirror(PairInput& pair)
{
  for (auto& point : *pair.source.points) {
    point.y = -point.y;
    point.normal_y = -point.normal_y;
  }
  pair.source.offset.y() = -pair.source.offset.y();
  pair.reference.y() = -pair.reference.y();
  if (pair.source.viewpoint)
    pair.source.viewpoint->y() = -pair.source.viewpoint->y();
  pair.T_target_source.reset();
}

/// Move the origins of both frames away from the sensors, each in a random direction, without a word about it.
void
moveOrigins(PairInput& pair, double distance, RandomStream random)
{
  const auto moveOrigin = [&](io::LoadedCloud& cloud) {
    Eigen::Isometry3d motion(Eigen::Translation3d(distance * random.rotation().col(0)));
    if (distance > io::kLargeCoordinate) // as when such coordinates are read: the points keep their digits
      cloud.offset += motion.translation();
    else
      movePoints(cloud, motion);
    cloud.viewpoint.reset();
    return motion;
  };
  const Eigen::Isometry3d source_motion = moveOrigin(pair.source);
  const Eigen::Isometry3d target_motion = moveOrigin(pair.target);
  if (pair.T_target_source)
    pair.T_target_source = target_motion * *pair.T_target_source * source_motion.inverse();
  pair.reference = source_motion * pair.reference;
}

} // namespace

std::uint64_t
pairSeed(std::uint64_t seed, const std::string& dataset, const std::string& source, const std::string& target)
{
  std::uint64_t hash = 1469598103934665603ULL; // FNV-1a
  for (const std::string* text : {&dataset, &source, &target}) {
    for (const char c : *text + '\n')
      hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  }
  return RandomStream(seed, hash).next() >> 11; // what a double holds: R and pandas read it
}

PairInput
loadPair(const PairRequest& request)
{
  PairInput pair;
  pair.source = io::loadCloud(request.source);
  pair.target = io::loadCloud(request.target);
  pair.source.table = {}; // memory that no method needs
  pair.target.table = {};
  pair.T_target_source = request.T_target_source;
  pair.reference = pair.source.viewpoint.value_or(pair.source.offset);
  const Variation& variation = request.variation;
  if (request.merged)
    merge(pair.target, *request.merged);
  if (!variation.degradation.keepsAll())
    pair.source.points = degraded(*pair.source.points,
                                  variation.degradation,
                                  RandomStream(request.seed, kDegradationStream).next(),
                                  (pair.reference - pair.source.offset).cast<float>());
  if (variation.resolution_m > 0) {
    thin(pair.source, variation.resolution_m);
    thin(pair.target, variation.resolution_m);
  }
  if (variation.noise_m > 0)
    addNoise(pair.source, variation.noise_m, RandomStream(request.seed, kNoiseStream));
  if (variation.outliers > 0)
    addOutliers(pair.source, variation.outliers, RandomStream(request.seed, kOutlierStream));
  if (variation.overlap > 0)
    cutTarget(pair, variation.overlap, RandomStream(request.seed, kCutStream));
  if (variation.mirror_source)
    mirror(pair);
  if (variation.perturbation != Perturbation::None)
    move(pair, variation.perturbation, RandomStream(request.seed, kMotionStream));
  if (variation.origin_offset_m > 0)
    moveOrigins(pair, variation.origin_offset_m, RandomStream(request.seed, kOriginStream));
  return pair;
}

Eigen::Isometry3d
poseFromJson(const Json& json)
{
  std::vector<double> values;
  const auto add = [&values](const Json& number) {
    if (!number.is_number())
      throw std::invalid_argument("holds " + io::inQuotes(number.dump()) + ", which is not a number");
    values.push_back(number.get<double>());
  };
  if (!json.is_array())
    throw std::invalid_argument("is not an array");
  for (const Json& entry : json) {
    if (entry.is_array())
      for (const Json& number : entry)
        add(number);
    else
      add(entry);
  }
  if (values.size() != 16)
    throw std::invalid_argument("has " + std::to_string(values.size()) + " numbers, not 16");
  return io::toRigidMotion(Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(values.data()));
}

Json
toJson(const PairRequest& request)
{
  Json json;
  json["source"] = request.source;
  json["target"] = request.target;
  json["T_target_source"] = request.T_target_source ? matrixJson(*request.T_target_source) : Json(nullptr);
  json["merged"] = nullptr;
  if (request.merged)
    json["merged"] = {{"path", request.merged->path}, {"T_target_scan", matrixJson(request.merged->T_target_scan)}};
  json["sensor_at_origin"] = request.sensor_at_origin;
  json["variation"] = toJson(request.variation);
  json["seed"] = request.seed;
  return json;
}

PairRequest
pairRequestFromJson(const Json& json)
{
  PairRequest request;
  request.source = json.at("source").get<std::string>();
  request.target = json.at("target").get<std::string>();
  if (!json.at("T_target_source").is_null())
    request.T_target_source = poseFromJson(json.at("T_target_source"));
  if (!json.at("merged").is_null())
    request.merged =
        PosedScan{json.at("merged").at("path").get<std::string>(), poseFromJson(json.at("merged").at("T_target_scan"))};
  request.sensor_at_origin = json.at("sensor_at_origin").get<bool>();
  request.variation = variationFromJson(json.at("variation"));
  request.seed = json.at("seed").get<std::uint64_t>();
  return request;
}

} // namespace apps
} // namespace pcl_ssfr
