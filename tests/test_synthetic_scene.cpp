// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pose_matchers.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace pcl_ssfr::testing::test_synthetic_scene {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

Scene
sceneOf(const Box& box)
{
  Scene scene;
  scene.boxes.push_back(box);
  return scene;
}

/// First surface by walking along the ray in small steps and testing on which side of every surface the point lies.
std::optional<double>
marchRay(const Scene& scene, const Vector3d& origin, const Vector3d& direction, double range, double step)
{
  const auto inside = [&scene](const Vector3d& p, std::size_t body) {
    if (body < scene.boxes.size()) {
      const Box& box = scene.boxes[body];
      return ((box.axes.transpose() * (p - box.centre)).cwiseAbs().array() < box.half_size.array()).all();
    }
    body -= scene.boxes.size();
    if (body < scene.cylinders.size()) {
      const Cylinder& cylinder = scene.cylinders[body];
      const double height = (p - cylinder.centre).dot(cylinder.axis);
      return std::abs(height) < cylinder.half_height &&
             (p - cylinder.centre - height * cylinder.axis).norm() < cylinder.radius;
    }
    body -= scene.cylinders.size();
    return (p - scene.spheres[body].centre).norm() < scene.spheres[body].radius;
  };
  const std::size_t bodies = scene.boxes.size() + scene.cylinders.size() + scene.spheres.size();
  std::vector<bool> was_inside(bodies);
  for (std::size_t b = 0; b < bodies; ++b)
    was_inside[b] = inside(origin, b);
  for (double t = step; t < range; t += step) {
    for (std::size_t b = 0; b < bodies; ++b) {
      const bool is_inside = inside(origin + t * direction, b);
      const bool inward = b < scene.boxes.size() && scene.boxes[b].inward;
      if (is_inside != was_inside[b] && !(inward && is_inside))
        return t;
      was_inside[b] = is_inside;
    }
  }
  return std::nullopt;
}

Vector3d
randomDirection(Random& random)
{
  return Vector3d(random.gaussian(), random.gaussian(), random.gaussian()).normalized();
}

TEST(SyntheticScene, EmptySceneIsNeverHit)
{
  EXPECT_FALSE(castRay(Scene{}, Vector3d::Zero(), Vector3d::UnitX()));
  EXPECT_EQ(castScan(Scene{}, Eigen::Isometry3d::Identity(), SensorPattern{}, 1).cols(), 0);
}

TEST(SyntheticScene, RoomIsHitOnItsInnerFaces)
{
  const Scene scene = sceneOf(Box{Vector3d(1, 0, 0), Vector3d(3, 2, 1), Eigen::Matrix3d::Identity(), true});
  const auto hit = castRay(scene, Vector3d::Zero(), Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->distance, 4);
  EXPECT_EQ(hit->normal, Vector3d(-Vector3d::UnitX()));
  // A slanted ray reaches the ceiling first: 1 up on 2 along.
  const auto up = castRay(scene, Vector3d::Zero(), Vector3d(2, 0, 1).normalized());
  ASSERT_TRUE(up);
  EXPECT_NEAR(up->distance, std::sqrt(5.0), 1e-12);
  EXPECT_EQ(up->normal, Vector3d(-Vector3d::UnitZ()));
}

TEST(SyntheticScene, SolidBoxIsHitOnItsNearFace)
{
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(kPi / 4, Vector3d::UnitZ()).toRotationMatrix();
  const Scene scene = sceneOf(Box{Vector3d(5, 0, 0), Vector3d(1, 1, 1), axes, false});
  const auto hit = castRay(scene, Vector3d(0, 0.5, 0), Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 5 - std::sqrt(2.0) + 0.5, 1e-12); // an edge points at the sensor, half a metre aside
  EXPECT_LT(hit->normal.dot(Vector3d::UnitX()), 0);
  EXPECT_FALSE(castRay(scene, Vector3d::Zero(), -Vector3d::UnitX()));
  EXPECT_FALSE(castRay(scene, Vector3d(0, 2, 0), Vector3d::UnitX()));
}

TEST(SyntheticScene, SphereAndCylinder)
{
  Scene scene;
  scene.spheres.push_back(Sphere{Vector3d(0, 0, 0), 2});
  EXPECT_NEAR(castRay(scene, Vector3d(1, 0, 0), Vector3d::UnitX())->distance, 1, 1e-12);
  EXPECT_NEAR(castRay(scene, Vector3d(5, 0, 0), -Vector3d::UnitX())->distance, 3, 1e-12);
  scene = Scene{};
  scene.addColumn(Vector3d(4, 0, 0), 0.5, 3);
  const auto side = castRay(scene, Vector3d(0, 0, 1), Vector3d::UnitX());
  ASSERT_TRUE(side);
  EXPECT_NEAR(side->distance, 3.5, 1e-12);
  EXPECT_TRUE(side->normal.isApprox(-Vector3d::UnitX()));
  const auto top = castRay(scene, Vector3d(4.1, 0, 10), -Vector3d::UnitZ());
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->distance, 7, 1e-12);
  EXPECT_FALSE(castRay(scene, Vector3d(0, 0, 3.1), Vector3d::UnitX()));
}

TEST(SyntheticScene, RaysAgreeWithMarching)
{
  Random random(5);
  constexpr double kStep = 0.002;
  Scene scene = makeFurnishedRoom(3);
  scene.boxes.push_back(Box{Vector3d(0, 0, 1), Vector3d(0.3, 0.2, 0.4), randomRotation(random), false});
  scene.cylinders.push_back(Cylinder{Vector3d(-2, 1, 1.5), randomDirection(random), 0.3, 0.6});
  int compared = 0;
  for (int i = 0; i < 60; ++i) {
    const Vector3d direction = randomDirection(random);
    const auto hit = castRay(scene, scene.stations[0], direction);
    const auto marched = marchRay(scene, scene.stations[0], direction, 20, kStep);
    ASSERT_EQ(hit.has_value(), marched.has_value());
    // Marching may jump over a corner that is thinner than a step: then it finds something farther.
    EXPECT_LT(hit->distance, *marched + 1e-9);
    if (*marched - hit->distance <= kStep)
      ++compared;
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
    EXPECT_LE(hit->normal.dot(direction), 0);
  }
  EXPECT_GE(compared, 58);
}

TEST(SyntheticScene, ScanPointsLieOnTheSurfaces)
{
  const Scene scene = makeHall(2);
  const Eigen::Isometry3d T_world_sensor = sensorPose(scene.stations[0], 2.0, 0.1);
  SensorPattern pattern = terrestrialScanner(0.05);
  pattern.range_noise = 0;
  const ScanWithNormals scan = castScanWithNormals(scene, T_world_sensor, pattern, 1);
  ASSERT_GT(scan.points.cols(), 4000);
  for (Eigen::Index i = 0; i < scan.points.cols(); i += 37) {
    const Vector3d point = T_world_sensor * scan.points.col(i).cast<double>();
    const Vector3d direction = (point - scene.stations[0]).normalized();
    const auto hit = castRay(scene, scene.stations[0], direction);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, (point - scene.stations[0]).norm(), 2e-3); // float points; slant of the surface
    EXPECT_LE(scan.normals.col(i).dot(scan.points.col(i)), 0);
  }
}

TEST(SyntheticScene, NoiseAndDropOutsAreAsAsked)
{
  const Scene scene = makeSphereInside();
  SensorPattern pattern = roomScanner(0.02);
  pattern.range_noise = 0.02;
  const Eigen::Isometry3d centre = Eigen::Isometry3d::Identity();
  const Eigen::Matrix3Xf all = castScan(scene, centre, pattern, 7);
  const Eigen::ArrayXd error = all.cast<double>().colwise().norm().transpose().array() - 6;
  EXPECT_NEAR(error.mean(), 0, 5e-4);
  EXPECT_NEAR(std::sqrt(error.square().mean()), 0.02, 5e-4);
  pattern.drop_rate = 0.25;
  const Eigen::Matrix3Xf some = castScan(scene, centre, pattern, 7);
  EXPECT_NEAR(static_cast<double>(some.cols()) / static_cast<double>(all.cols()), 0.75, 0.01);
}

TEST(SyntheticScene, SameSeedSameBytes)
{
  for (const bool street : {false, true}) {
    const Scene first = street ? makeStreet(4) : makeFurnishedRoom(4);
    const Scene second = street ? makeStreet(4) : makeFurnishedRoom(4);
    const Scene other = street ? makeStreet(5) : makeFurnishedRoom(5);
    SensorPattern pattern = roomScanner(0.05);
    const Eigen::Isometry3d T = sensorPose(first.stations[1], 0.3, 0.2);
    const Eigen::Matrix3Xf a = castScan(first, T, pattern, 9);
    const Eigen::Matrix3Xf b = castScan(second, T, pattern, 9);
    ASSERT_EQ(a.cols(), b.cols());
    EXPECT_TRUE(a == b);
    const Eigen::Matrix3Xf noisier = castScan(first, T, pattern, 10);
    EXPECT_FALSE(noisier.cols() == a.cols() && noisier == a);
    const Eigen::Matrix3Xf elsewhere = castScan(other, T, pattern, 9);
    EXPECT_FALSE(elsewhere.cols() == a.cols() && elsewhere == a);
  }
}

TEST(SyntheticScene, RandomNumbersAreUniformAndNormal)
{
  Random random(1);
  constexpr int kCount = 100000;
  Eigen::ArrayXd uniform(kCount);
  Eigen::ArrayXd gaussian(kCount);
  for (int i = 0; i < kCount; ++i) {
    uniform[i] = random.uniform(-1, 3);
    gaussian[i] = random.gaussian();
  }
  EXPECT_GE(uniform.minCoeff(), -1);
  EXPECT_LT(uniform.maxCoeff(), 3);
  EXPECT_NEAR(uniform.mean(), 1, 0.02);
  EXPECT_NEAR(gaussian.mean(), 0, 0.02);
  EXPECT_NEAR(gaussian.square().mean(), 1, 0.02);
  EXPECT_NEAR(gaussian.square().square().mean(), 3, 0.1);
}

TEST(SyntheticScene, StationsAreFreeAndInside)
{
  Random random(11);
  const auto check = [&random](const Scene& scene, const std::string& name, double free) {
    SCOPED_TRACE(name);
    ASSERT_GE(scene.stations.size(), 2U);
    for (const Vector3d& station : scene.stations) {
      for (int i = 0; i < 500; ++i) {
        Vector3d direction = randomDirection(random);
        const auto hit = castRay(scene, station, direction);
        if (hit) {
          EXPECT_GT(hit->distance, free);
        }
      }
    }
  };
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    check(makeFurnishedRoom(seed), "furnished room " + std::to_string(seed), 0.2);
    check(makeHall(seed), "hall " + std::to_string(seed), 0.3);
    check(makeStreet(seed), "street " + std::to_string(seed), 0.5);
    check(makeUnrelatedRooms(seed).second, "unrelated room " + std::to_string(seed), 0.2);
  }
  check(makeSymmetricRoom(), "symmetric room", 0.2);
}

TEST(SyntheticScene, SymmetricRoomIsSymmetric)
{
  const Scene scene = makeSymmetricRoom();
  const Eigen::Matrix3d half_turn = Eigen::AngleAxisd(kPi, Vector3d::UnitZ()).toRotationMatrix();
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction = randomDirection(random);
    const auto hit = castRay(scene, scene.stations[0], direction);
    const auto twin = castRay(scene, half_turn * scene.stations[0], half_turn * direction);
    ASSERT_TRUE(hit && twin);
    EXPECT_NEAR(hit->distance, twin->distance, 1e-9);
  }
}

TEST(SyntheticScene, CorridorLooksTheSameAllAlong)
{
  const Scene scene = makeEndlessCorridor();
  SensorPattern pattern = roomScanner(0.03);
  pattern.range_noise = 0;
  const Vector3d& station = scene.stations[0];
  const Eigen::Matrix3Xf here = castScan(scene, sensorPose(station, 0.4), pattern, 1);
  const Eigen::Matrix3Xf there = castScan(scene, sensorPose(station + Vector3d(7, 0, 0), 0.4), pattern, 1);
  ASSERT_EQ(here.cols(), there.cols());
  EXPECT_LT((here - there).cwiseAbs().maxCoeff(), 1e-4F);
}

TEST(PoseMatchers, MeasureRotationAndTranslation)
{
  Random random(3);
  const Eigen::Isometry3d T = randomMotion(random, 10);
  EXPECT_THAT(T, IsPoseNear(T, 1e-7, 1e-7));
  EXPECT_THAT(T.cast<float>(), IsPoseNear(T, 1e-5, 1e-4));
  EXPECT_THAT(Eigen::Matrix4f(T.cast<float>().matrix()), IsPoseNear(T, 1e-5, 1e-4));

  Eigen::Isometry3d rotated = T;
  rotated.rotate(Eigen::AngleAxisd(0.1, randomDirection(random)));
  EXPECT_THAT(rotated, IsPoseNear(T, 0.1001, 1e-6));
  EXPECT_THAT(rotated, ::testing::Not(IsPoseNear(T, 0.0999, 1e-6)));
  EXPECT_NEAR(poseError(rotated, T).rotation, 0.1, 1e-9);

  // A translation of the same length in another direction is an error, not a match.
  Eigen::Isometry3d moved = T;
  moved.translation() = -T.translation();
  EXPECT_THAT(moved, ::testing::Not(IsPoseNear(T, kPi, T.translation().norm())));
  EXPECT_NEAR(poseError(moved, T).translation, 2 * T.translation().norm(), 1e-9);

  Eigen::Matrix4d mirrored = T.matrix();
  mirrored.col(0) *= -1;
  EXPECT_THAT(mirrored, ::testing::Not(IsPoseNear(T, 10.0, 100.0)));
  EXPECT_THAT(Eigen::Matrix4d::Zero().eval(), ::testing::Not(IsPoseNear(T, 10.0, 100.0)));
}

TEST(PoseMatchers, HalfTurnIsPi)
{
  Eigen::Isometry3d half_turn = Eigen::Isometry3d::Identity();
  half_turn.rotate(Eigen::AngleAxisd(kPi, Vector3d::UnitY()));
  EXPECT_NEAR(poseError(half_turn, Eigen::Isometry3d::Identity()).rotation, kPi, 1e-9);
}

} // namespace
} // namespace pcl_ssfr::testing::test_synthetic_scene
