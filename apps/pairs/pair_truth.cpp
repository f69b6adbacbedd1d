// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/pair_truth.h>

#include "common/types.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <apps/common/json_values.h>
#include <apps/methods/method_parameters.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxAsked = 20000;     ///< points of the source
constexpr std::size_t kMaxIndexed = 2000000; ///< points of the target
constexpr double kRadiusLeafs = 2;           ///< of a correspondence [leafs]

/// At most \p count finite points, evenly chosen.
Points3
somePoints(const io::LoadedCloud& cloud, std::size_t count)
{
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < cloud.points->size(); ++i)
    if ((*cloud.points)[i].getVector3fMap().allFinite())
      finite.push_back(i);
  const std::size_t kept = std::min(count, finite.size());
  Points3 points(3, static_cast<Eigen::Index>(kept));
  for (std::size_t i = 0; i < kept; ++i)
    points.col(static_cast<Eigen::Index>(i)) =
        (*cloud.points)[finite[i * finite.size() / kept]].getVector3fMap().cast<double>();
  return points;
}

Eigen::Vector3d
vectorFromJson(const Json& json)
{
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

} // namespace

Correspondences
correspondencesAtTruth(const PairInput& pair)
{
  if (!pair.T_target_source)
    throw std::invalid_argument("the true pose of the pair is not known");
  Correspondences result;
  result.radius = kRadiusLeafs * thinPair(viewOf(pair.source), viewOf(pair.target), ParameterRule{}, 1).source.leaf;
  const Points3 source = somePoints(pair.source, kMaxAsked);
  const Points3 target = somePoints(pair.target, kMaxIndexed);
  const NeighborIndex index(target);
  result.samples = static_cast<std::size_t>(source.cols());
  const Eigen::Isometry3d T =
      Eigen::Translation3d(-pair.target.offset) * *pair.T_target_source * Eigen::Translation3d(pair.source.offset);
  std::vector<Eigen::Index> asked;
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    const auto nearest = index.nearest(T * source.col(i), result.radius);
    if (nearest.index < 0)
      continue;
    asked.push_back(i);
    found.push_back(nearest.index);
  }
  result.source.resize(3, static_cast<Eigen::Index>(asked.size()));
  result.target.resize(3, static_cast<Eigen::Index>(asked.size()));
  for (std::size_t i = 0; i < asked.size(); ++i) {
    result.source.col(static_cast<Eigen::Index>(i)) = source.col(asked[i]);
    result.target.col(static_cast<Eigen::Index>(i)) = target.col(found[i]);
  }
  return result;
}

PairTruth
measureTruth(const PairInput& pair)
{
  PairTruth truth;
  truth.T_target_source = pair.T_target_source;
  truth.reference = pair.reference;
  truth.source_offset = pair.source.offset;
  truth.target_offset = pair.target.offset;
  truth.source_points = pair.source.points->size();
  truth.target_points = pair.target.points->size();
  truth.overlap = truth.gt_rmse = std::numeric_limits<double>::quiet_NaN();
  if (!truth.T_target_source)
    return truth;
  const Correspondences correspondences = correspondencesAtTruth(pair);
  truth.sums = sumCorrespondences(correspondences.source, correspondences.target);
  truth.overlap = truth.sums.count / static_cast<double>(std::max<std::size_t>(correspondences.samples, 1));
  truth.radius = correspondences.radius;
  truth.gt_rmse = truth.rmse(*truth.T_target_source);
  return truth;
}

Json
toJson(const PairTruth& truth)
{
  Json json;
  json["T_target_source"] = truth.T_target_source ? matrixJson(*truth.T_target_source) : Json(nullptr);
  json["reference"] = vectorJson(truth.reference);
  json["source_offset"] = vectorJson(truth.source_offset);
  json["target_offset"] = vectorJson(truth.target_offset);
  json["count"] = truth.sums.count;
  json["mean_source"] = vectorJson(truth.sums.mean_source);
  json["mean_target"] = vectorJson(truth.sums.mean_target);
  json["source_spread"] = truth.sums.source_spread;
  json["target_spread"] = truth.sums.target_spread;
  json["cross"] = {
      vectorJson(truth.sums.cross.col(0)), vectorJson(truth.sums.cross.col(1)), vectorJson(truth.sums.cross.col(2))};
  json["overlap"] = numberOrNull(truth.overlap);
  json["radius"] = truth.radius;
  json["source_points"] = truth.source_points;
  json["target_points"] = truth.target_points;
  return json;
}

PairTruth
pairTruthFromJson(const Json& json)
{
  PairTruth truth;
  if (!json.at("T_target_source").is_null())
    truth.T_target_source = poseFromJson(json.at("T_target_source"));
  truth.reference = vectorFromJson(json.at("reference"));
  truth.source_offset = vectorFromJson(json.at("source_offset"));
  truth.target_offset = vectorFromJson(json.at("target_offset"));
  truth.sums.count = json.at("count").get<double>();
  truth.sums.mean_source = vectorFromJson(json.at("mean_source"));
  truth.sums.mean_target = vectorFromJson(json.at("mean_target"));
  truth.sums.source_spread = json.at("source_spread").get<double>();
  truth.sums.target_spread = json.at("target_spread").get<double>();
  for (Eigen::Index column = 0; column < 3; ++column)
    truth.sums.cross.col(column) = vectorFromJson(json.at("cross").at(static_cast<std::size_t>(column)));
  truth.overlap = truth.gt_rmse = std::numeric_limits<double>::quiet_NaN();
  if (json.at("overlap").is_number())
    truth.overlap = json.at("overlap").get<double>();
  truth.radius = json.at("radius").get<double>();
  if (truth.T_target_source)
    truth.gt_rmse = truth.rmse(*truth.T_target_source);
  truth.source_points = json.at("source_points").get<std::size_t>();
  truth.target_points = json.at("target_points").get<std::size_t>();
  return truth;
}

} // namespace apps
} // namespace pcl_ssfr
