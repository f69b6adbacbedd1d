// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/method_parameters.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kGrowth = 1.25;      ///< of the leaf while voxels hold too few points
constexpr double kMaxLeafShare = 0.1; ///< of the radius: a sparser scan is not thinned further
constexpr double kNoLimit = std::numeric_limits<double>::max();

/// The options of ssfr that the file can set.
struct SsfrParameter {
  const char* name;
  double Options::*value;
};
constexpr SsfrParameter kSsfrParameters[] = {{"normal_radius", &Options::normal_radius},
                                             {"density_radius", &Options::density_radius},
                                             {"bin_width", &Options::bin_width},
                                             {"leaf", &Options::leaf},
                                             {"overlap_radius", &Options::overlap_radius},
                                             {"min_confidence", &Options::min_confidence}};

double
numberOf(const Json& json, const std::string& name)
{
  if (!json.is_number())
    throw std::invalid_argument(name + " = " + json.dump() + ", must be a number");
  return json.get<double>();
}

void
applySsfr(const Json& json, const std::string& method, Options& options)
{
  if (!json.is_object())
    throw std::invalid_argument(method + " = " + json.dump() + ", must be an object");
  for (const auto& [key, value] : json.items()) {
    const std::string name = key; // a structured binding cannot be captured
    std::string field = method;
    field.append(".").append(name);
    const auto known = std::find_if(
        std::begin(kSsfrParameters), std::end(kSsfrParameters), [&name](const auto& p) { return name == p.name; });
    if (known == std::end(kSsfrParameters))
      throw std::invalid_argument(field + " is not a parameter");
    options.*(known->value) = numberOf(value, field);
  }
  try {
    validate(options);
  }
  catch (const std::invalid_argument& error) {
    throw std::invalid_argument(method + "." + error.what());
  }
}

Json
ssfrJson(const Options& options)
{
  Json json = Json::object();
  for (const SsfrParameter& parameter : kSsfrParameters)
    json[parameter.name] = options.*(parameter.value);
  return json;
}

} // namespace

const std::vector<Parameter>&
parameterTable()
{
  using R = ParameterRule;
  static const std::vector<Parameter> kTable{
      {"leaf", &R::leaf, 0, kNoLimit, "spacing that scans are thinned to [m], 0: by the rule"},
      {"leaf_share", &R::leaf_share, 1e-6, kMaxLeafShare, "leaf over the smaller radius of the two scans"},
      {"min_leaf", &R::min_leaf, 1e-6, kNoLimit, "smallest leaf [m]"},
      {"min_points_per_voxel", &R::min_points_per_voxel, 1, kNoLimit, "the leaf grows until voxels hold so many"},
      {"normal_radius", &R::normal_radius, 0.1, kNoLimit, "radius of normals [leafs]"},
      {"feature_radius", &R::feature_radius, 0.1, kNoLimit, "radius of FPFH [leafs]"},
      {"threshold", &R::threshold, 0.1, kNoLimit, "inlier distance of the global methods [leafs]"},
      {"refine_distance", &R::refine_distance, 0.1, kNoLimit, "correspondences of the refiners [leafs]"},
      {"polish_distance", &R::polish_distance, 0.1, kNoLimit, "the same after ssfr, which suggests it [leafs]"},
      {"polish_normals", &R::polish_normals, 0.1, kNoLimit, "radius of normals after ssfr [correspondence distances]"},
      {"polish_cell", &R::polish_cell, 0.1, kNoLimit, "cells of NDT after ssfr [correspondence distances]"},
      {"ndt_cell", &R::ndt_cell, 0.1, kNoLimit, "cells of NDT [leafs]"},
      {"keypoint_leaf", &R::keypoint_leaf, 1, kNoLimit, "spacing of the points of kfpcs [leafs]"},
      {"refine_iterations", &R::refine_iterations, 1, 1e6, "bound of ICP, GICP and NDT"},
      {"ransac_iterations", &R::ransac_iterations, 1, 1e9, "of fpfh_ransac"},
      {"sac_ia_iterations", &R::sac_ia_iterations, 1, 1e9, "of fpfh_sac_ia"},
      {"fpcs_samples", &R::fpcs_samples, 10, 1e6, "points of the source that fpcs works on"},
      {"expected_overlap", &R::expected_overlap, 0.01, 1, "that fpcs, kfpcs and super4pcs assume"},
      {"go_icp_points", &R::go_icp_points, 3, 1e6, "points of the source that go_icp works on"},
      {"go_icp_trim", &R::go_icp_trim, 0, 0.99, "share of the source that go_icp leaves out"},
      {"go_icp_tolerance", &R::go_icp_tolerance, 1e-12, 1, "mean squared error of go_icp [largest coordinate squared]"},
      {"max_seconds",
       &R::max_seconds,
       1,
       1e6,
       "go_icp, super4pcs (processor time), fpcs, kfpcs (wall clock) stop after it [s]"}};
  return kTable;
}

void
applyParameters(const Json& json, ParameterRule& rule)
{
  if (!json.is_object())
    throw std::invalid_argument("the parameters are not a JSON object");
  for (const auto& [key, value] : json.items()) {
    const std::string name = key;
    if (name == "ssfr" || name == "ssfr_paper2017") {
      applySsfr(value, name, name == "ssfr" ? rule.ssfr : rule.paper2017);
      continue;
    }
    const auto& table = parameterTable();
    const auto known = std::find_if(table.begin(), table.end(), [&name](const Parameter& p) { return name == p.name; });
    if (known == table.end())
      throw std::invalid_argument(name + " is not a parameter");
    const double number = numberOf(value, name);
    if (!(number >= known->low && number <= known->high))
      throw std::invalid_argument(name + " = " + value.dump() + ", must be from " + Json(known->low).dump() +
                                  (known->high < kNoLimit ? " to " + Json(known->high).dump() : " on"));
    rule.*(known->value) = number;
  }
}

Json
toJson(const ParameterRule& rule)
{
  Json json = Json::object();
  for (const Parameter& parameter : parameterTable())
    json[parameter.name] = rule.*(parameter.value);
  json["ssfr"] = ssfrJson(rule.ssfr);
  json["ssfr_paper2017"] = ssfrJson(rule.paper2017);
  return json;
}

Scales
scalesOf(double leaf, const ParameterRule& rule)
{
  Scales scales;
  scales.leaf = leaf;
  scales.normal_radius = leaf * rule.normal_radius;
  scales.feature_radius = leaf * rule.feature_radius;
  scales.threshold = leaf * rule.threshold;
  scales.refine_distance = leaf * rule.refine_distance;
  scales.ndt_cell = leaf * rule.ndt_cell;
  scales.keypoint_leaf = leaf * rule.keypoint_leaf;
  return scales;
}

ThinnedPair
thinPair(const ScanView& source, const ScanView& target, const ParameterRule& rule, unsigned threads, double most_leaf)
{
  const ScanExtent source_extent = measureExtent(source);
  const ScanExtent target_extent = measureExtent(target);
  ThinnedPair pair;
  if (source_extent.returns + target_extent.returns == 0)
    return pair;
  const auto radiusOf = [](const ScanExtent& extent) { // a scan without points says nothing of the other one's
    return extent.returns == 0 ? std::numeric_limits<double>::infinity() : extent.radius;
  };
  const double radius = std::min(radiusOf(source_extent), radiusOf(target_extent));
  double leaf = rule.leaf > 0 ? rule.leaf : std::max(rule.min_leaf, rule.leaf_share * radius);
  if (most_leaf > 0 && !(rule.leaf > 0))
    leaf = std::min(leaf, most_leaf);
  const auto thin = [&] {
    pair.source = thinScan(source, leaf, source_extent.median, 0, threads);
    pair.target = thinScan(target, leaf, target_extent.median, 0, threads);
  };
  const auto dense = [&rule](const ThinnedCloud& thinned, const ScanExtent& extent) {
    return rule.min_points_per_voxel * static_cast<double>(thinned.size()) <= static_cast<double>(extent.returns);
  };
  thin();
  while (!(rule.leaf > 0) && leaf * kGrowth <= kMaxLeafShare * radius &&
         !(dense(pair.source, source_extent) && dense(pair.target, target_extent))) {
    leaf *= kGrowth;
    thin();
  }
  return pair;
}

} // namespace apps
} // namespace pcl_ssfr
