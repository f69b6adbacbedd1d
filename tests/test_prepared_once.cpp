// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Work that repeats is done once through the PCL class: one scan against ten is prepared once. A stage report holds the
// measured time, so the same report to the last bit means that the stage was not run again.

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_prepared_once {
namespace {

using namespace pcl_ssfr::testing;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Registration = StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>;

constexpr std::size_t kPartners = 10;

/// Times of the stages that prepared one of the scans, \p scan is "source" or "target".
std::vector<double>
preparationOf(const Result& result, const std::string& scan)
{
  std::vector<double> seconds;
  for (const StageReport& stage : result.stages)
    if (stage.name.rfind(scan + " ", 0) == 0)
      seconds.push_back(stage.seconds);
  return seconds;
}

/// The cloud somewhere else, and where.
std::pair<Cloud::Ptr, Eigen::Isometry3d>
elsewhere(const Cloud& cloud, std::uint64_t seed)
{
  Random random(seed);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = randomRotation(random); // about the sensor: it stays at the origin
  auto moved = pcl::make_shared<Cloud>(cloud);
  for (pcl::PointXYZ& point : *moved)
    point.getVector3fMap() = T.linear().cast<float>() * point.getVector3fMap();
  return {moved, T};
}

TEST(PreparedOnce, OneSourceOntoTenTargets)
{
  const ScanPair<pcl::PointXYZ> pair = makeRoomPair<pcl::PointXYZ>(false);
  Registration registration;
  registration.setInputSource(pair.source);
  std::set<std::vector<double>> sources, targets;
  Cloud output;
  for (std::size_t i = 0; i < kPartners; ++i) {
    const auto [target, T] = elsewhere(*pair.target, i);
    registration.setInputTarget(target);
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
    EXPECT_THAT(registration.getFinalTransformation(), IsPoseNear(T * pair.T_target_source, 0.01, 0.02));
    sources.insert(preparationOf(registration.getResult(), "source"));
    targets.insert(preparationOf(registration.getResult(), "target"));
  }
  EXPECT_EQ(sources.size(), 1u);
  EXPECT_FALSE(sources.begin()->empty());
  EXPECT_EQ(targets.size(), kPartners);
}

TEST(PreparedOnce, TenSourcesOntoOneTarget)
{
  const ScanPair<pcl::PointXYZ> pair = makeRoomPair<pcl::PointXYZ>(false);
  Registration registration;
  registration.setInputTarget(pair.target);
  std::set<std::vector<double>> sources, targets;
  Cloud output;
  for (std::size_t i = 0; i < kPartners; ++i) {
    const auto [source, T] = elsewhere(*pair.source, i);
    registration.setInputSource(source);
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
    EXPECT_THAT(registration.getFinalTransformation(), IsPoseNear(pair.T_target_source * T.inverse(), 0.01, 0.02));
    sources.insert(preparationOf(registration.getResult(), "source"));
    targets.insert(preparationOf(registration.getResult(), "target"));
  }
  EXPECT_EQ(targets.size(), 1u);
  EXPECT_FALSE(targets.begin()->empty());
  EXPECT_EQ(sources.size(), kPartners);
}

/// One registration of the room, and when its scans are prepared.
class PreparedOnceSettings : public ::testing::Test {
protected:
  void
  SetUp() override
  {
    registration_.setInputSource(pair_.source);
    registration_.setInputTarget(pair_.target);
    source_ = target_ = {};
    align();
  }

  /// Align and report which scans were prepared anew for it: "", "source", "target" or "source target".
  std::string
  align(const Eigen::Matrix4f& guess = Eigen::Matrix4f::Identity())
  {
    registration_.align(output_, guess);
    const std::vector<double> source = preparationOf(registration_.getResult(), "source");
    const std::vector<double> target = preparationOf(registration_.getResult(), "target");
    EXPECT_FALSE(source.empty() || target.empty()) << registration_.getResult().message;
    std::string anew;
    if (source != source_)
      anew = "source";
    if (target != target_)
      anew += anew.empty() ? "target" : " target";
    source_ = source;
    target_ = target;
    return anew;
  }

  /// setOptions() with one field changed.
  template <typename Change>
  void
  change(const Change& change)
  {
    Options options = registration_.getOptions();
    change(options);
    registration_.setOptions(options);
  }

  const ScanPair<pcl::PointXYZ> pair_ = makeRoomPair<pcl::PointXYZ>(false);
  Registration registration_;
  std::vector<double> source_, target_; ///< times of the preparation that the last result came from
  Cloud output_;
};

TEST_F(PreparedOnceSettings, ThoseOfTheSearchKeepBothScans)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const std::vector<std::pair<const char*, std::function<void()>>> settings = {
      {"setTimeLimit", [&] { registration_.setTimeLimit(100); }},
      {"setNumberOfThreads", [&] { registration_.setNumberOfThreads(2); }},
      {"setBinWidth", [&] { registration_.setBinWidth(0.05); }},
      {"setGravity", [&] { registration_.setGravity(up, up, 0.5); }},
      {"clearGravity", [&] { registration_.clearGravity(); }},
      {"setGuessTolerance", [&] { registration_.setGuessTolerance(3, 9); }},
      {"clearGuessTolerance", [&] { registration_.clearGuessTolerance(); }},
      {"setRefinement", [&] { registration_.setRefinement(false); }},
      {"setMaximumIterations", [&] { registration_.setMaximumIterations(5); }},
      {"setMaxCorrespondenceDistance", [&] { registration_.setMaxCorrespondenceDistance(0.2); }},
      {"setOptions", [&] { registration_.setOptions(registration_.getOptions()); }},
      {"min_confidence", [&] { change([](Options& options) { options.min_confidence = 0.6; }); }},
      {"max_candidates", [&] { change([](Options& options) { options.max_candidates = 3; }); }},
      {"setProfile, there and back",
       [&] {
         registration_.setProfile(Profile::Paper2017);
         registration_.setProfile(Profile::Default);
       }},
  };
  for (const auto& [name, set] : settings) {
    set();
    EXPECT_EQ(align(), "") << name;
  }
  // The guess is an argument of align().
  EXPECT_EQ(align(pair_.T_target_source.matrix().cast<float>()), "");
}

TEST_F(PreparedOnceSettings, ThoseOfThePreparationAreSeen)
{
  const std::vector<std::pair<const char*, std::function<void()>>> settings = {
      {"setNormalRadius", [&] { registration_.setNormalRadius(0.2); }},
      {"setDensityRadius", [&] { registration_.setDensityRadius(0.05); }},
      {"setViewpointMode", [&] { registration_.setViewpointMode(ViewpointMode::SensorOrigin); }},
      {"leaf", [&] { change([](Options& options) { options.leaf = 0.06; }); }},
      {"patches", [&] { change([](Options& options) { options.patch_profile.preparation.patches.min_points = 6; }); }},
  };
  for (const auto& [name, set] : settings) {
    set();
    EXPECT_EQ(align(), "source target") << name;
    EXPECT_EQ(align(), "") << name << ", again";
  }
  registration_.setSourceViewpoint(Eigen::Vector3d(0, 0, 0.01));
  EXPECT_EQ(align(), "source");
  registration_.setTargetViewpoint(Eigen::Vector3d(0, 0, 0.01));
  EXPECT_EQ(align(), "target");
  registration_.setSourceViewpoint(Eigen::Vector3d::Zero());
  registration_.clearViewpoints();
  EXPECT_EQ(align(), "source target");
  registration_.clearViewpoints();
  EXPECT_EQ(align(), "");
}

} // namespace
} // namespace pcl_ssfr::test_prepared_once
