// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/pairs/degradation.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// How the source of a pair is moved before it is registered.
enum class Perturbation {
  None,
  Rotation, ///< a uniformly random rotation about the origin of its frame
  Se3       ///< the same, and a translation of up to the radius of the scan in a random direction
};

/// Which pairs of scans of a dataset are registered.
enum class PairsFrom {
  Listed,   ///< those of pairs.csv
  Unlisted, ///< all ordered pairs that chains of listed pairs connect, but for the listed ones
  All,      ///< every unordered pair of the scans that pairs.csv names
  Unrelated ///< sources of pairs.csv with targets of another dataset: no pose is right
};

/// What is done to a pair before it is registered; ground truth follows.
struct Variation {
  double resolution_m = 0; ///< both scans are thinned to one averaged point per voxel of this edge [m]; 0: not
  double noise_m = 0;      ///< standard deviation of the Gaussian noise added to each coordinate of the source [m]
  double outliers = 0;     ///< share of the source that becomes uniform noise in its bounding box, [0, 1)
  double overlap = 0;      ///< the target is cut by a plane until so much of the source has a counterpart, [0, 1)
  Perturbation perturbation = Perturbation::None;
  PairsFrom pairs_from = PairsFrom::Listed;
  double origin_offset_m = 0; ///< both frames get an origin this far from the sensor, which is not reported [m]
  bool merge_target = false;  ///< another scan is laid into the target, which has no single viewpoint any more
  bool mirror_source = false; ///< as a left-handed file is: no pose is right
  Degradation degradation;    ///< of the source
};

/// Call visit(name, value) for each field of a variation, by the names of results.csv and summary.json.
template <typename SomeVariation, typename Visit>
void
forEachField(SomeVariation& variation, const Visit& visit)
{
  visit("resolution_m", variation.resolution_m);
  visit("noise_m", variation.noise_m);
  visit("outliers", variation.outliers);
  visit("overlap_limit", variation.overlap);
  visit("perturb", variation.perturbation);
  visit("pairs_from", variation.pairs_from);
  visit("origin_offset_m", variation.origin_offset_m);
  visit("merge_target", variation.merge_target);
  visit("mirror_source", variation.mirror_source);
  visit("degrade_every", variation.degradation.every);
  visit("degrade_sector_deg", variation.degradation.sector_deg);
  visit("degrade_nearest", variation.degradation.nearest);
}

const char*
toString(Perturbation perturbation);

const char*
toString(PairsFrom pairs);

/// none, rotation or se3. \throw std::invalid_argument
Perturbation
parsePerturbation(const std::string& text);

/// listed, unlisted, all or unrelated. \throw std::invalid_argument
PairsFrom
parsePairsFrom(const std::string& text);

/// An object with every field.
nlohmann::ordered_json
toJson(const Variation& variation);

/// \throw nlohmann::json::exception, std::invalid_argument
Variation
variationFromJson(const nlohmann::ordered_json& json);

/// One number per field: two variations are the same when these are. What reports sort by.
std::vector<double>
orderOf(const Variation& variation);

/// A variation in words, "as it is" for none: "thinned to 0.05 m, noise 0.01 m".
std::string
describeVariation(const Variation& variation);

} // namespace apps
} // namespace pcl_ssfr
