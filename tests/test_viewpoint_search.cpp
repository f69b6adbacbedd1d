// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/angles.h"
#include "patch_scenes.h"
#include "preparation/viewpoint_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr::test_viewpoint_search {
namespace {

using testing::kInf;
using testing::kMaxFloat;
using testing::kNan;

Eigen::Matrix3Xf
concatenated(const Eigen::Matrix3Xf& a, const Eigen::Matrix3Xf& b)
{
  Eigen::Matrix3Xf both(3, a.cols() + b.cols());
  both << a, b;
  return both;
}

PreparationConfig
configAt(double scale)
{
  return scaled(PreparationConfig(), scale);
}

/// A road in the open: nearly all that 64 rings see is ground, and a few cars.
Eigen::Matrix3Xf
scanOfAnOpenRoad()
{
  testing::Scene road;
  road.addBlock(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(400, 400, 1));
  for (int k = 0; k < 8; ++k)
    road.addBlock(Eigen::Vector3d(12 * k - 45, k % 2 ? 6 : -7, 0), Eigen::Vector3d(4.5, 1.8, 1.5));
  const Eigen::Vector3d sensor(0, 0, 1.9);
  return testing::castScan(road, testing::sensorPose(sensor, 0), testing::vehicleScanner(64), 3);
}

class Viewpoint : public ::testing::Test {
protected:
  /// What the sensor at a station sees, in the world's axes, with the station at the origin.
  Eigen::Matrix3Xf
  scanFrom(const Eigen::Vector3d& station, std::uint64_t seed) const
  {
    return testing::castScan(scene_, testing::sensorPose(station, 0), testing::roomScanner(0.01), seed);
  }

  testing::Scene scene_ = testing::makeFurnishedRoom(3);
  const PreparationConfig config_{};
};

TEST_F(Viewpoint, OfTheSensorIsPlausibleAndOthersAreNot)
{
  for (std::size_t s = 0; s < scene_.stations.size(); ++s) {
    const Eigen::Matrix3Xf scan = scanFrom(scene_.stations[s], s);
    EXPECT_TRUE(isPlausibleViewpoint(scan, Eigen::Vector3f::Zero(), config_)) << "station " << s;
    EXPECT_FALSE(isPlausibleViewpoint(scan, Eigen::Vector3f(1e6f, 0, 0), config_)) << "station " << s;
    EXPECT_FALSE(isPlausibleViewpoint(scan, Eigen::Vector3f(0, -100, 20), config_)) << "station " << s;
  }
}

TEST(OpenRoadViewpoint, IsPlausibleThoughTheGroundIsSeenAtAGrazingAngle)
{
  // Within a degree the ground recedes by more than a fourth of its range.
  const Eigen::Matrix3Xf scan = scanOfAnOpenRoad();
  const PreparationConfig config;
  EXPECT_TRUE(isPlausibleViewpoint(scan, Eigen::Vector3f::Zero(), config));
  for (const Eigen::Vector3f& away :
       {Eigen::Vector3f(50, 0, 0), Eigen::Vector3f(0, 50, 0), Eigen::Vector3f(-30, -40, 1), Eigen::Vector3f(0, 0, 50)})
    EXPECT_FALSE(isPlausibleViewpoint(scan, away, config)) << away.transpose();
}

TEST(OpenRoadViewpoint, IsFoundInAnotherFrameForAnyNumberOfThreads)
{
  // The ground is the same from a metre above: only its height is uncertain.
  const Eigen::Vector3f sensor(20, -40, 5);
  const Eigen::Matrix3Xf scan = scanOfAnOpenRoad().colwise() + sensor;
  const std::optional<Eigen::Vector3f> place = findViewpoint(scan, PreparationConfig(), 1);
  ASSERT_TRUE(place);
  EXPECT_LT((*place - sensor).head<2>().norm(), 1);
  EXPECT_LT(std::abs(place->z() - sensor.z()), 3);
  for (const unsigned threads : {2u, 5u})
    EXPECT_EQ(*place, findViewpoint(scan, PreparationConfig(), threads).value());
}

TEST(SparseRingsViewpoint, IsPlausibleThoughDirectionsBetweenTheRingsAreEmpty)
{
  // Sixteen rings two degrees apart, twenty times as dense along them. From above the rings lie farther apart.
  testing::SensorPattern rings = testing::vehicleScanner(16);
  rings.azimuth_step = 0.1 * kDegree;
  rings.elevation_min = -15 * kDegree;
  rings.elevation_max = 15 * kDegree;
  rings.elevation_step = 2 * kDegree;
  const testing::Scene street = testing::makeStreet(2);
  const PreparationConfig config;
  for (std::size_t s = 0; s < 3; ++s) {
    SCOPED_TRACE(::testing::Message() << "station " << s);
    const Eigen::Matrix3Xf scan = testing::castScan(street, testing::sensorPose(street.stations[s], 0), rings, 4 + s);
    EXPECT_TRUE(isPlausibleViewpoint(scan, Eigen::Vector3f::Zero(), config));
    for (const Eigen::Vector3f& away :
         {Eigen::Vector3f(50, 0, 0), Eigen::Vector3f(0, 50, 0), Eigen::Vector3f(0, 0, 50)})
      EXPECT_FALSE(isPlausibleViewpoint(scan, away, config)) << away.transpose();
  }
}

TEST_F(Viewpoint, InAFrameFarFromAMapMadeOfScansIsNone)
{
  for (std::size_t a = 0; a < scene_.stations.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      SCOPED_TRACE(::testing::Message() << "stations " << a << " and " << b);
      const Eigen::Matrix3Xf scan = scanFrom(scene_.stations[a], 1);
      Eigen::Matrix3Xf second = scanFrom(scene_.stations[b], 2);
      second.colwise() += (scene_.stations[b] - scene_.stations[a]).cast<float>();
      // The frame of a map made of them, some corner of the building. (The sensor of either is still a viewpoint.)
      EXPECT_FALSE(isPlausibleViewpoint(concatenated(scan, second), Eigen::Vector3f(-12, -9, 0), config_));
    }
}

TEST_F(Viewpoint, ScalesWithTheScene)
{
  const Eigen::Matrix3Xf scan = scanFrom(scene_.stations[0], 1);
  for (const float scale : {0.001f, 1000.f}) {
    const PreparationConfig config = configAt(static_cast<double>(scale));
    EXPECT_TRUE(isPlausibleViewpoint(scan * scale, Eigen::Vector3f::Zero(), config));
    EXPECT_FALSE(isPlausibleViewpoint(scan * scale, Eigen::Vector3f(0, 50 * scale, 0), config));
  }
}

TEST_F(Viewpoint, IsFoundInTheFrameOfABuilding)
{
  const Eigen::Vector3f corner(31, -18, 4);
  for (std::size_t s = 0; s < scene_.stations.size(); ++s) {
    SCOPED_TRACE(::testing::Message() << "station " << s);
    Eigen::Matrix3Xf scan = scanFrom(scene_.stations[s], s);
    scan.colwise() += corner;
    const std::optional<Eigen::Vector3f> place = findViewpoint(scan, config_, 1);
    ASSERT_TRUE(place);
    EXPECT_LT((*place - corner).norm(), 0.5f);
    EXPECT_TRUE(isPlausibleViewpoint(scan, *place, config_));
    // Same bits for any number of threads.
    for (const unsigned threads : {2u, 5u})
      EXPECT_EQ(*place, findViewpoint(scan, config_, threads).value());
  }
}

TEST_F(Viewpoint, FoundScalesWithTheScene)
{
  const Eigen::Matrix3Xf scan = scanFrom(scene_.stations[0], 1);
  for (const float scale : {0.001f, 1000.f}) {
    const Eigen::Matrix3Xf scaled_scan = scan * scale;
    const std::optional<Eigen::Vector3f> place = findViewpoint(scaled_scan, configAt(static_cast<double>(scale)), 1);
    ASSERT_TRUE(place);
    EXPECT_LT(place->norm(), 0.5f * scale);
  }
}

TEST(FoundViewpoint, OfACorridorIsNone)
{
  // A pipe without ends: all along it as much is seen.
  testing::Random random(5);
  Eigen::Matrix3Xf pipe(3, 60000);
  for (Eigen::Index i = 0; i < pipe.cols(); ++i) {
    const double angle = random.uniform(-3.14159, 3.14159);
    pipe.col(i) = Eigen::Vector3d(random.uniform(-40, 40), 30 * std::cos(angle), 30 * std::sin(angle)).cast<float>();
  }
  EXPECT_FALSE(findViewpoint(pipe, PreparationConfig(), 1));
}

TEST(FoundViewpoint, OfRoomsScannedThroughAWallIsNone)
{
  // Four closed rooms in a square: from each place, the walls of three rooms hide behind those of the fourth.
  Eigen::Matrix3Xf merged(3, 0);
  for (const Eigen::Vector3f& room : {Eigen::Vector3f(0, 0, 0),
                                      Eigen::Vector3f(6.2f, 0, 0),
                                      Eigen::Vector3f(0, 5.2f, 0),
                                      Eigen::Vector3f(6.2f, 5.2f, 0)}) {
    Eigen::Matrix3Xf points = testing::samplePoints(testing::roomRectangles(), 100, 3);
    points.colwise() += room;
    merged = concatenated(merged, points);
  }
  EXPECT_FALSE(findViewpoint(merged, PreparationConfig(), 1));
}

TEST(FoundViewpoint, AFewFarPointsDoNotMatter)
{
  const testing::Scene scene = testing::makeFurnishedRoom(2);
  const Eigen::Matrix3Xf scan =
      testing::castScan(scene, testing::sensorPose(scene.stations[0], 0.3, 0), testing::roomScanner(0.025), 5);
  Eigen::Matrix3Xf far(3, scan.cols() / 50);
  for (Eigen::Index i = 0; i < far.cols(); ++i)
    far.col(i) = Eigen::Vector3f(1e6f, -1e7f, 1e5f) * static_cast<float>(1 + i % 7);
  const std::optional<Eigen::Vector3f> without = findViewpoint(scan, PreparationConfig(), 1);
  const std::optional<Eigen::Vector3f> place = findViewpoint(concatenated(scan, far), PreparationConfig(), 1);
  ASSERT_TRUE(without && place);
  EXPECT_LT(without->norm(), 0.75f); // one ray in 1.4 degrees: rather far apart
  EXPECT_LT((*place - *without).norm(), 0.25f);
}

TEST_F(Viewpoint, DegenerateInputIsSurvived)
{
  const Eigen::Matrix3Xf none(3, 0);
  const Eigen::Matrix3Xf one = Eigen::Matrix3Xf::Constant(3, 1, 2.f);
  EXPECT_FALSE(findViewpoint(none, config_, 1));
  EXPECT_FALSE(findViewpoint(one, config_, 1));
  for (const float x : {0.f, 1.f, 1e6f, 1e30f, kMaxFloat})
    for (const Eigen::Index count : {1, 100})
      EXPECT_FALSE(findViewpoint(Eigen::Matrix3Xf::Constant(3, count, x), config_, 1)) << x << " " << count;
  EXPECT_FALSE(isPlausibleViewpoint(none, Eigen::Vector3f::Zero(), config_));
  const Eigen::Matrix3Xf scan = scanFrom(scene_.stations[0], 1);
  for (const float x : {kNan, kInf, -kInf, kMaxFloat})
    EXPECT_FALSE(isPlausibleViewpoint(scan, Eigen::Vector3f::Constant(x), config_)) << x;
  for (const float x : {0.f, 1.f, 1e6f, 1e30f, kMaxFloat, kNan, kInf})
    for (const Eigen::Index count : {1, 100})
      EXPECT_FALSE(isPlausibleViewpoint(Eigen::Matrix3Xf::Constant(3, count, x), Eigen::Vector3f::Zero(), config_));
}

} // namespace
} // namespace pcl_ssfr::test_viewpoint_search
