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
  text << "preparation." << name << " = " << value << ", must " << bound;
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
    const std::string name = "viewpoint.levels[" + std::to_string(k) + "].";
    requireAtLeast(name + "places", level.places, 1);
    requireAtLeast(name + "points", level.points, 1);
    requirePositive(name + "step", level.step);
    require(k == 0 || level.step <= before, name + "step", level.step, "be no more than that of the level before");
    before = level.step;
  }
  requirePositive("viewpoint.reach", config.reach);
  require(config.depth_ratio >= 1 && std::isfinite(config.depth_ratio),
          "viewpoint.depth_ratio",
          config.depth_ratio,
          "be at least 1 and finite");
  requirePositive("viewpoint.depth_margin", config.depth_margin);
  requirePositive("viewpoint.two_depth_weight", config.two_depth_weight);
  requireShare("viewpoint.min_contrast", config.min_contrast);
  requireShare("viewpoint.max_two_depths", config.max_two_depths);
  requirePositive("viewpoint.contrast_distance", config.contrast_distance);
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
  requirePositive("smallest_radius", preparation.smallest_radius);
  require(preparation.largest_radius >= preparation.smallest_radius && std::isfinite(preparation.largest_radius),
          "largest_radius",
          preparation.largest_radius,
          "be at least smallest_radius and finite");
  requireAtLeast("min_points_per_cell", preparation.min_points_per_cell, 1);
  requirePositive("leaf", preparation.leaf);
  requirePositive("thickness", preparation.thickness);
  require(preparation.max_noise >= 1 && std::isfinite(preparation.max_noise),
          "max_noise",
          preparation.max_noise,
          "be at least 1 and finite");
  requireShare("thin_share", preparation.thin_share);
  requirePositive("noise_factor", preparation.noise_factor);
  requireAtLeast("max_main_normals", preparation.max_main_normals, 1);
  requireChord("density_radius", preparation.density_radius);
  requireChord("silence_chord", preparation.silence_chord);
  requireShare("min_relative_density", preparation.min_relative_density);
  requireAtLeast("max_density_queries", preparation.max_density_queries, 0);
  requirePositive("index_voxel", preparation.index_voxel);
  require(preparation.range_cell > 0 && preparation.range_cell <= 1.5707963267948966,
          "range_cell",
          preparation.range_cell,
          "be in (0, pi/2]");
  requireAtLeast("coarse_patches", preparation.coarse_patches, 1);
  requireAtLeast("polish_points", preparation.polish_points, 1);
  requireAtLeast("polish_group", preparation.polish_group, 1);
  requireAtLeast("max_polish_points", preparation.max_polish_points, 1);
  validate(preparation.viewpoint);
}

} // namespace pcl_ssfr
