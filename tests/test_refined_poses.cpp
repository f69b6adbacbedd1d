// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Refiners of PCL after ssfr: the points that they get, and that they never make its pose worse.

#include "pose_matchers.h"
#include "synthetic_scene.h"

#include <apps/io/loaded_cloud.h>
#include <apps/methods/method_run.h>
#include <apps/methods/planar_points.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>

namespace pcl_ssfr::apps::test_refined_poses {
namespace {

using namespace pcl_ssfr::testing;
using ::testing::HasSubstr;

constexpr double kRadius = 0.3;     // [m] of neighbours
constexpr double kThickness = 0.02; // [m]
constexpr double kDegree = 0.017453292519943295;

void
add(MethodCloud& cloud, double x, double y, double z)
{
  MethodPoint point;
  point.x = static_cast<float>(x);
  point.y = static_cast<float>(y);
  point.z = static_cast<float>(z);
  cloud.push_back(point);
}

MethodCloud::Ptr
planar(const MethodCloud& cloud, unsigned threads = 1)
{
  return planarPoints(cloud, Eigen::Vector3d(0, 0, 5), kRadius, kThickness, threads);
}

/// A floor from -2 to 2 m with \p noise [m], points 0.1 m apart.
MethodCloud
floorWithNoise(double noise)
{
  Random random(3);
  MethodCloud cloud;
  for (int i = -20; i <= 20; ++i)
    for (int k = -20; k <= 20; ++k)
      add(cloud, 0.1 * i, 0.1 * k, random.uniform(-noise, noise));
  return cloud;
}

TEST(PlanarPoints, OfAFloorAllFaceTheSensor)
{
  const MethodCloud cloud = floorWithNoise(0.005);
  const MethodCloud::Ptr points = planar(cloud);
  ASSERT_EQ(points->size(), cloud.size());
  for (const MethodPoint& point : *points)
    EXPECT_GT(point.normal_z, 0.99);
}

TEST(PlanarPoints, ThickCloudsAreNone)
{
  const MethodCloud cloud = floorWithNoise(0.2);
  EXPECT_LT(planar(cloud)->size(), cloud.size() / 100); // few neighbours at a corner may lie on a plane by chance
}

TEST(PlanarPoints, LinesAndEdgesAreNone)
{
  MethodCloud line;
  for (int i = 0; i < 100; ++i)
    add(line, 0.05 * i, 0, 0);
  EXPECT_EQ(planar(line)->size(), 0U);

  // A floor and a wall that meet at x = 0: points nearer to the edge than the radius have neighbours on both.
  MethodCloud corner;
  for (int i = 1; i <= 20; ++i)
    for (int k = -20; k <= 20; ++k) {
      add(corner, 0.1 * i, 0.1 * k, 0);
      add(corner, 0, 0.1 * k, 0.1 * i);
    }
  const MethodCloud::Ptr points = planar(corner);
  EXPECT_GT(points->size(), corner.size() / 2);
  EXPECT_LT(points->size(), corner.size());
  for (const MethodPoint& point : *points) {
    EXPECT_GT(std::max(point.x, point.z), 0.15);
    EXPECT_GT(std::max(std::abs(point.normal_x), std::abs(point.normal_z)), 0.99);
  }
}

TEST(PlanarPoints, EmptyAndFewPointsAreNone)
{
  EXPECT_EQ(planar(MethodCloud())->size(), 0U);
  MethodCloud few;
  for (int i = 0; i < 4; ++i)
    add(few, 0.1 * (i % 2), 0.1 * (i / 2), 0);
  EXPECT_EQ(planar(few)->size(), 0U);
}

TEST(PlanarPoints, DoNotDependOnThreads)
{
  const MethodCloud cloud = floorWithNoise(0.03);
  const MethodCloud::Ptr one = planar(cloud), many = planar(cloud, 4);
  ASSERT_EQ(one->size(), many->size());
  EXPECT_GT(one->size(), 0U);
  EXPECT_LT(one->size(), cloud.size());
  for (std::size_t i = 0; i < one->size(); ++i)
    EXPECT_EQ(std::memcmp((*one)[i].data_n, (*many)[i].data_n, 3 * sizeof(float)), 0);
}

io::LoadedCloud
loaded(const Eigen::Matrix3Xf& points)
{
  io::LoadedCloud cloud;
  cloud.points = pcl::make_shared<MethodCloud>();
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    add(*cloud.points, points(0, i), points(1, i), points(2, i));
  return cloud;
}

TEST(RefinedPoses, AreNeverWorseThanOurs)
{
  const Scene scene = makeFurnishedRoom(2);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(1), 1.85, 0.2);
  const Eigen::Isometry3d truth = relativePose(T_world_target, T_world_source);
  const io::LoadedCloud source = loaded(castScan(scene, T_world_source, roomScanner(0.0262), 12));
  const io::LoadedCloud target = loaded(castScan(scene, T_world_target, roomScanner(0.0262), 11));
  const Options options = makeOptions(Profile::Default);
  const Result ours = runMethod("ssfr", source, target, options, std::nullopt).result;
  ASSERT_TRUE(ours.accepted()) << ours.message;
  for (const char* method : {"ssfr_icp", "ssfr_gicp", "ssfr_ndt"}) {
    SCOPED_TRACE(method);
    const Result refined = runMethod(method, source, target, options, std::nullopt).result;
    EXPECT_TRUE(refined.accepted());
    EXPECT_THAT(refined.T_target_source, IsPoseNear(truth, 0.1 * kDegree, 0.01));
    ASSERT_EQ(refined.candidates.size(), ours.candidates.size());
    EXPECT_EQ(refined.candidates.front().T_target_source.matrix(), refined.T_target_source.matrix());
    EXPECT_EQ(refined.candidates.front().probability, ours.candidates.front().probability);
    EXPECT_GE(refined.candidates.front().score, ours.candidates.front().score - 1e-3);
    EXPECT_LE(refined.rmse, 1.01 * ours.rmse);
    const bool is_ours = refined.T_target_source.matrix() == ours.T_target_source.matrix();
    EXPECT_EQ(is_ours, refined.message.find("the pose is that of ssfr") != std::string::npos) << refined.message;
    EXPECT_EQ(refined.correspondence_distance, ours.correspondence_distance);
  }
}

TEST(RefinedPoses, AreKeptInTheCoordinatesOfAMap)
{
  io::LoadedCloud source = io::loadCloud(std::string(PCL_SSFR_DATA_DIR) + "/hall_0.pcd");
  io::LoadedCloud target = io::loadCloud(std::string(PCL_SSFR_DATA_DIR) + "/hall_1.pcd");
  Options options = makeOptions(Profile::Default);
  options.viewpoint_mode = ViewpointMode::Unknown; // the sensors are found in the points, here and there
  options.refine = false;                          // a polished pose is better than what refiners make of it
  for (const char* method : {"ssfr_icp", "ssfr_gicp"}) {
    SCOPED_TRACE(method);
    source.offset = target.offset = Eigen::Vector3d::Zero();
    const Result here = runMethod(method, source, target, options, std::nullopt).result;
    EXPECT_EQ(here.message.find("the pose is that of ssfr"), std::string::npos) << here.message;
    source.offset << 691234, 5338000, 512;
    target.offset << 691230, 5338007, 511;
    const Result there = runMethod(method, source, target, options, std::nullopt).result;
    EXPECT_EQ(there.message, here.message);
    const Eigen::Isometry3d T =
        Eigen::Translation3d(-target.offset) * there.T_target_source * Eigen::Translation3d(source.offset);
    EXPECT_THAT(T, IsPoseNear(here.T_target_source, 1e-4 * kDegree, 1e-5));
  }
}

TEST(RefinedPoses, DistancesAreMeasuredWithinTheSource)
{
  io::LoadedCloud source = loaded(Eigen::Matrix3Xf::Random(3, 500));
  source.offset << 691234, 5338000, 512;
  Result result;
  EXPECT_LT((referencePoint(source, result) - source.offset).norm(), 1); // in the middle of its points
  result.source_viewpoint_used = true;
  result.source_viewpoint << 691236, 5338001, 514;
  EXPECT_EQ(referencePoint(source, result), result.source_viewpoint);
}

TEST(RefinedPoses, ARefinerThatReachesTooFarIsNotFollowed)
{
  // Correspondences over metres drag ICP away from any pose where scans share a part only.
  const Scene scene = makeFurnishedRoom(1);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(1), 1.85, 0.2);
  const io::LoadedCloud source = loaded(castScan(scene, T_world_source, roomScanner(0.0262), 12));
  const io::LoadedCloud target = loaded(castScan(scene, T_world_target, roomScanner(0.0262), 11));
  const Options options = makeOptions(Profile::Default);
  MethodSettings settings;
  settings.rule.leaf = 0.5; // so coarse that no pose of such points is exact
  const Result ours = runMethod("ssfr", source, target, options, std::nullopt).result;
  const Result refined = runMethod("ssfr_gicp", source, target, options, std::nullopt, settings).result;
  ASSERT_TRUE(ours.accepted()) << ours.message;
  EXPECT_EQ(refined.T_target_source.matrix(), ours.T_target_source.matrix());
  EXPECT_EQ(refined.rmse, ours.rmse);
  EXPECT_THAT(refined.message, HasSubstr("the pose is that of ssfr"));
}

} // namespace
} // namespace pcl_ssfr::apps::test_refined_poses
