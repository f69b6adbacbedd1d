// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/patch_config.h>

#include "common/angles.h"
#include "common/config_numbers.h"
#include "common/option_checks.h"
#include "common/types.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace pcl_ssfr {

namespace {

constexpr std::string_view kPreparation = "preparation.";

bool
isOfPreparation(const ConfigNumber& number)
{
  return number.name.substr(0, kPreparation.size()) == kPreparation;
}

/// What \p number must be; empty: it is. Conditions are written so that NaN is not.
std::string_view
violatedBound(const ConfigNumber& number)
{
  const double v = number.value();
  const bool finite = std::isfinite(v);
  switch (number.bound) {
  case NumberBound::Finite:
    return finite ? "" : "be finite";
  case NumberBound::NotNegative:
    return v >= 0 && finite ? "" : "not be negative";
  case NumberBound::Positive:
    return v > 0 && finite ? "" : "be positive and finite";
  case NumberBound::AtLeastOne:
    return v >= 1 && finite ? "" : "be at least 1";
  case NumberBound::AtLeastThree:
    return v >= 3 && finite ? "" : "be at least 3";
  case NumberBound::Level: // finer than the code, so that the octree has more than one cell along each axis
    static_assert(kMortonBits == 21);
    return v >= 0 && v < kMortonBits - 1 ? "" : "be in [0, 20)";
  case NumberBound::Share:
    return v >= 0 && v <= 1 ? "" : "be in [0, 1]";
  case NumberBound::OpenShare:
    return v > 0 && v < 1 ? "" : "be in (0, 1)";
  case NumberBound::Chord:
    return v > 0 && v <= 1 ? "" : "be a chord in (0, 1]";
  case NumberBound::RightAngle:
    return v > 0 && v <= 90 * kDegree ? "" : "be in (0, pi/2]";
  }
  return "";
}

} // namespace

std::vector<ConfigNumber>
numbersOf(PatchProfileConfig& config)
{
  using Bound = NumberBound;
  using Scaling = NumberScaling;
// The name of a number is where it is.
#define NUMBER(path, ...)                                                                                              \
  {                                                                                                                    \
#path, config.path, __VA_ARGS__                                                                                    \
  }
#define LEVEL(k)                                                                                                       \
  NUMBER(preparation.viewpoint.levels[k].places, Bound::AtLeastOne),                                                   \
      NUMBER(preparation.viewpoint.levels[k].points, Bound::AtLeastOne),                                               \
      NUMBER(preparation.viewpoint.levels[k].step, Bound::Positive, Scaling::Scene)
#define POSTERIOR(which)                                                                                               \
  NUMBER(judgement.which.known, Bound::Finite), NUMBER(judgement.which.any_matches, Bound::NotNegative),               \
      NUMBER(judgement.which.any_third, Bound::NotNegative), NUMBER(judgement.which.matches, Bound::NotNegative),      \
      NUMBER(judgement.which.second, Bound::NotNegative), NUMBER(judgement.which.third, Bound::NotNegative)
#define PASS(which)                                                                                                    \
  NUMBER(search.which.peaks_first, Bound::AtLeastOne), NUMBER(search.which.peaks_second, Bound::AtLeastOne),           \
      NUMBER(search.which.refined, Bound::AtLeastOne), NUMBER(search.which.distinct, Bound::AtLeastOne)
  return {NUMBER(preparation.min_points, Bound::AtLeastOne),
          NUMBER(preparation.smallest_radius, Bound::Positive),
          NUMBER(preparation.largest_radius, Bound::Positive),
          NUMBER(preparation.min_points_per_cell, Bound::AtLeastOne),
          NUMBER(preparation.patches.range_noise, Bound::NotNegative),
          NUMBER(preparation.patches.max_flatness, Bound::OpenShare),
          NUMBER(preparation.patches.finest_level, Bound::Level),
          NUMBER(preparation.patches.coarsest_level, Bound::Level),
          NUMBER(preparation.patches.min_points, Bound::AtLeastThree),
          NUMBER(preparation.leaf, Bound::Positive, Scaling::Scene),
          NUMBER(preparation.thickness, Bound::Positive, Scaling::Scene),
          NUMBER(preparation.max_noise, Bound::AtLeastOne),
          NUMBER(preparation.thin_share, Bound::Share),
          NUMBER(preparation.noise_factor, Bound::Positive),
          NUMBER(preparation.max_main_normals, Bound::AtLeastOne),
          NUMBER(preparation.density_radius, Bound::Chord),
          NUMBER(preparation.min_relative_density, Bound::Share),
          NUMBER(preparation.max_density_queries, Bound::NotNegative),
          NUMBER(preparation.same_facing, Bound::RightAngle),
          NUMBER(preparation.loose_facing, Bound::RightAngle),
          NUMBER(preparation.votes, Bound::AtLeastOne),
          NUMBER(preparation.range_cell, Bound::RightAngle),
          NUMBER(preparation.match, Bound::Positive, Scaling::Matches),
          NUMBER(preparation.margin, Bound::Positive, Scaling::Scene),
          NUMBER(preparation.coarse_patches, Bound::AtLeastOne),
          NUMBER(preparation.clutter_points, Bound::NotNegative),
          NUMBER(preparation.polish_points, Bound::AtLeastOne),
          NUMBER(preparation.polish_group, Bound::AtLeastOne),
          NUMBER(preparation.max_polish_points, Bound::AtLeastOne),
          LEVEL(0),
          LEVEL(1),
          LEVEL(2),
          LEVEL(3),
          NUMBER(preparation.viewpoint.grid_directions, Bound::AtLeastOne),
          NUMBER(preparation.viewpoint.reach, Bound::Positive),
          NUMBER(preparation.viewpoint.depth_ratio, Bound::AtLeastOne),
          NUMBER(preparation.viewpoint.two_depth_weight, Bound::Positive),
          NUMBER(preparation.viewpoint.min_contrast, Bound::Share),
          NUMBER(preparation.viewpoint.max_two_depths, Bound::Share),
          NUMBER(preparation.viewpoint.contrast_distance, Bound::Positive, Scaling::Scene),
          NUMBER(search.direction_error, Bound::RightAngle),
          NUMBER(search.rotations, Bound::AtLeastOne),
          NUMBER(search.sweep_axes, Bound::NotNegative),
          NUMBER(search.sweep_steps, Bound::AtLeastOne),
          NUMBER(search.round_share, Bound::Share),
          NUMBER(search.plans_below, Bound::Share),
          NUMBER(search.screening_share, Bound::Share),
          NUMBER(search.contradiction_weight, Bound::NotNegative),
          NUMBER(search.promising, Bound::Share),
          PASS(much_overlap),
          PASS(little_overlap),
          NUMBER(refinement.coarse_reach, Bound::Positive, Scaling::Matches),
          NUMBER(refinement.coarse_steps, Bound::AtLeastOne),
          NUMBER(refinement.fine_steps, Bound::AtLeastOne),
          NUMBER(refinement.match_noise, Bound::Positive, Scaling::Scene),
          NUMBER(refinement.kept_score, Bound::Share),
          NUMBER(refinement.distinct_distance, Bound::Positive, Scaling::Scene),
          NUMBER(refinement.distinct_angle, Bound::Positive),
          NUMBER(refinement.explored_deviation, Bound::Positive, Scaling::Scene),
          NUMBER(judgement.evidence.loose_match, Bound::Positive, Scaling::Matches),
          NUMBER(judgement.evidence.range_margin, Bound::Share),
          NUMBER(judgement.evidence.contradiction_weight, Bound::Positive),
          NUMBER(judgement.prior.pose_error, Bound::Positive),
          NUMBER(judgement.prior.match_inflation, Bound::Positive),
          NUMBER(judgement.prior.guess_trust, Bound::Positive),
          NUMBER(judgement.prior.guess_deviation, Bound::Positive, Scaling::Scene),
          NUMBER(judgement.prior.sensor_on_sensor, Bound::Positive),
          NUMBER(judgement.uncertainty.noise_floor, Bound::Positive, Scaling::Scene),
          NUMBER(judgement.uncertainty.patch_noise, Bound::Share),
          NUMBER(judgement.uncertainty.unseen_curvature, Bound::Share),
          NUMBER(judgement.uncertainty.min_translation, Bound::NotNegative),
          NUMBER(judgement.uncertainty.max_rotation, Bound::Positive),
          NUMBER(judgement.uncertainty.bound_deviations, Bound::Positive),
          POSTERIOR(posterior),
          NUMBER(judgement.free_space.clutter, Bound::NotNegative),
          NUMBER(judgement.free_space.contradictions, Bound::NotNegative),
          POSTERIOR(posterior_blind),
          NUMBER(judgement.chance_contradictions, Bound::OpenShare),
          NUMBER(judgement.decided, Bound::Share),
          NUMBER(judgement.unsettled, Bound::Share),
          NUMBER(judgement.named_share, Bound::Share)};
#undef PASS
#undef POSTERIOR
#undef LEVEL
#undef NUMBER
}

std::vector<std::string>
numberNames()
{
  PatchProfileConfig config;
  std::vector<std::string> names;
  for (const ConfigNumber& number : numbersOf(config))
    names.emplace_back(number.name);
  return names;
}

void
setNumber(PatchProfileConfig& config, const std::string& name, double value)
{
  const std::vector<ConfigNumber> numbers = numbersOf(config);
  const auto found =
      std::find_if(numbers.begin(), numbers.end(), [&](const ConfigNumber& number) { return number.name == name; });
  if (found == numbers.end())
    throw std::invalid_argument("'" + name + "' is no number of the configuration");
  if (found->count) {
    if (!(value == std::floor(value) && std::abs(value) <= std::numeric_limits<int>::max()))
      rejectOption(name, value, "be an integer");
    *found->count = static_cast<int>(value);
  }
  else {
    *found->real = value;
  }
  if (const std::string_view bound = violatedBound(*found); !bound.empty())
    rejectOption(name, value, bound);
}

PreparationConfig
scaled(const PreparationConfig& config, double scale)
{
  PatchProfileConfig all;
  all.preparation = config;
  return scaledForPair(all, scale, 1).preparation; // its noise is not known yet
}

PatchProfileConfig
scaledForPair(const PatchProfileConfig& config, double scale, double noise)
{
  PatchProfileConfig lengths = config;
  for (const ConfigNumber& number : numbersOf(lengths)) {
    if (number.scaling == NumberScaling::None)
      continue;
    *number.real *= scale;
    if (number.scaling == NumberScaling::Matches)
      *number.real *= noise;
  }
  return lengths;
}

bool
isSamePreparation(const PatchProfileConfig& a, const PatchProfileConfig& b)
{
  PatchProfileConfig one = a, other = b;
  const std::vector<ConfigNumber> x = numbersOf(one), y = numbersOf(other);
  return std::equal(x.begin(), x.end(), y.begin(), [](const ConfigNumber& p, const ConfigNumber& q) {
    return !isOfPreparation(p) || p.value() == q.value();
  });
}

void
validate(const PatchProfileConfig& config)
{
  PatchProfileConfig all = config;
  for (const ConfigNumber& number : numbersOf(all))
    if (const std::string_view bound = violatedBound(number); !bound.empty())
      rejectOption(number.name, number.value(), bound);
  const PreparationConfig& preparation = config.preparation;
  if (preparation.largest_radius < preparation.smallest_radius)
    rejectOption("preparation.largest_radius", preparation.largest_radius, "be at least smallest_radius");
  if (preparation.patches.coarsest_level < preparation.patches.finest_level)
    rejectOption("preparation.patches.coarsest_level",
                 preparation.patches.coarsest_level,
                 "be in [finest_level, " + std::to_string(kMortonBits - 1) + ')');
  const auto& levels = preparation.viewpoint.levels;
  for (std::size_t k = 1; k < levels.size(); ++k)
    if (levels[k].step > levels[k - 1].step)
      rejectOption("preparation.viewpoint.levels[" + std::to_string(k) + "].step",
                   levels[k].step,
                   "be no more than that of the level before");
}

} // namespace pcl_ssfr
