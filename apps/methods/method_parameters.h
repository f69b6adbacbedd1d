// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "preparation/thinning.h"

#include <pcl_ssfr/options.h>
#include <pcl_ssfr/scan_view.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/** \brief The one rule by which the parameters of every method but ssfr follow from the two scans, the same for all
 * data. (ssfr derives its own scales from the data; \ref ssfr can override them.)
 *
 * The leaf is the smaller radius of the two scans (90th percentile of the distance to their middle) times leaf_share,
 * grown by a quarter at a time until the voxels of the sparser scan hold min_points_per_voxel points on average. Every
 * other length is a multiple of the leaf.
 */
struct ParameterRule {
  double leaf = 0;                   ///< [m], 0: by the rule
  double leaf_share = 0.02;          ///< of the radius of the scan
  double min_leaf = 0.02;            ///< [m]
  double min_points_per_voxel = 1.5; ///< on average
  double normal_radius = 2.5;        ///< of normals [leafs]
  double feature_radius = 5;         ///< of FPFH [leafs]
  double threshold = 1.5;            ///< inlier distance of the global methods [leafs]
  double refine_distance = 20;       ///< correspondence distance of the refiners from the start [leafs]
  double polish_distance = 1;        ///< the same after ssfr, which suggests it: the leaf follows from it [leafs]
  double polish_normals = 4;         ///< radius of normals after ssfr [correspondence distances]
  double polish_cell = 6;            ///< cells of NDT after ssfr [correspondence distances]
  double ndt_cell = 10;              ///< [leafs]
  double keypoint_leaf = 8;          ///< spacing of the points that kfpcs works on [leafs]
  double refine_iterations = 50;     ///< of ICP, GICP and NDT
  double ransac_iterations = 20000;  ///< of fpfh_ransac
  double sac_ia_iterations = 200;    ///< of fpfh_sac_ia
  double fpcs_samples = 500;         ///< points of the source that fpcs works on
  double expected_overlap = 0.5;     ///< that fpcs, kfpcs and super4pcs assume
  double go_icp_points = 500;        ///< points of the source that go_icp works on
  double go_icp_trim = 0.3;          ///< share of the source that go_icp leaves out
  double go_icp_tolerance = 1e-4; ///< of go_icp's mean squared error [largest coordinate about the centroid, squared]
  double max_seconds = 60; ///< after which methods that can stop themselves do [s]: processor time, but for PCL's
  Options ssfr = makeOptions(Profile::Default);        ///< scales of ssfr and of the first step of ssfr_icp, ...
  Options paper2017 = makeOptions(Profile::Paper2017); ///< scales of ssfr_paper2017
};

/// One number of the rule as files and reports name it.
struct Parameter {
  const char* name;
  double ParameterRule::*value;
  double low;  ///< smallest value allowed
  double high; ///< largest value allowed
  const char* meaning;
};

/// All numbers of the rule, in the order of reports.
const std::vector<Parameter>&
parameterTable();

/** \brief Change a rule by a JSON object {"name": number, "ssfr": {...}, "ssfr_paper2017": {...}}; the two inner
 * objects take normal_radius, density_radius, bin_width, leaf, overlap_radius and min_confidence. \throw
 * std::invalid_argument with one line that names the key and the value
 */
void
applyParameters(const nlohmann::ordered_json& json, ParameterRule& rule);

/// The rule as applyParameters reads it, complete.
nlohmann::ordered_json
toJson(const ParameterRule& rule);

/// The lengths that follow from a rule and a pair of scans [m].
struct Scales {
  double leaf = 0;
  double normal_radius = 0;
  double feature_radius = 0;
  double threshold = 0;
  double refine_distance = 0;
  double ndt_cell = 0;
  double keypoint_leaf = 0;
};

/// The leafs of a rule in metres.
Scales
scalesOf(double leaf, const ParameterRule& rule);

/// Two scans thinned to the leaf of the rule, each about its own centroid (ThinnedCloud::origin).
struct ThinnedPair {
  ThinnedCloud source;
  ThinnedCloud target;
};

/** \brief Derive the leaf and thin. Both are empty when a scan has no finite point.
 * \param[in] most_leaf the leaf is no larger before it grows where points are few [m]; 0: no bound
 */
ThinnedPair
thinPair(
    const ScanView& source, const ScanView& target, const ParameterRule& rule, unsigned threads, double most_leaf = 0);

} // namespace apps
} // namespace pcl_ssfr
