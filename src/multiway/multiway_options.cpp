// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/angles.h"
#include "common/option_checks.h"

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>

namespace pcl_ssfr {

namespace {

void
requirePositive(const char* name, double value)
{
  requireOption(value > 0 && value < 1e9, name, value, "be positive and finite");
}

void
requireShare(const char* name, double value)
{
  requireOption(value > 0 && value < 1, name, value, "be between 0 and 1");
}

} // namespace

void
validate(const MultiwayOptions& options)
{
  validate(options.registration);
  requireOption(options.registration.profile == Profile::Default,
                "registration.profile",
                static_cast<double>(options.registration.profile),
                "be Profile::Default");
  requireOption(options.threads <= kMaxThreads, "threads", static_cast<double>(options.threads), "be at most 1024");
  if (options.gravity)
    requireOption(options.gravity->allFinite() && options.gravity->norm() > 0,
                  "gravity",
                  options.gravity->norm(),
                  "be a direction of finite length > 0");
  requireOption(options.gravity_tolerance > 0 && options.gravity_tolerance <= kPi,
                "gravity_tolerance",
                options.gravity_tolerance,
                "be positive and at most pi");
  const CandidateConfig& candidates = options.candidates;
  requireOption(candidates.alike >= 1, "candidates.alike", static_cast<double>(candidates.alike), "be 1 or more");
  const double bin = options.registration.patch_profile.preparation.match;
  requireOption(candidates.reach >= bin && candidates.reach <= 1e4 * bin,
                "candidates.reach",
                candidates.reach,
                "be 1 to 10000 times preparation.match of the pairs");
  const LinkConfig& link = options.link;
  requireOption(link.hypotheses >= 1 && link.hypotheses <= 10,
                "link.hypotheses",
                static_cast<double>(link.hypotheses),
                "be 1 to 10");
  requireShare("link.least_probability", link.least_probability);
  requireOption(link.plans_below > 0 && link.plans_below <= 1, "link.plans_below", link.plans_below, "be in (0, 1]");
  const ChoiceConfig& choice = options.choice;
  requirePositive("choice.same_rotation", choice.same_rotation);
  requirePositive("choice.same_translation", choice.same_translation);
  requirePositive("choice.loop_weight", choice.loop_weight);
  requirePositive("choice.loop_bound", choice.loop_bound);
  requireShare("choice.sure", choice.sure);
  requireShare("choice.rival", choice.rival);
  requirePositive("choice.clear_odds", choice.clear_odds);
  requirePositive("choice.score_power", choice.score_power);
  requireShare("choice.lone", choice.lone);
  requireOption(choice.loose >= 1 && choice.loose < 10, "choice.loose", choice.loose, "be 1 or more, less than 10");
  requireShare("alias.level_normal", options.alias.level_normal);
  requirePositive("alias.most_floor", options.alias.most_floor);
  requireShare("alias.flat_view", options.alias.flat_view);
  requireShare("alias.least_level_share", options.alias.least_level_share);
  requirePositive("alias.same_level", options.alias.same_level);
  requireShare("alias.same_view", options.alias.same_view);
  requirePositive("alias.storey", options.alias.storey);
  requireOption(options.alias.least_scans >= 2,
                "alias.least_scans",
                static_cast<double>(options.alias.least_scans),
                "be 2 or more");
  const FurnitureConfig& furniture = options.furniture;
  requirePositive("furniture.most_area", furniture.most_area);
  requirePositive("furniture.reach", furniture.reach);
  requirePositive("furniture.thickness", furniture.thickness);
  requireShare("furniture.parallel", furniture.parallel);
  requireOption(furniture.margin > 0 && furniture.margin <= 1, "furniture.margin", furniture.margin, "be in (0, 1]");
  requireShare("furniture.seen_through", furniture.seen_through);
  requireShare("furniture.seen_through_alike", furniture.seen_through_alike);
  requireOption(furniture.seen_through_alike > furniture.seen_through,
                "furniture.seen_through_alike",
                furniture.seen_through_alike,
                "be more than furniture.seen_through");
  requireOption(
      furniture.agreement >= 0 && furniture.agreement <= 1, "furniture.agreement", furniture.agreement, "be in [0, 1]");
  requireShare("furniture.least_false", furniture.least_false);
  const AdjustmentConfig& adjustment = options.adjustment;
  requireOption(adjustment.rounds >= 1, "adjustment.rounds", static_cast<double>(adjustment.rounds), "be 1 or more");
  requirePositive("adjustment.last_step", adjustment.last_step);
  requireShare("adjustment.least_matched", adjustment.least_matched);
  requirePositive("adjustment.damping", adjustment.damping);
  requirePositive("adjustment.damping_of_row", adjustment.damping_of_row);
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
