// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/pair_input.h>

#include "preparation/neighbor_index.h"
#include "preparation/thinning.h"

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

/// Streams of random numbers of a pair, one a purpose: a change of one leaves the others alone.
enum Stream : std::uint64_t { kMotionStream = 1, kNoiseStream, kOutlierStream, kCutStream };

/// Replace a scan by one averaged point a voxel.
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
  for (auto& point : *pair.source.points) {
    point.getVector3fMap() = (motion * point.getVector3fMap().cast<double>()).cast<float>();
    if (pair.source.has_normals)
      point.getNormalVector3fMap() = (motion.linear() * point.getNormalVector3fMap().cast<double>()).cast<float>();
  }
  const Eigen::Isometry3d in_file =
      Eigen::Translation3d(pair.source.offset) * motion * Eigen::Translation3d(-pair.source.offset);
  pair.T_target_source = pair.T_target_source * in_file.inverse();
  const bool sensor_moves = pair.source.viewpoint || perturbation == Perturbation::Se3;
  if (sensor_moves)
    pair.source.viewpoint = in_file * pair.source.viewpoint.value_or(Eigen::Vector3d::Zero());
  pair.reference = in_file * pair.reference;
}

} // namespace

const char*
toString(Perturbation perturbation)
{
  switch (perturbation) {
  case Perturbation::None:
    return "none";
  case Perturbation::Rotation:
    return "rotation";
  case Perturbation::Se3:
    return "se3";
  }
  return "none";
}

Perturbation
parsePerturbation(const std::string& text)
{
  for (const Perturbation p : {Perturbation::None, Perturbation::Rotation, Perturbation::Se3})
    if (text == toString(p))
      return p;
  throw std::invalid_argument(io::inQuotes(text) + " is not none, rotation or se3");
}

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
  if (variation.perturbation != Perturbation::None)
    move(pair, variation.perturbation, RandomStream(request.seed, kMotionStream));
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
  const Variation& variation = request.variation;
  Json json;
  json["source"] = request.source;
  json["target"] = request.target;
  json["T_target_source"] = matrixJson(request.T_target_source);
  json["sensor_at_origin"] = request.sensor_at_origin;
  json["resolution_m"] = variation.resolution_m;
  json["noise_m"] = variation.noise_m;
  json["outliers"] = variation.outliers;
  json["overlap"] = variation.overlap;
  json["perturb"] = toString(variation.perturbation);
  json["seed"] = request.seed;
  return json;
}

PairRequest
pairRequestFromJson(const Json& json)
{
  PairRequest request;
  request.source = json.at("source").get<std::string>();
  request.target = json.at("target").get<std::string>();
  request.T_target_source = poseFromJson(json.at("T_target_source"));
  request.sensor_at_origin = json.at("sensor_at_origin").get<bool>();
  request.variation.resolution_m = json.at("resolution_m").get<double>();
  request.variation.noise_m = json.at("noise_m").get<double>();
  request.variation.outliers = json.at("outliers").get<double>();
  request.variation.overlap = json.at("overlap").get<double>();
  request.variation.perturbation = parsePerturbation(json.at("perturb").get<std::string>());
  request.seed = json.at("seed").get<std::uint64_t>();
  return request;
}

} // namespace apps
} // namespace pcl_ssfr
