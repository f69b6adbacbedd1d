// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Work that repeats is done once through the PCL class: one scan against ten is prepared once. A stage report holds the
// measured time, so the same report to the last bit means that the stage was not run again.

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ssfr;
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

TEST(PreparedOnce, SettingsOfTheSearchKeepWhatIsPrepared)
{
  const ScanPair<pcl::PointXYZ> pair = makeRoomPair<pcl::PointXYZ>(false);
  Registration registration;
  registration.setInputSource(pair.source);
  registration.setInputTarget(pair.target);
  std::set<std::vector<double>> sources, targets;
  Cloud output;
  const auto align = [&] {
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
    sources.insert(preparationOf(registration.getResult(), "source"));
    targets.insert(preparationOf(registration.getResult(), "target"));
  };
  align();
  registration.setTimeLimit(100);
  align();
  registration.setNumberOfThreads(2);
  align();
  // The guess is an argument of align().
  registration.align(output, pair.T_target_source.matrix().cast<float>());
  sources.insert(preparationOf(registration.getResult(), "source"));
  targets.insert(preparationOf(registration.getResult(), "target"));
  EXPECT_EQ(sources.size(), 1u);
  EXPECT_EQ(targets.size(), 1u);
}

} // namespace
