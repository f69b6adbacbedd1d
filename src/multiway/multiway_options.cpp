// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>

#include <cstdio>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {

namespace {

constexpr double kHalfTurn = 3.14159265358979323846; // [rad]

void
require(bool is_met, const char* name, double value, const char* rule)
{
  if (is_met)
    return;
  char text[160];
  std::snprintf(text, sizeof(text), "%s = %g, must be %s", name, value, rule);
  throw std::invalid_argument(text);
}

void
requirePositive(const char* name, double value)
{
  require(value > 0 && value < 1e9, name, value, "positive and finite");
}

void
requireShare(const char* name, double value)
{
  require(value > 0 && value < 1, name, value, "between 0 and 1");
}

} // namespace

void
validate(const MultiwayOptions& options)
{
  validate(options.registration);
  require(options.registration.profile == Profile::Default,
          "registration.profile",
          static_cast<double>(options.registration.profile),
          "Profile::Default");
  require(options.threads <= kMaxThreads, "threads", options.threads, "at most 1024");
  if (options.gravity)
    require(options.gravity->allFinite() && options.gravity->norm() > 0,
            "gravity",
            options.gravity->norm(),
            "a direction of finite length > 0");
  require(options.gravity_tolerance > 0 && options.gravity_tolerance <= kHalfTurn,
          "gravity_tolerance",
          options.gravity_tolerance,
          "positive and at most pi");
  const LinkConfig& link = options.link;
  require(link.hypotheses >= 1 && link.hypotheses <= 10, "link.hypotheses", link.hypotheses, "1 to 10");
  requireShare("link.least_probability", link.least_probability);
  requireShare("link.fitted_share", link.fitted_share);
  const ChoiceConfig& choice = options.choice;
  requirePositive("choice.same_rotation", choice.same_rotation);
  requirePositive("choice.same_translation", choice.same_translation);
  requirePositive("choice.loop_weight", choice.loop_weight);
  requirePositive("choice.loop_bound", choice.loop_bound);
  requireShare("choice.sure", choice.sure);
  requireShare("choice.rival", choice.rival);
  requirePositive("choice.rival_rotation", choice.rival_rotation);
  requirePositive("choice.rival_translation", choice.rival_translation);
  requirePositive("choice.outvoted", choice.outvoted);
  requirePositive("choice.clear_odds", choice.clear_odds);
  requirePositive("choice.score_power", choice.score_power);
  requirePositive("choice.rival_links", choice.rival_links);
  requirePositive("choice.clear_majority", choice.clear_majority);
  requireShare("choice.lone", choice.lone);
  requirePositive("choice.contradiction_weight", choice.contradiction_weight);
  require(choice.rival_gain >= 1 && choice.rival_gain < 100, "choice.rival_gain", choice.rival_gain, "1 to 100");
  require(choice.loose >= 1 && choice.loose < 10, "choice.loose", choice.loose, "1 or more, less than 10");
  const AdjustmentConfig& adjustment = options.adjustment;
  require(adjustment.rounds >= 1, "adjustment.rounds", adjustment.rounds, "1 or more");
  requirePositive("adjustment.last_step", adjustment.last_step);
  requireShare("adjustment.least_matched", adjustment.least_matched);
  requirePositive("adjustment.damping", adjustment.damping);
  requirePositive("adjustment.noise_floor", adjustment.noise_floor);
  requirePositive("adjustment.covariance_factor", adjustment.covariance_factor);
}

const char*
toString(LinkStatus status)
{
  switch (status) {
  case LinkStatus::Used:
    return "used";
  case LinkStatus::Rejected:
    return "rejected";
  case LinkStatus::Ambiguous:
    return "ambiguous";
  case LinkStatus::None:
    break;
  }
  return "none";
}

} // namespace pcl_ssfr
