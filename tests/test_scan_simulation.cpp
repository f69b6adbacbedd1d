// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scan_simulation.h>
#include <apps/simulation/simulation_error.h>

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <thread>

namespace pcl_ssfr::simulation::test_scan_simulation {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
constexpr double kDegree = kPi / 180;
constexpr double kFloat = 2e-6; // of coordinates of some ten metres kept in single precision, relative

Eigen::Isometry3d
at(const Eigen::Vector3d& position)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = position;
  return T;
}

/// A wall across the x axis, 200 m wide and high.
SurfaceModel
wallAt(double x, double reflectance = 0.9)
{
  SurfaceModel model;
  model.addPolygon({{x, -100, -100}, {x, 100, -100}, {x, 100, 100}, {x, -100, 100}},
                   model.addMaterial("wall", reflectance));
  return model;
}

SurfaceModel
room()
{
  SurfaceModel model;
  model.addBox(Eigen::Isometry3d::Identity(), {10, 8, 6}, model.addMaterial("wall", 0.6));
  model.spheres.push_back({{2, 1, 0}, 0.5, model.addMaterial("ball", 0.9)});
  model.tubes.push_back({{-2, 1, -3}, {0, 0, 1}, 6, 0.3, 0});
  return model;
}

/// 100 x 200 beams of a scanner without flaws, within \p half degrees of the x axis.
SensorModel
perfectSensor(double half = 1)
{
  SensorModel sensor;
  sensor.name = "perfect";
  sensor.pattern.kind = PatternKind::Sphere;
  sensor.pattern.azimuth_min = -half * kDegree;
  sensor.pattern.azimuth_max = half * kDegree;
  sensor.pattern.azimuth_count = 200;
  sensor.pattern.elevation_min = -half * kDegree;
  sensor.pattern.elevation_max = half * kDegree;
  sensor.pattern.elevation_count = 100;
  sensor.range.min_range = 0.5;
  sensor.range.max_range = 30;
  sensor.range.reference_reflectance = 0.9;
  sensor.range.sigma = 0;
  sensor.range.quantum = 0;
  sensor.scan_time = 0.5;
  return sensor;
}

SimulatedScan
scanOf(const SurfaceModel& model,
       const SensorModel& sensor,
       const ScanOptions& options = {},
       const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity())
{
  SimulatedScan scan = simulateScan(RayCaster(model), sensor, T, options);
  EXPECT_EQ(scan.beams, beamCount(sensor));
  EXPECT_EQ(scan.points.size() + scan.lost + scan.out_of_range, scan.beams);
  EXPECT_EQ(scan.points.size(), scan.intensity.size());
  EXPECT_EQ(scan.points.size(), scan.beam.size());
  return scan;
}

ScanOptions
noiseless()
{
  ScanOptions options;
  options.noise = false;
  return options;
}

struct Moments {
  double mean = 0;
  double sigma = 0;
};

Moments
momentsOf(const std::vector<double>& values)
{
  Moments moments;
  for (const double value : values)
    moments.mean += value / static_cast<double>(values.size());
  for (const double value : values)
    moments.sigma += (value - moments.mean) * (value - moments.mean) / static_cast<double>(values.size());
  moments.sigma = std::sqrt(moments.sigma);
  return moments;
}

double
rangeOf(const SimulatedScan& scan, std::size_t i)
{
  return scan.points[i].cast<double>().norm();
}

/// Range errors against a wall across the x axis at \p distance.
std::vector<double>
wallErrors(const SimulatedScan& scan, const SensorModel& sensor, double distance)
{
  std::vector<double> errors;
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    errors.push_back(rangeOf(scan, i) - distance / beamAt(sensor, scan.beam[i], 0).direction.x());
  return errors;
}

void
expectSame(const SimulatedScan& a, const SimulatedScan& b)
{
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.intensity, b.intensity);
  EXPECT_EQ(a.beam, b.beam);
  EXPECT_EQ(a.lost, b.lost);
  EXPECT_EQ(a.out_of_range, b.out_of_range);
  EXPECT_EQ(a.mixed, b.mixed);
}

std::string
errorOf(const std::function<void()>& action)
{
  try {
    action();
  }
  catch (const SimulationError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ScanSimulation, WithoutNoiseEveryPointIsOnItsSurface)
{
  SensorModel sensor = makeSensor("hokuyo_utm30lx");
  sensor = withBeamCount(sensor, 20000);
  const SurfaceModel model = room();
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()));
  T.pretranslate(Eigen::Vector3d(0.5, -1, 0.4));
  const SimulatedScan scan = scanOf(model, sensor, noiseless(), T);
  EXPECT_EQ(scan.points.size(), scan.beams);
  EXPECT_EQ(scan.mixed, 0U);
  int round = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const Eigen::Vector3d local = scan.points[i].cast<double>();
    ASSERT_LT((local.normalized() - beamAt(sensor, scan.beam[i], 0).direction).norm(), kFloat);
    const Eigen::Vector3d point = T * local;
    const double wall = (Eigen::Vector3d(5, 4, 3) - point.cwiseAbs()).cwiseAbs().minCoeff();
    const double ball = std::abs((point - model.spheres[0].centre).norm() - 0.5);
    const double tube = std::abs((point - model.tubes[0].base).head<2>().norm() - 0.3);
    ASSERT_LT(std::min({wall, ball, tube}), 10 * kFloat) << point.transpose();
    round += wall > 1e-3 ? 1 : 0;
  }
  EXPECT_GT(round, 100);
}

TEST(ScanSimulation, IntensityIsReflectanceTimesCosine)
{
  const SensorModel sensor = perfectSensor(40);
  const SimulatedScan scan = scanOf(wallAt(5, 0.7), sensor, noiseless());
  ASSERT_EQ(scan.points.size(), scan.beams);
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    ASSERT_NEAR(scan.intensity[i], 0.7 * beamAt(sensor, scan.beam[i], 0).direction.x(), 1e-6);
}

TEST(ScanSimulation, NoiseHasItsMeanAndSigma)
{
  SensorModel sensor = perfectSensor();
  sensor.range.sigma = 0.01;
  sensor.range.sigma_per_metre = 0.001;
  sensor.range.bias = 0.004;
  for (const double distance : {5.0, 25.0}) {
    const SimulatedScan scan = scanOf(wallAt(distance), sensor);
    ASSERT_EQ(scan.points.size(), scan.beams);
    const Moments moments = momentsOf(wallErrors(scan, sensor, distance));
    const double sigma = 0.01 + 0.001 * distance;
    EXPECT_NEAR(moments.mean, 0.004, 4 * sigma / std::sqrt(20000.0));
    EXPECT_NEAR(moments.sigma, sigma, 4 * sigma / std::sqrt(2 * 20000.0));
  }
}

TEST(ScanSimulation, NoiseIsNormalAndNotCorrelated)
{
  SensorModel sensor = perfectSensor();
  sensor.range.sigma = 0.02;
  const std::vector<double> errors = wallErrors(scanOf(wallAt(10), sensor), sensor, 10);
  const auto count = static_cast<double>(errors.size());
  int within = 0;
  double next = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    within += std::abs(errors[i]) < 0.02 ? 1 : 0;
    if (i > 0)
      next += errors[i] * errors[i - 1] / (0.02 * 0.02);
  }
  EXPECT_NEAR(within / count, 0.6827, 4 * std::sqrt(0.6827 * 0.3173 / count));
  EXPECT_NEAR(next / count, 0, 4 / std::sqrt(count));
}

TEST(ScanSimulation, RangesAreMultiplesOfTheQuantum)
{
  SensorModel sensor = perfectSensor();
  sensor.range.sigma = 0.03;
  sensor.range.quantum = 0.01;
  const SimulatedScan scan = scanOf(wallAt(7), sensor);
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const double steps = rangeOf(scan, i) / 0.01;
    ASSERT_NEAR(steps, std::round(steps), 1e-3);
  }
}

TEST(ScanSimulation, LossesHaveTheirRate)
{
  SensorModel sensor = perfectSensor();
  sensor.range.drop_rate = 0.2;
  const SimulatedScan scan = scanOf(wallAt(10), sensor);
  const auto beams = static_cast<double>(scan.beams);
  EXPECT_NEAR(static_cast<double>(scan.lost) / beams, 0.2, 4 * std::sqrt(0.2 * 0.8 / beams));
}

TEST(ScanSimulation, DarkSurfacesAreLostEarlier)
{
  const SensorModel sensor = perfectSensor(); // 30 m at 0.9
  EXPECT_EQ(scanOf(wallAt(29.9, 0.9), sensor).lost, 0U);
  EXPECT_EQ(scanOf(wallAt(20, 0.9), sensor).lost, 0U);
  EXPECT_EQ(scanOf(wallAt(20, 0.1), sensor).points.size(), 0U);
  EXPECT_EQ(scanOf(wallAt(9.9, 0.1), sensor).lost, 0U); // 30 m * sqrt(0.1 / 0.9) = 10 m
  EXPECT_EQ(scanOf(wallAt(11.3, 0.1), sensor).points.size(), 0U);
  // Between all and nothing: 0.9 of the signal comes back half of the time.
  const double distance = 10 / std::sqrt(0.9);
  const SimulatedScan half = scanOf(wallAt(distance, 0.1), perfectSensor(0.1));
  EXPECT_NEAR(static_cast<double>(half.lost) / static_cast<double>(half.beams), 0.5, 0.02);
  // Without noise only the range counts.
  EXPECT_EQ(scanOf(wallAt(20, 0.1), sensor, noiseless()).points.size(), half.beams);
}

TEST(ScanSimulation, GrazingBeamsAreLost)
{
  SurfaceModel floor;
  floor.addPolygon({{-100, -100, -1}, {100, -100, -1}, {100, 100, -1}, {-100, 100, -1}},
                   floor.addMaterial("floor", 0.5));
  SensorModel sensor = perfectSensor();
  sensor.pattern.elevation_min = -60 * kDegree;
  sensor.pattern.elevation_max = -2 * kDegree;
  const SimulatedScan scan = scanOf(floor, sensor);
  const double needed = 0.9 / (30.0 * 30.0);
  std::size_t sure = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double sine = -beamAt(sensor, i, 0).direction.z(); // = cosine of incidence = 1 / range
    sure += 0.5 * sine * sine * sine >= needed ? 1 : 0;
  }
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const double sine = 1 / rangeOf(scan, i);
    ASSERT_GE(0.5 * sine * sine * sine, 0.8 * needed * (1 - 1e-5));
  }
  EXPECT_GE(scan.points.size(), sure);
  EXPECT_GT(scan.lost, 1000U);
}

TEST(ScanSimulation, RangeLimitsHold)
{
  const SensorModel sensor = perfectSensor();
  for (const ScanOptions& options : {ScanOptions(), noiseless()}) {
    EXPECT_EQ(scanOf(wallAt(0.3), sensor, options).out_of_range, 20000U);
    EXPECT_EQ(scanOf(wallAt(31), sensor, options).out_of_range, 20000U);
    EXPECT_EQ(scanOf(wallAt(-5), sensor, options).out_of_range, 20000U);
    EXPECT_EQ(scanOf(wallAt(1), sensor, options).points.size(), 20000U);
  }
  // What is too near still hides what is behind it.
  SurfaceModel two = wallAt(5);
  two.append(wallAt(0.3));
  EXPECT_EQ(scanOf(two, sensor).out_of_range, 20000U);
}

TEST(ScanSimulation, OneSeedOneScanWhateverTheThreads)
{
  const SensorModel sensor = withBeamCount(makeSensor("velodyne_hdl32e"), 30000);
  const RayCaster caster(room());
  const auto simulate = [&](unsigned threads, std::uint64_t seed, std::size_t number) {
    ScanOptions options;
    options.threads = threads;
    options.seed = seed;
    options.scan = number;
    options.velocity = {1, 0, 0};
    return simulateScan(caster, sensor, Eigen::Isometry3d::Identity(), options);
  };
  const SimulatedScan one = simulate(1, 7, 3);
  EXPECT_GT(one.points.size(), 20000U);
  EXPECT_GT(one.mixed, 0U);
  EXPECT_GT(one.lost, 0U);
  expectSame(one, simulate(1, 7, 3));
  expectSame(one, simulate(2, 7, 3));
  expectSame(one, simulate(8, 7, 3));
  expectSame(one, simulate(0, 7, 3));
  EXPECT_NE(one.points, simulate(1, 7, 4).points);
  EXPECT_NE(one.points, simulate(1, 8, 3).points);
  expectSame(one, simulateScan(RayCaster(room()), sensor, Eigen::Isometry3d::Identity(), [] {
               ScanOptions options;
               options.seed = 7;
               options.scan = 3;
               options.velocity = {1, 0, 0};
               return options;
             }()));
}

TEST(ScanSimulation, DrivingAtAWallBringsItNearer)
{
  const SensorModel sensor = perfectSensor(20);
  ScanOptions options = noiseless();
  options.velocity = {8, 0, 0};
  const SimulatedScan scan = scanOf(wallAt(12), sensor, options);
  ASSERT_EQ(scan.points.size(), scan.beams);
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    ASSERT_NEAR(scan.points[i].x(), 12 - 8 * beamAt(sensor, scan.beam[i], 0).time, 1e-5);
  EXPECT_LT(scan.points.back().x(), 8.01F);
}

TEST(ScanSimulation, TurningBendsAWall)
{
  const SensorModel sensor = perfectSensor(20);
  ScanOptions options = noiseless();
  options.angular_velocity = {0, 0, 1.2};
  const SimulatedScan scan = scanOf(wallAt(10), sensor, options);
  ASSERT_EQ(scan.points.size(), scan.beams);
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const Beam beam = beamAt(sensor, scan.beam[i], 0);
    const double range = 10 / (std::cos(beam.elevation) * std::cos(beam.azimuth + 1.2 * beam.time));
    ASSERT_NEAR(rangeOf(scan, i), range, 2e-5);
  }
}

TEST(ScanSimulation, MotionIsTheExponentialOfItsTwist)
{
  const SensorModel sensor = withBeamCount(perfectSensor(60), 2000);
  const Eigen::Isometry3d T = at({1, 0.5, -0.2}) * Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 0).normalized());
  ScanOptions options = noiseless();
  options.velocity = {3, -2, 1};
  options.angular_velocity = {0.5, -1.5, 2};
  Eigen::Matrix4d twist = Eigen::Matrix4d::Zero();
  twist.topLeftCorner<3, 3>() << 0, -2, -1.5, 2, 0, -0.5, 1.5, 0.5, 0;
  twist.topRightCorner<3, 1>() = options.velocity;
  const SimulatedScan scan = scanOf(room(), sensor, options, T);
  ASSERT_EQ(scan.points.size(), scan.beams);
  int on_walls = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const double time = beamAt(sensor, scan.beam[i], 0).time;
    Eigen::Matrix4d motion = Eigen::Matrix4d::Identity(); // the power series
    Eigen::Matrix4d term = motion;
    for (int k = 1; k < 30; ++k) {
      term = term * twist * time / k;
      motion += term;
    }
    const Eigen::Vector4d local = scan.points[i].cast<double>().homogeneous();
    const Eigen::Vector3d point = (T.matrix() * motion * local).head<3>();
    const double wall = (Eigen::Vector3d(5, 4, 3) - point.cwiseAbs()).cwiseAbs().minCoeff();
    const double ball = std::abs((point - Eigen::Vector3d(2, 1, 0)).norm() - 0.5);
    const double tube = std::abs((point - Eigen::Vector3d(-2, 1, 0)).head<2>().norm() - 0.3);
    ASSERT_LT(std::min({wall, ball, tube}), 10 * kFloat) << "beam " << i;
    on_walls += wall < 1e-4 ? 1 : 0;
  }
  EXPECT_GT(on_walls, 1000);
}

TEST(ScanSimulation, JitterMovesTheBeamButNotItsReportedDirection)
{
  SurfaceModel slanted; // 45 degrees to the beams, so that an angle shows as range
  slanted.addPolygon({{-40, -50, -100}, {60, 50, -100}, {60, 50, 100}, {-40, -50, 100}},
                     slanted.addMaterial("wall", 0.9));
  SensorModel sensor = perfectSensor(0.01);
  sensor.range.angular_jitter = 0.002;
  const SimulatedScan scan = scanOf(slanted, sensor);
  std::vector<double> ranges;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    ASSERT_LT((scan.points[i].cast<double>().normalized() - beamAt(sensor, scan.beam[i], 0).direction).norm(), kFloat);
    ranges.push_back(rangeOf(scan, i));
  }
  // The wall crosses the x axis at 10 m; dr = r tan(45 degrees) d(azimuth).
  const Moments moments = momentsOf(ranges);
  EXPECT_NEAR(moments.sigma, 10 * 0.002, 0.05 * 10 * 0.002);
  EXPECT_NEAR(moments.mean, 10, 0.002);
}

/// A plate at 5 m left of the x axis (y > 0) before a wall at \p back.
SurfaceModel
edge(double back)
{
  SurfaceModel model = wallAt(back);
  model.addPolygon({{5, 0, -100}, {5, 100, -100}, {5, 100, 100}, {5, 0, 100}}, 0);
  return model;
}

TEST(ScanSimulation, EdgesMixRangesWithinAPulse)
{
  SensorModel sensor = perfectSensor();
  sensor.range.sigma = 0.002;
  sensor.range.beam_divergence = 0.5 * kDegree;
  sensor.range.pulse_length = 0.5;
  const SimulatedScan scan = scanOf(edge(5.3), sensor);
  ASSERT_EQ(scan.points.size(), scan.beams);
  std::size_t between = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const Beam beam = beamAt(sensor, scan.beam[i], 0);
    const double plate = 5 / beam.direction.x();
    const double wall = 5.3 / beam.direction.x();
    const double range = rangeOf(scan, i);
    ASSERT_GT(range, plate - 0.02);
    ASSERT_LT(range, wall + 0.02);
    const bool mixed = range > plate + 0.01 && range < wall - 0.01;
    between += mixed ? 1 : 0;
    if (std::abs(beam.azimuth) > 0.26 * kDegree) {
      ASSERT_FALSE(mixed) << beam.azimuth / kDegree; // the footprint does not reach the edge
    }
  }
  // The edge lies in the beam for a quarter of the beams, and in the direction that is looked in for most of these.
  EXPECT_GT(scan.mixed, 1000U);
  EXPECT_LT(scan.mixed, 5000U);
  EXPECT_GT(between, scan.mixed / 2);
}

TEST(ScanSimulation, FarApartSurfacesDoNotMix)
{
  SensorModel sensor = perfectSensor();
  sensor.range.sigma = 0.002;
  sensor.range.beam_divergence = 0.5 * kDegree;
  sensor.range.pulse_length = 0.5;
  const SimulatedScan scan = scanOf(edge(9), sensor);
  EXPECT_EQ(scan.mixed, 0U);
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const Beam beam = beamAt(sensor, scan.beam[i], 0);
    const double x = rangeOf(scan, i) * beam.direction.x();
    ASSERT_TRUE(std::abs(x - 5) < 0.02 || std::abs(x - 9) < 0.02);
    beyond += x < 6 && beam.azimuth < 0 ? 1 : 0;
  }
  EXPECT_GT(beyond, 100U); // the plate is also returned by beams just off its edge: the stronger return counts
}

TEST(ScanSimulation, FlatSurfacesNeverMix)
{
  SensorModel sensor = perfectSensor(60);
  sensor.range.beam_divergence = 0.5 * kDegree;
  sensor.range.beam_diameter = 0.01;
  sensor.range.sigma = 0.001;
  EXPECT_EQ(scanOf(wallAt(4), sensor).mixed, 0U);
  sensor.range.beam_divergence = 0;
  sensor.range.beam_diameter = 0;
  EXPECT_EQ(scanOf(edge(5.3), sensor).mixed, 0U); // no footprint
}

TEST(ScanSimulation, HalfABeamIsHalfASignal)
{
  // A plate alone, at a distance where a whole footprint just suffices.
  SurfaceModel plate;
  plate.addPolygon({{29, 0, -100}, {29, 100, -100}, {29, 100, 100}, {29, 0, 100}}, plate.addMaterial("plate", 0.9));
  SensorModel sensor = perfectSensor();
  EXPECT_EQ(scanOf(plate, sensor).lost, 0U);
  sensor.range.beam_divergence = 0.5 * kDegree;
  const SimulatedScan scan = scanOf(plate, sensor);
  EXPECT_GT(scan.lost, 500U);
  EXPECT_LT(scan.lost, 3000U);
}

TEST(ScanSimulation, BeamsThatMeetNothingAreCounted)
{
  SurfaceModel model;
  model.spheres.push_back({{10, 0, 0}, 0.05, model.addMaterial("ball", 0.9)});
  const SimulatedScan scan = scanOf(model, perfectSensor(45));
  EXPECT_GT(scan.out_of_range, 19900U);
  SurfaceModel around;
  around.spheres.push_back({{0.5, 0, 0}, 3, around.addMaterial("ball", 0.9)});
  EXPECT_EQ(scanOf(around, withBeamCount(makeSensor("velodyne_vlp16"), 5000), noiseless()).out_of_range, 0U);
}

TEST(ScanSimulation, ProgressComesFromTheCallersThreadAndEndsAtOne)
{
  std::vector<double> shares;
  ScanOptions options = noiseless();
  options.threads = 4;
  const auto caller = std::this_thread::get_id();
  options.progress = [&](double share) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    shares.push_back(share);
  };
  scanOf(wallAt(5), withBeamCount(perfectSensor(), 600000), options);
  ASSERT_GE(shares.size(), 2U);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1);
}

TEST(ScanSimulation, BadArgumentsAreNamed)
{
  const RayCaster caster(wallAt(5));
  const SensorModel sensor = perfectSensor();
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto simulate = [&](const SensorModel& model, const Eigen::Isometry3d& T, const ScanOptions& options = {}) {
    return errorOf([&] { simulateScan(caster, model, T, options); });
  };
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_EQ(simulate(sensor, here), "no error");
  EXPECT_THAT(simulate(sensor, at({kNaN, 0, 0})), AllOf(HasSubstr("position"), HasSubstr("nan")));
  Eigen::Isometry3d bent = here;
  bent.linear()(0, 0) = 2;
  EXPECT_THAT(simulate(sensor, bent), HasSubstr("rotation of the sensor"));
  bent.linear()(0, 0) = kNaN;
  EXPECT_THAT(simulate(sensor, bent), HasSubstr("rotation of the sensor"));
  bent.linear() = -Eigen::Matrix3d::Identity();
  EXPECT_THAT(simulate(sensor, bent), HasSubstr("rotation of the sensor"));
  ScanOptions options;
  options.velocity.y() = kNaN;
  EXPECT_THAT(simulate(sensor, here, options), HasSubstr("velocity is (0, nan, 0)"));
  options = {};
  options.angular_velocity.z() = INFINITY;
  EXPECT_THAT(simulate(sensor, here, options), HasSubstr("angular velocity"));
  SensorModel none = sensor;
  none.pattern.azimuth_count = 0;
  EXPECT_THAT(simulate(none, here), HasSubstr("azimuth_count is 0"));
}

} // namespace
} // namespace pcl_ssfr::simulation::test_scan_simulation
