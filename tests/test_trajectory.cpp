// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scenes.h>
#include <apps/simulation/sensor_model.h>
#include <apps/simulation/simulation_error.h>
#include <apps/simulation/trajectory.h>

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr::simulation::test_trajectory {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
constexpr double kLength = 10; // of the box room [m]
constexpr double kWidth = 6;
constexpr double kHeight = 3;

/// Looks everywhere, without noise of its own.
SensorModel
ball(double max_range = 30)
{
  SensorModel sensor;
  sensor.name = "ball";
  sensor.pattern.kind = PatternKind::Sphere;
  sensor.pattern.azimuth_min = -kPi;
  sensor.pattern.azimuth_max = kPi;
  sensor.pattern.azimuth_count = 180;
  sensor.pattern.elevation_min = -kPi / 2;
  sensor.pattern.elevation_max = kPi / 2;
  sensor.pattern.elevation_count = 91;
  sensor.range.min_range = 0.01;
  sensor.range.max_range = max_range;
  sensor.mount_height = 1.5;
  return sensor;
}

/// An empty box with one corner at the origin and a path like an L.
Scene
boxScene()
{
  Scene scene;
  scene.name = "box";
  SurfaceModel& m = scene.surfaces;
  m.addBlock({kLength / 2, kWidth / 2, 0}, {kLength, kWidth, kHeight}, 0, m.addMaterial("plaster", 0.7));
  scene.path = {{1, 1, 0}, {5, 1, 0}, {5, 4, 0}};
  scene.natural_step = 0.7;
  return scene;
}

Eigen::Isometry3d
at(const Eigen::Vector3d& position, double yaw = 0)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = position;
  return T;
}

/// The wall of the box that a ray from inside meets, computed by hand.
double
boxDistance(const Eigen::Vector3d& from, const Eigen::Vector3d& direction)
{
  const Eigen::Vector3d size(kLength, kWidth, kHeight);
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i)
    if (direction[i] != 0)
      nearest = std::min(nearest, ((direction[i] > 0 ? size[i] : 0) - from[i]) / direction[i]);
  return nearest;
}

double
headingOf(const Eigen::Isometry3d& T)
{
  return std::atan2(T.linear()(1, 0), T.linear()(0, 0));
}

class Trajectory : public ::testing::Test {
protected:
  std::vector<Eigen::Isometry3d>
  make(const TrajectoryOptions& options) const
  {
    return makeTrajectory(scene_, caster_, sensor_, options);
  }
  std::string
  errorOf(const TrajectoryOptions& options) const
  {
    try {
      make(options);
    }
    catch (const SimulationError& error) {
      return error.what();
    }
    return "no error";
  }

  Scene scene_ = boxScene();
  RayCaster caster_{scene_.surfaces};
  SensorModel sensor_ = ball();
};

TEST_F(Trajectory, StepsAlongThePathAndBack)
{
  TrajectoryOptions options;
  options.scans = 11;
  options.step = 1.5;
  options.turn = 0;
  const auto poses = make(options);
  ASSERT_EQ(poses.size(), 11U);
  // The path is 4 m along x and 3 m along y: 0 1.5 3 4.5 6, back from 7: 6.5 5 3.5 2 0.5, forth from 0: 1.
  const std::vector<Eigen::Vector2d> expected{
      {1, 1}, {2.5, 1}, {4, 1}, {5, 1.5}, {5, 3}, {5, 3.5}, {5, 2}, {4.5, 1}, {3, 1}, {1.5, 1}, {2, 1}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR((poses[i].translation().head<2>() - expected[i]).norm(), 0, 1e-12) << i;
    EXPECT_NEAR(poses[i].translation().z(), sensor_.mount_height, 1e-12);
  }
  // It looks along the path, upright, on the way back too.
  for (const std::size_t i : {0U, 1U, 8U, 9U, 10U})
    EXPECT_NEAR(headingOf(poses[i]), 0, 1e-12);
  for (const std::size_t i : {3U, 4U, 5U, 6U})
    EXPECT_NEAR(headingOf(poses[i]), kPi / 2, 0.2);
  for (const auto& T : poses)
    EXPECT_NEAR((T.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-12);
}

TEST_F(Trajectory, NaturalStepByDefault)
{
  TrajectoryOptions options;
  options.scans = 5;
  const auto poses = make(options);
  for (std::size_t i = 1; i < poses.size(); ++i)
    EXPECT_NEAR((poses[i].translation() - poses[i - 1].translation()).norm(), 0.7, 1e-12);
  options.scans = 1;
  EXPECT_EQ(make(options).size(), 1U);
}

TEST_F(Trajectory, TurnAndTiltAreBounded)
{
  TrajectoryOptions options;
  options.scans = 200;
  options.step = 0.01; // within the straight first part
  options.turn = 0.3;
  options.tilt = 0.1;
  const auto poses = make(options);
  double most_turn = 0;
  double most_tilt = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d& R = poses[i].linear();
    EXPECT_NEAR((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    const double pitch = std::asin(-R(2, 0));
    const double roll = std::atan2(R(2, 1), R(2, 2));
    EXPECT_LE(std::abs(pitch), 0.1 + 1e-12);
    EXPECT_LE(std::abs(roll), 0.1 + 1e-12);
    most_tilt = std::max({most_tilt, std::abs(pitch), std::abs(roll)});
    if (i > 0) {
      const double turn = std::abs(headingOf(poses[i]) - headingOf(poses[i - 1]));
      EXPECT_LE(turn, 0.3 + 1e-12);
      most_turn = std::max(most_turn, turn);
    }
  }
  EXPECT_GT(most_turn, 0.2);
  EXPECT_GT(most_tilt, 0.08);
}

TEST_F(Trajectory, RandomRotationTurnsEveryScanByItself)
{
  TrajectoryOptions options;
  options.scans = 300;
  const auto plain = make(options);
  options.random_rotation = true;
  const auto rotated = make(options);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].translation(), rotated[i].translation());
    EXPECT_NEAR(rotated[i].linear().determinant(), 1, 1e-12);
    mean += rotated[i].linear().col(2) / static_cast<double>(plain.size());
    if (i > 0) {
      EXPECT_GT((rotated[i].linear() - rotated[i - 1].linear()).norm(), 1e-3);
    }
  }
  EXPECT_LT(mean.norm(), 0.2); // no direction is preferred
}

TEST_F(Trajectory, SeedDecidesEveryBit)
{
  TrajectoryOptions options;
  options.scans = 20;
  options.tilt = 0.1;
  options.random_rotation = true;
  const auto first = make(options);
  const auto again = make(options);
  options.seed = 2;
  const auto other = make(options);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].matrix(), again[i].matrix());
    EXPECT_NE(first[i].matrix(), other[i].matrix());
  }
}

TEST_F(Trajectory, NamesTheSettingThatIsWrong)
{
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto member, auto value) {
    TrajectoryOptions options;
    options.*member = value;
    return options;
  };
  EXPECT_THAT(errorOf(with(&TrajectoryOptions::scans, 0)), AllOf(HasSubstr("scans"), HasSubstr("0")));
  for (const double step : {-1.0, kNan, std::numeric_limits<double>::infinity()})
    EXPECT_THAT(errorOf(with(&TrajectoryOptions::step, step)), HasSubstr("step"));
  for (const double overlap : {-0.1, 1.0, 1.5, kNan})
    EXPECT_THAT(errorOf(with(&TrajectoryOptions::overlap, overlap)), HasSubstr("overlap"));
  for (const double angle : {-0.1, 4.0, kNan}) {
    EXPECT_THAT(errorOf(with(&TrajectoryOptions::turn, angle)), HasSubstr("turn"));
    EXPECT_THAT(errorOf(with(&TrajectoryOptions::tilt, angle)), HasSubstr("tilt"));
  }
  TrajectoryOptions both;
  both.step = 1;
  both.overlap = 0.5;
  EXPECT_THAT(errorOf(both), HasSubstr("step"));
  Scene point = scene_;
  point.path.resize(1);
  EXPECT_THROW(makeTrajectory(point, caster_, sensor_, {}), SimulationError);
  TrajectoryOptions one;
  one.scans = 1;
  EXPECT_EQ(makeTrajectory(point, caster_, sensor_, one).size(), 1U);
  point.path.clear();
  EXPECT_THROW(makeTrajectory(point, caster_, sensor_, one), SimulationError);
}

TEST_F(Trajectory, OverlapThatCannotBe)
{
  // In an empty box everything is seen from everywhere.
  TrajectoryOptions options;
  options.scans = 4;
  options.overlap = 0.5;
  EXPECT_THAT(errorOf(options), AllOf(HasSubstr("overlap"), HasSubstr("0.5"), HasSubstr("1 to 1")));
}

TEST(WantedOverlap, IsReached)
{
  struct Case {
    const char* scene;
    const char* sensor;
    double overlap;
  };
  for (const Case& c : {Case{"apartment", "hokuyo_utm30lx", 0.7},
                        Case{"office_floor", "velodyne_vlp16", 0.5},
                        Case{"hall", "leica_p20", 0.6},
                        Case{"street", "velodyne_hdl32e", 0.6}}) {
    SCOPED_TRACE(c.scene);
    const Scene scene = makeScene(c.scene, 1);
    const RayCaster caster(surfacesAt(scene, {}, 1, 0));
    const SensorModel sensor = makeSensor(c.sensor);
    TrajectoryOptions options;
    options.scans = 6;
    options.overlap = c.overlap;
    const auto poses = makeTrajectory(scene, caster, sensor, options);
    ASSERT_EQ(poses.size(), 6U);
    double sum = 0;
    for (std::size_t i = 1; i < poses.size(); ++i)
      sum += visibleOverlap(caster, sensor, poses[i], poses[i - 1], 3000) / 5;
    EXPECT_NEAR(sum, c.overlap, 0.05);
    const auto again = makeTrajectory(scene, caster, sensor, options);
    for (std::size_t i = 0; i < poses.size(); ++i)
      EXPECT_EQ(poses[i].matrix(), again[i].matrix());
  }
}

TEST(VisibleOverlap, IsWholeInAnEmptyBox)
{
  const Scene scene = boxScene();
  const RayCaster caster(scene.surfaces);
  EXPECT_EQ(visibleOverlap(caster, ball(), at({2, 2, 1}), at({2, 2, 1})), 1);
  EXPECT_EQ(visibleOverlap(caster, ball(), at({2, 2, 1}), at({8, 5, 2}, 1)), 1);
  EXPECT_THROW(visibleOverlap(caster, ball(), at({2, 2, 1}), at({8, 5, 2}), 0), SimulationError);
}

TEST(VisibleOverlap, IsNothingBehindAWall)
{
  Scene scene = boxScene();
  // As thin as can be: each side is seen from its own room only.
  scene.surfaces.addPolygon({{5, 0, 0}, {5, 6, 0}, {5, 6, 3}, {5, 0, 3}}, 0);
  const RayCaster caster(scene.surfaces);
  EXPECT_EQ(visibleOverlap(caster, ball(), at({2, 2, 1}), at({8, 2, 1})), 0);
  EXPECT_EQ(visibleOverlap(caster, ball(), at({2, 2, 1}), at({4, 2, 1})), 1);
  // Nothing seen at all.
  EXPECT_EQ(visibleOverlap(caster, ball(0.5), at({2, 3, 1.5}), at({2, 3, 1.5})), 0);
}

/// The share by hand: beams of the source, walls by formula, range and elevation of the target.
double
overlapByHand(const SensorModel& sensor,
              const Eigen::Isometry3d& source,
              const Eigen::Isometry3d& target,
              double lowest,
              double highest)
{
  int seen = 0;
  int shared = 0;
  for (std::size_t i = 0; i < beamCount(sensor); ++i) {
    const Eigen::Vector3d direction = source.linear() * beamAt(sensor, i, 0).direction;
    const double distance = boxDistance(source.translation(), direction);
    if (distance > sensor.range.max_range || distance < sensor.range.min_range)
      continue;
    ++seen;
    const Eigen::Vector3d local = target.inverse() * (source.translation() + distance * direction);
    const double elevation = std::asin(local.z() / local.norm());
    if (local.norm() <= sensor.range.max_range && local.norm() >= sensor.range.min_range && elevation >= lowest &&
        elevation <= highest)
      ++shared;
  }
  return static_cast<double>(shared) / seen;
}

TEST(VisibleOverlap, AgreesWithGeometryOfABox)
{
  const Scene scene = boxScene();
  const RayCaster caster(scene.surfaces);
  // Range decides.
  for (const double range : {2.5, 3.5, 5.0}) {
    const SensorModel sensor = ball(range);
    const Eigen::Isometry3d source = at({3, 3, 1.4}, 0.3);
    const Eigen::Isometry3d target = at({4.5, 2, 1.6}, -1);
    const double expected = overlapByHand(sensor, source, target, -2, 2);
    EXPECT_GT(expected, 0.1);
    EXPECT_LT(expected, 0.99);
    EXPECT_NEAR(visibleOverlap(caster, sensor, source, target, 20000), expected, 0.002) << range;
    EXPECT_NEAR(visibleOverlap(caster, sensor, source, target), expected, 0.04) << range;
  }
  // Field of view decides: rings within 15 degrees of level, the outermost count half a gap more.
  SensorModel rings = ball();
  rings.pattern.kind = PatternKind::Rings;
  rings.pattern.azimuth_count = 720;
  for (int i = -15; i <= 15; i += 2)
    rings.pattern.ring_elevations.push_back(i * kPi / 180);
  const double edge = 16 * kPi / 180;
  for (const double z : {1.0, 1.5, 2.4}) {
    const Eigen::Isometry3d source = at({2.5, 3, 1.4});
    const Eigen::Isometry3d target = at({6, 2, z}, 2);
    const double expected = overlapByHand(rings, source, target, -edge, edge);
    EXPECT_NEAR(visibleOverlap(caster, rings, source, target, 20000), expected, 0.002) << z;
  }
  EXPECT_LT(overlapByHand(rings, at({2.5, 3, 1.4}), at({6, 2, 2.4}), -edge, edge), 0.8);
  // A ball that looks up only, and only half way round.
  SensorModel dome = ball();
  dome.pattern.elevation_min = 0.2;
  dome.pattern.elevation_max = 1.2;
  const double expected = overlapByHand(dome, at({2.5, 3, 1.4}), at({6, 2, 1}, 2), 0.2, 1.2);
  EXPECT_NEAR(visibleOverlap(caster, dome, at({2.5, 3, 1.4}), at({6, 2, 1}, 2), 20000), expected, 0.002);
  SensorModel half = ball();
  half.pattern.azimuth_min = -kPi / 2;
  half.pattern.azimuth_max = kPi / 2;
  EXPECT_NEAR(visibleOverlap(caster, half, at({5, 3, 1.5}), at({5, 3, 1.5})), 1, 1e-12);
  // Both see the poles and the edge between them.
  EXPECT_NEAR(visibleOverlap(caster, half, at({5, 3, 1.5}), at({5, 3, 1.5}, kPi)), 0, 0.04);
  EXPECT_NEAR(visibleOverlap(caster, half, at({5, 3, 1.5}), at({5, 3, 1.5}, kPi / 2)), 0.5, 0.06);
}

TEST(VisibleOverlap, KnowsWhereATurningLineLooks)
{
  const Scene scene = boxScene();
  const RayCaster caster(scene.surfaces);
  for (const char* name : {"hokuyo_utm30lx", "sick_lms200"}) {
    SCOPED_TRACE(name);
    SensorModel sensor = makeSensor(name);
    sensor.range.min_range = 0.01;
    // At its own place it sees what it sees.
    EXPECT_GT(visibleOverlap(caster, sensor, at({5, 3, 1.5}), at({5, 3, 1.5})), 0.995);
    // Upside down: the oracle asks whether some beam points within 2 degrees.
    const Eigen::Isometry3d source = at({5, 3, 1.5});
    Eigen::Isometry3d target = at({5, 3, 1.5});
    target.linear() = Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, 0.4, 0.2).normalized()).toRotationMatrix();
    std::vector<Eigen::Vector3d> beams;
    for (std::size_t i = 0; i < beamCount(sensor); i += 13)
      beams.push_back(beamAt(sensor, i, 0).direction);
    RandomStream random(1);
    int shared = 0;
    constexpr int kBeams = 1500;
    for (int i = 0; i < kBeams; ++i) {
      const auto index = static_cast<std::size_t>(random.index(static_cast<int>(beamCount(sensor))));
      const Eigen::Vector3d wanted = target.linear().transpose() * source.linear() * beamAt(sensor, index, 0).direction;
      for (const Eigen::Vector3d& beam : beams)
        if (beam.dot(wanted) > std::cos(2 * kPi / 180)) {
          ++shared;
          break;
        }
    }
    EXPECT_NEAR(visibleOverlap(caster, sensor, source, target, 5000), static_cast<double>(shared) / kBeams, 0.05);
  }
}

} // namespace
} // namespace pcl_ssfr::simulation::test_trajectory
