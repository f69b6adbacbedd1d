// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "profiles/patch_profile.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <apps/io/loaded_cloud.h>
#include <pcl_ssfr/patch_config.h>

#include <pcl/common/io.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace {

using testing::viewOfPoints;

/// A field of the config: how to change it, and whether the prepared scans may not change with it.
struct Field {
  std::string name;
  std::function<void(PreparationConfig&, double)> multiply;
  bool is_flat = false;
};

template <typename Value>
Field
field(const std::string& name, Value PreparationConfig::*member, bool is_flat = false)
{
  return {name,
          [member](PreparationConfig& config, double factor) {
            config.*member = static_cast<Value>(static_cast<double>(config.*member) * factor);
          },
          is_flat};
}

Field
field(const std::string& name, double ViewpointSearchConfig::*member, bool is_flat = false)
{
  return {name, [member](PreparationConfig& config, double factor) { config.viewpoint.*member *= factor; }, is_flat};
}

std::vector<Field>
allFields()
{
  using Config = PreparationConfig;
  using Search = ViewpointSearchConfig;
  std::vector<Field> fields = {field("smallest_radius", &Config::smallest_radius),
                               field("largest_radius", &Config::largest_radius),
                               field("min_points_per_cell", &Config::min_points_per_cell),
                               field("leaf", &Config::leaf),
                               field("thickness", &Config::thickness),
                               field("max_noise", &Config::max_noise),
                               field("thin_share", &Config::thin_share),
                               field("noise_factor", &Config::noise_factor),
                               field("max_main_normals", &Config::max_main_normals),
                               field("density_radius", &Config::density_radius),
                               field("silence_chord", &Config::silence_chord),
                               field("min_relative_density", &Config::min_relative_density),
                               field("max_density_queries", &Config::max_density_queries),
                               field("index_voxel", &Config::index_voxel),
                               field("range_cell", &Config::range_cell),
                               field("coarse_patches", &Config::coarse_patches),
                               field("polish_points", &Config::polish_points),
                               field("polish_group", &Config::polish_group),
                               field("max_polish_points", &Config::max_polish_points),
                               field("viewpoint.reach", &Search::reach),
                               field("viewpoint.depth_ratio", &Search::depth_ratio),
                               field("viewpoint.depth_margin", &Search::depth_margin),
                               field("viewpoint.two_depth_weight", &Search::two_depth_weight),
                               field("viewpoint.min_contrast", &Search::min_contrast),
                               field("viewpoint.max_two_depths", &Search::max_two_depths),
                               field("viewpoint.contrast_distance", &Search::contrast_distance)};
  for (std::size_t k = 0; k < Search().levels.size(); ++k) {
    const std::string name = "viewpoint.levels[" + std::to_string(k) + "].";
    fields.push_back({name + "places",
                      [k](Config& config, double factor) {
                        int& places = config.viewpoint.levels[k].places;
                        places = static_cast<int>(places * factor);
                      },
                      k == 1}); // so many that the best is among them anyway
    fields.push_back({name + "points", [k](Config& config, double factor) {
                        int& points = config.viewpoint.levels[k].points;
                        points = static_cast<int>(points * factor);
                      }});
    fields.push_back(
        {name + "step", [k](Config& config, double factor) { config.viewpoint.levels[k].step *= factor; }});
  }
  return fields;
}

/// A scan that is prepared, and whether the place of its sensor is to be found.
struct Input {
  Eigen::Matrix3Xf points;
  ViewpointMode mode = ViewpointMode::Auto;
};

Eigen::Matrix3Xf
load(const std::string& name)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  pcl::copyPointCloud(*io::loadCloud(std::string(PCL_SSFR_DATA_DIR) + "/" + name).points, cloud);
  Eigen::Matrix3Xf points(3, static_cast<Eigen::Index>(cloud.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = cloud[static_cast<std::size_t>(i)].getVector3fMap();
  return points;
}

/// Scans as they are, where the sensor is not known, thin, noisy, very noisy, tiny and huge.
std::vector<Input>
makeInputs()
{
  const Eigen::Matrix3Xf room = load("apartment_0.pcd");
  const Eigen::Matrix3Xf street = load("street_0.pcd");
  Eigen::Matrix3Xf thin(3, room.cols() / 30);
  for (Eigen::Index i = 0; i < thin.cols(); ++i)
    thin.col(i) = room.col(30 * i);
  testing::Random random(4);
  const auto noisy = [&](double deviation) {
    Eigen::Matrix3Xf points = room;
    for (Eigen::Index i = 0; i < points.size(); ++i)
      points.data()[i] += static_cast<float>(deviation * random.gaussian());
    return points;
  };
  const Eigen::Vector3f away(4, 3, 1);
  // Four rooms side by side: from everywhere some of one is behind another.
  const Eigen::Matrix3Xf one_room = testing::samplePoints(testing::roomRectangles(), 100, 3);
  Eigen::Matrix3Xf rooms(3, 4 * one_room.cols());
  for (int k = 0; k < 4; ++k)
    rooms.middleCols(k * one_room.cols(), one_room.cols()) =
        one_room.colwise() + Eigen::Vector3f(k % 2 ? 6.2f : 0, k / 2 ? 5.2f : 0, 0);
  std::vector<Input> inputs = {{room},
                               {street},
                               {room.colwise() + away, ViewpointMode::Unknown},
                               {street.colwise() + away, ViewpointMode::Unknown},
                               {rooms, ViewpointMode::Unknown},
                               {thin},
                               {noisy(0.03)},
                               {noisy(0.15)},
                               {0.01f * room},
                               {100.f * room}};
  // Off the sensor, where its place has hardly a contrast to those around.
  for (const float x : {-7.f, -7.5f})
    inputs.push_back({street.colwise() + Eigen::Vector3f(x, 0, 0)});
  return inputs;
}

/// Numbers that a change of the prepared scan changes.
std::vector<double>
fingerprint(const Input& input, const Options& options)
{
  Options these = options;
  these.viewpoint_mode = input.mode;
  const PatchScan scan = preparePatchScan(viewOfPoints(input.points), these);
  std::vector<double> numbers = {scan.scale,
                                 scan.thickness,
                                 scan.viewpoint.x(),
                                 scan.viewpoint.y(),
                                 scan.viewpoint.z(),
                                 scan.viewpoint_used ? 1. : 0.,
                                 static_cast<double>(scan.patches.size()),
                                 static_cast<double>(scan.coarse.size()),
                                 static_cast<double>(scan.surface.points.cols()),
                                 static_cast<double>(scan.range_image.size()),
                                 scan.index.voxel()};
  for (const MainNormal& m : scan.main_normals)
    numbers.insert(numbers.end(), {m.direction.x(), m.direction.y(), m.direction.z()});
  return numbers;
}

TEST(PatchConfig, EveryFieldMattersOrIsFlat)
{
  const std::vector<Input> inputs = makeInputs();
  const Options usual = makeOptions(Profile::Default);
  std::vector<std::vector<double>> expected;
  for (const Input& input : inputs)
    expected.push_back(fingerprint(input, usual));
  for (const Field& f : allFields()) {
    bool changes = false;
    for (std::size_t i = 0; i < inputs.size() && !changes; ++i)
      for (const double factor : {0.5, 1.7}) {
        Options options = usual;
        f.multiply(options.patch_profile.preparation, factor);
        if (f.name.find("levels") != std::string::npos && inputs[i].mode == ViewpointMode::Auto)
          continue; // sensors that are accepted at once
        changes = changes || fingerprint(inputs[i], options) != expected[i];
      }
    EXPECT_NE(changes, f.is_flat) << f.name;
  }
}

TEST(PatchConfig, LengthsAreScaledOnce)
{
  const PreparationConfig config;
  const PreparationConfig large = scaled(config, 10);
  EXPECT_DOUBLE_EQ(large.leaf, 10 * config.leaf);
  EXPECT_DOUBLE_EQ(large.thickness, 10 * config.thickness);
  EXPECT_DOUBLE_EQ(large.index_voxel, 10 * config.index_voxel);
  EXPECT_DOUBLE_EQ(large.viewpoint.depth_margin, 10 * config.viewpoint.depth_margin);
  EXPECT_DOUBLE_EQ(large.viewpoint.contrast_distance, 10 * config.viewpoint.contrast_distance);
  for (std::size_t k = 0; k < config.viewpoint.levels.size(); ++k)
    EXPECT_DOUBLE_EQ(large.viewpoint.levels[k].step, 10 * config.viewpoint.levels[k].step);
  // What is no length stays.
  EXPECT_EQ(large.range_cell, config.range_cell);
  EXPECT_EQ(large.density_radius, config.density_radius);
  EXPECT_EQ(large.smallest_radius, config.smallest_radius);
  EXPECT_EQ(large.viewpoint.reach, config.viewpoint.reach);
  EXPECT_EQ(large.viewpoint.min_contrast, config.viewpoint.min_contrast);
}

TEST(PatchConfig, ErrorsNameTheFieldAndItsValue)
{
  EXPECT_NO_THROW(validate(PatchProfileConfig()));
  for (const Field& f : allFields()) {
    PatchProfileConfig config;
    f.multiply(config.preparation, -1);
    try {
      validate(config);
      ADD_FAILURE() << f.name << " may be negative";
    }
    catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::StartsWith("preparation." + f.name + " = -"));
    }
  }
  PatchProfileConfig config;
  config.preparation.leaf = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = PatchProfileConfig();
  config.preparation.viewpoint.levels[1].step *= 2; // coarser than the level before
  EXPECT_THROW(validate(config), std::invalid_argument);
  Options options = makeOptions(Profile::Default);
  options.patch_profile.preparation.range_cell = 2;
  EXPECT_THROW(validate(options), std::invalid_argument);
}

} // namespace
} // namespace pcl_ssfr
