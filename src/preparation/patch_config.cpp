// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/patch_config.h>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {

namespace {

/// Throw unless \p good. Conditions are written so that NaN is not good.
void
require(bool good, const std::string& name, double value, const char* bound)
{
  if (good)
    return;
  std::ostringstream text;
  text << name << " = " << value << ", must " << bound;
  throw std::invalid_argument(text.str());
}

void
requirePositive(const std::string& name, double value)
{
  require(value > 0 && std::isfinite(value), name, value, "be positive and finite");
}

void
requireAtLeast(const std::string& name, int value, int least)
{
  require(value >= least, name, value, ("be at least " + std::to_string(least)).c_str());
}

void
requireShare(const std::string& name, double value)
{
  require(value >= 0 && value <= 1, name, value, "be in [0, 1]");
}

void
requireChord(const std::string& name, double value)
{
  require(value > 0 && value <= 1, name, value, "be a chord in (0, 1]");
}

void
validate(const ViewpointSearchConfig& config)
{
  double before = 0;
  for (std::size_t k = 0; k < config.levels.size(); ++k) {
    const ViewpointSearchConfig::Level& level = config.levels[k];
    const std::string name = "preparation.viewpoint.levels[" + std::to_string(k) + "].";
    requireAtLeast(name + "places", level.places, 1);
    requireAtLeast(name + "points", level.points, 1);
    requirePositive(name + "step", level.step);
    require(k == 0 || level.step <= before, name + "step", level.step, "be no more than that of the level before");
    before = level.step;
  }
  requirePositive("preparation.viewpoint.reach", config.reach);
  require(config.depth_ratio >= 1 && std::isfinite(config.depth_ratio),
          "preparation.viewpoint.depth_ratio",
          config.depth_ratio,
          "be at least 1 and finite");
  requirePositive("preparation.viewpoint.depth_margin", config.depth_margin);
  requirePositive("preparation.viewpoint.two_depth_weight", config.two_depth_weight);
  requireShare("preparation.viewpoint.min_contrast", config.min_contrast);
  requireShare("preparation.viewpoint.max_two_depths", config.max_two_depths);
  requirePositive("preparation.viewpoint.contrast_distance", config.contrast_distance);
}

void
validate(const SearchPass& pass, const std::string& name)
{
  requireAtLeast(name + ".peaks_first", pass.peaks_first, 1);
  requireAtLeast(name + ".peaks_second", pass.peaks_second, 1);
  requireAtLeast(name + ".refined", pass.refined, 1);
  requireShare(name + ".promising", pass.promising);
  requireAtLeast(name + ".distinct", pass.distinct, 1);
}

void
validate(const PlanSearchConfig& config)
{
  requireAtLeast("search.plan.axes", config.axes, 1);
  requireShare("search.plan.axis_support", config.axis_support);
  requireAtLeast("search.plan.elements", config.elements, 1);
  requirePositive("search.plan.cell", config.cell);
  requirePositive("search.plan.height", config.height);
  requireAtLeast("search.plan.matches", config.matches, 1);
  requireAtLeast("search.plan.refined", config.refined, 1);
  requireAtLeast("search.plan.distinct", config.distinct, 1);
}

void
validate(const SearchConfig& config)
{
  requirePositive("search.pair_angle", config.pair_angle);
  requirePositive("search.direction_error", config.direction_error);
  requireAtLeast("search.rotations", config.rotations, 1);
  requireAtLeast("search.sweep_steps", config.sweep_steps, 1);
  requirePositive("search.bin_width", config.bin_width);
  requirePositive("search.step", config.step);
  validate(config.much_overlap, "search.much_overlap");
  validate(config.little_overlap, "search.little_overlap");
  validate(config.plan);
}

void
validate(const RefinementConfig& config)
{
  requirePositive("refinement.coarse_reach", config.coarse_reach);
  requirePositive("refinement.coarse_final", config.coarse_final);
  requireAtLeast("refinement.coarse_steps", config.coarse_steps, 1);
  requirePositive("refinement.fine_reach", config.fine_reach);
  requirePositive("refinement.fine_final", config.fine_final);
  requireAtLeast("refinement.fine_steps", config.fine_steps, 1);
  requirePositive("refinement.fine_step", config.fine_step);
  requirePositive("refinement.polish_reach", config.polish_reach);
  requirePositive("refinement.polish_final", config.polish_final);
  requireShare("refinement.kept_score", config.kept_score);
  requirePositive("refinement.distinct_distance", config.distinct_distance);
  requirePositive("refinement.distinct_angle", config.distinct_angle);
  requireAtLeast("refinement.polished", config.polished, 1);
  requirePositive("refinement.explored_deviation", config.explored_deviation);
  requireAtLeast("refinement.explored_motions", config.explored_motions, 0);
  requirePositive("refinement.explored_distance", config.explored_distance);
  requirePositive("refinement.explored_gain", config.explored_gain);
}

void
validate(const JudgementConfig& config)
{
  const EvidenceConfig& evidence = config.evidence;
  requirePositive("judgement.evidence.vote_match", evidence.vote_match);
  requirePositive("judgement.evidence.loose_match", evidence.loose_match);
  requirePositive("judgement.evidence.match", evidence.match);
  requirePositive("judgement.evidence.lateral", evidence.lateral);
  requirePositive("judgement.evidence.free_margin", evidence.free_margin);
  requirePositive("judgement.evidence.loose_normals", evidence.loose_normals);
  requirePositive("judgement.evidence.normals", evidence.normals);
  requirePositive("judgement.evidence.contradiction_weight", evidence.contradiction_weight);
  requireShare("judgement.decided", config.decided);
  requirePositive("judgement.hopeless", config.hopeless);
  requirePositive("judgement.rival", config.rival);
  requirePositive("judgement.sensor_on_sensor", config.sensor_on_sensor);
  requirePositive("judgement.guess_trust", config.guess_trust);
  requirePositive("judgement.guess_deviation", config.guess_deviation);
  requireShare("judgement.unfinished", config.unfinished);
  requireShare("judgement.undetermined", config.undetermined);
  requireShare("judgement.telling_contradiction", config.telling_contradiction);
}

} // namespace

PreparationConfig
scaled(const PreparationConfig& config, double scale)
{
  PreparationConfig lengths = config;
  lengths.leaf *= scale;
  lengths.thickness *= scale;
  lengths.index_voxel *= scale;
  for (ViewpointSearchConfig::Level& level : lengths.viewpoint.levels)
    level.step *= scale;
  lengths.viewpoint.depth_margin *= scale;
  lengths.viewpoint.contrast_distance *= scale;
  return lengths;
}

void
validate(const PatchProfileConfig& config)
{
  const PreparationConfig& preparation = config.preparation;
  requirePositive("preparation.smallest_radius", preparation.smallest_radius);
  require(preparation.largest_radius >= preparation.smallest_radius && std::isfinite(preparation.largest_radius),
          "preparation.largest_radius",
          preparation.largest_radius,
          "be at least smallest_radius and finite");
  requireAtLeast("preparation.min_points_per_cell", preparation.min_points_per_cell, 1);
  requirePositive("preparation.leaf", preparation.leaf);
  requirePositive("preparation.thickness", preparation.thickness);
  require(preparation.max_noise >= 1 && std::isfinite(preparation.max_noise),
          "preparation.max_noise",
          preparation.max_noise,
          "be at least 1 and finite");
  requireShare("preparation.thin_share", preparation.thin_share);
  requirePositive("preparation.noise_factor", preparation.noise_factor);
  requireAtLeast("preparation.max_main_normals", preparation.max_main_normals, 1);
  requireChord("preparation.density_radius", preparation.density_radius);
  requireChord("preparation.silence_chord", preparation.silence_chord);
  requireShare("preparation.min_relative_density", preparation.min_relative_density);
  requireAtLeast("preparation.max_density_queries", preparation.max_density_queries, 0);
  requirePositive("preparation.index_voxel", preparation.index_voxel);
  require(preparation.range_cell > 0 && preparation.range_cell <= 1.5707963267948966,
          "preparation.range_cell",
          preparation.range_cell,
          "be in (0, pi/2]");
  requireAtLeast("preparation.coarse_patches", preparation.coarse_patches, 1);
  requireAtLeast("preparation.polish_points", preparation.polish_points, 1);
  requireAtLeast("preparation.polish_group", preparation.polish_group, 1);
  requireAtLeast("preparation.max_polish_points", preparation.max_polish_points, 1);
  validate(preparation.viewpoint);
  validate(config.search);
  validate(config.refinement);
  validate(config.judgement);
}

} // namespace pcl_ssfr
