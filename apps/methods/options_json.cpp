// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/options_json.h>

#include <apps/common/json_values.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<const char*, Profile>, 2> kProfiles{
    {{"default", Profile::Default}, {"paper2017", Profile::Paper2017}}};
constexpr std::array<std::pair<const char*, ViewpointMode>, 4> kViewpoints{{{"auto", ViewpointMode::Auto},
                                                                            {"sensor", ViewpointMode::SensorOrigin},
                                                                            {"unknown", ViewpointMode::Unknown},
                                                                            {"unused", ViewpointMode::Unused}}};

/// Scales and bounds by the names of the library.
constexpr std::array<std::pair<const char*, double Options::*>, 7> kNumbers{
    {{"normal_radius", &Options::normal_radius},
     {"density_radius", &Options::density_radius},
     {"bin_width", &Options::bin_width},
     {"leaf", &Options::leaf},
     {"overlap_radius", &Options::overlap_radius},
     {"time_limit", &Options::time_limit},
     {"min_confidence", &Options::min_confidence}}};

template <typename Names, typename Value>
std::string
nameOf(const Names& names, Value value)
{
  for (const auto& [name, other] : names)
    if (other == value)
      return name;
  return {};
}

template <typename Value, typename Names>
Value
valueOf(const Names& names, const Json& json, const std::string& key)
{
  for (const auto& [name, value] : names)
    if (json == name)
      return value;
  throw std::invalid_argument("\"" + key + "\" is " + json.dump() + ", which is none of its values");
}

Eigen::Vector3d
directionFromJson(const Json& json, const std::string& key)
{
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  bool valid = json.is_array() && json.size() == 3;
  for (std::size_t i = 0; valid && i < 3; ++i) {
    valid = json[i].is_number();
    if (valid)
      v[static_cast<Eigen::Index>(i)] = json[i].get<double>();
  }
  if (!valid || !(v.norm() > 0))
    throw std::invalid_argument("\"" + key + "\" is not a direction of three numbers");
  return v.normalized();
}

double
numberFromJson(const Json& json, const std::string& key)
{
  if (!json.is_number())
    throw std::invalid_argument("\"" + key + "\" is " + json.dump() + ", not a number");
  return json.get<double>();
}

} // namespace

Json
optionsJson(const Options& options)
{
  Json json;
  json["profile"] = nameOf(kProfiles, options.profile);
  json["viewpoint"] = nameOf(kViewpoints, options.viewpoint_mode);
  for (const auto& [name, value] : kNumbers)
    json[name] = numberOrNull(options.*value);
  json["refine"] = options.refine;
  json["max_refinement_steps"] = options.max_refinement_steps;
  json["max_candidates"] = options.max_candidates;
  json["gravity"] = nullptr;
  if (options.gravity)
    json["gravity"] = {{"up_source", vectorJson(options.gravity->up_source)},
                       {"up_target", vectorJson(options.gravity->up_target)},
                       {"tolerance_rad", options.gravity->tolerance}};
  json["guess_tolerance"] = nullptr;
  if (options.guess_tolerance)
    json["guess_tolerance"] = {{"rotation_rad", options.guess_tolerance->rotation},
                               {"translation_m", options.guess_tolerance->translation}};
  json["threads"] = options.threads;
  return json;
}

Options
optionsFromJson(const Json& json)
{
  if (!json.is_object())
    throw std::invalid_argument("is not an object");
  const auto has = [&json](const char* key) { return json.contains(key) && !json[key].is_null(); };
  Options options =
      makeOptions(has("profile") ? valueOf<Profile>(kProfiles, json["profile"], "profile") : Profile::Default);
  if (has("viewpoint"))
    options.viewpoint_mode = valueOf<ViewpointMode>(kViewpoints, json["viewpoint"], "viewpoint");
  for (const auto& [name, value] : kNumbers)
    if (has(name))
      options.*value = numberFromJson(json[name], name);
  if (has("refine")) {
    if (!json["refine"].is_boolean())
      throw std::invalid_argument("\"refine\" is " + json["refine"].dump() + ", not true or false");
    options.refine = json["refine"].get<bool>();
  }
  if (has("max_refinement_steps"))
    options.max_refinement_steps =
        static_cast<int>(numberFromJson(json["max_refinement_steps"], "max_refinement_steps"));
  if (has("max_candidates"))
    options.max_candidates = static_cast<int>(numberFromJson(json["max_candidates"], "max_candidates"));
  if (has("threads"))
    options.threads = static_cast<unsigned>(numberFromJson(json["threads"], "threads"));
  if (has("gravity")) {
    const Json& given = json["gravity"];
    if (!given.is_object() || !given.contains("up_source") || !given.contains("up_target"))
      throw std::invalid_argument("\"gravity\" has no up_source and up_target");
    GravityPrior gravity;
    gravity.up_source = directionFromJson(given["up_source"], "gravity.up_source");
    gravity.up_target = directionFromJson(given["up_target"], "gravity.up_target");
    if (given.contains("tolerance_rad"))
      gravity.tolerance = numberFromJson(given["tolerance_rad"], "gravity.tolerance_rad");
    options.gravity = gravity;
  }
  if (has("guess_tolerance")) {
    const Json& given = json["guess_tolerance"];
    if (!given.is_object() || !given.contains("rotation_rad") || !given.contains("translation_m"))
      throw std::invalid_argument("\"guess_tolerance\" has no rotation_rad and translation_m");
    options.guess_tolerance = GuessTolerance{numberFromJson(given["rotation_rad"], "guess_tolerance.rotation_rad"),
                                             numberFromJson(given["translation_m"], "guess_tolerance.translation_m")};
  }
  validate(options);
  return options;
}

} // namespace apps
} // namespace pcl_ssfr
