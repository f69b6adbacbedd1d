// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/sensor_model.h>
#include <apps/simulation/simulation_error.h>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <set>

namespace pcl_ssfr::simulation::test_sensor_model {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kPi = 3.141592653589793;
constexpr double kDegree = kPi / 180;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

std::string
parseError(const std::string& json)
{
  return errorOf([&] { parseSensor(json, "my.json"); });
}

nlohmann::json
smallSphere()
{
  return nlohmann::json::parse(R"json({
    "name": "s",
    "pattern": {"kind": "sphere", "azimuth_min_deg": 0, "azimuth_max_deg": 360, "azimuth_count": 4,
                "elevation_min_deg": -30, "elevation_max_deg": 60, "elevation_count": 3},
    "range": {"min_range_m": 0.5, "max_range_m": 20, "reference_reflectance": 0.5, "sigma_m": 0.01}
  })json");
}

/// The message for a sensor whose field at \p path is set to \p value.
std::string
errorWith(const std::string& path, const nlohmann::json& value)
{
  nlohmann::json json = smallSphere();
  json[nlohmann::json::json_pointer(path)] = value;
  return parseError(json.dump());
}

TEST(SensorModel, NamesAreTheOnesOfTheInterface)
{
  EXPECT_THAT(sensorNames(),
              ElementsAre("hokuyo_utm30lx",
                          "leica_p20",
                          "velodyne_hdl32e",
                          "velodyne_vlp16",
                          "sick_lms200",
                          "livox_mid360",
                          "ouster_os1_128",
                          "livox_avia",
                          "aeva_aeries2"));
  for (const std::string& name : sensorNames()) {
    const SensorModel sensor = makeSensor(name);
    EXPECT_EQ(sensor.name, name);
    EXPECT_FALSE(sensor.sources.empty()) << name;
    EXPECT_FALSE(sensor.description.empty()) << name;
    EXPECT_NO_THROW(validate(sensor));
  }
  EXPECT_THAT(errorOf([] { makeSensor("kinect"); }), AllOf(HasSubstr("'kinect'"), HasSubstr("leica_p20")));
}

TEST(SensorModel, NarrowSensorsLookAhead)
{
  // Half of the view in azimuth and the ends in elevation, as their makers state them [deg].
  const auto widest = [](const char* name) {
    const SensorModel sensor = makeSensor(name);
    Eigen::Vector2d most(0, 0);
    for (std::size_t i = 0; i < beamCount(sensor); ++i) {
      const Beam beam = beamAt(sensor, i, 0);
      most = most.cwiseMax(Eigen::Vector2d(std::abs(std::remainder(beam.azimuth, 2 * M_PI)), std::abs(beam.elevation)));
    }
    return (most * 180 / M_PI).eval();
  };
  EXPECT_TRUE(widest("livox_avia").isApprox(Eigen::Vector2d(35.2, 38.6), 1e-3));
  EXPECT_TRUE(widest("aeva_aeries2").isApprox(Eigen::Vector2d(60, 15), 1e-3));
  EXPECT_NEAR(widest("ouster_os1_128").y(), 22.5, 1e-9);
  EXPECT_EQ(beamCount(makeSensor("ouster_os1_128")), 128U * 1024U);
}

TEST(SensorModel, BeamCountsAreNearThePaper)
{
  // Beams, of which some meet nothing: at least as many as the paper's points, and not twice as many.
  for (const auto& [name, points] : std::vector<std::pair<std::string, double>>{
           {"hokuyo_utm30lx", 365000}, {"leica_p20", 9e6}, {"velodyne_hdl32e", 56000}, {"sick_lms200", 81600}}) {
    const auto beams = static_cast<double>(beamCount(makeSensor(name)));
    EXPECT_GE(beams, points) << name;
    EXPECT_LT(beams, 1.3 * points) << name;
  }
  EXPECT_EQ(beamCount(makeSensor("livox_mid360")), 200000U);
  EXPECT_EQ(beamCount(makeSensor("velodyne_vlp16")), 16U * 1808U);
}

TEST(SensorModel, EveryBeamIsConsistent)
{
  for (const std::string& name : sensorNames()) {
    const SensorModel sensor = withBeamCount(makeSensor(name), 3000);
    const std::size_t count = beamCount(sensor);
    double last = -1;
    for (std::size_t i = 0; i < count; ++i) {
      const Beam beam = beamAt(sensor, i, 0);
      const double c = std::cos(beam.elevation);
      const Eigen::Vector3d expected(c * std::cos(beam.azimuth), c * std::sin(beam.azimuth), std::sin(beam.elevation));
      ASSERT_LT((beam.direction - expected).norm(), 1e-7) << name << " beam " << i;
      ASSERT_NEAR(beam.direction.norm(), 1, 1e-12);
      ASSERT_GT(beam.time, last);
      last = beam.time;
    }
    EXPECT_GE(beamAt(sensor, 0, 0).time, 0);
    EXPECT_LT(last, sensor.scan_time);
  }
}

TEST(SensorModel, RingsAreTheDataSheets)
{
  const SensorModel hdl = makeSensor("velodyne_hdl32e");
  ASSERT_EQ(hdl.pattern.ring_elevations.size(), 32U);
  EXPECT_NEAR(hdl.pattern.ring_elevations.front() / kDegree, -30.67, 1e-9);
  EXPECT_NEAR(hdl.pattern.ring_elevations.back() / kDegree, 10.67, 1e-9);
  for (std::size_t i = 1; i < 32; ++i)
    EXPECT_NEAR((hdl.pattern.ring_elevations[i] - hdl.pattern.ring_elevations[i - 1]) / kDegree, 41.34 / 31, 0.01);
  const SensorModel vlp = makeSensor("velodyne_vlp16");
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_NEAR(vlp.pattern.ring_elevations[i] / kDegree, -15 + 2 * static_cast<double>(i), 1e-9);
  // All rings of one azimuth are fired before the next azimuth; the ring says which elevation a beam has.
  for (const std::size_t i : {0U, 31U, 32U, 1000U}) {
    const Beam beam = beamAt(hdl, i, 0);
    EXPECT_EQ(beam.ring, static_cast<int>(i % 32));
    EXPECT_EQ(beam.elevation, hdl.pattern.ring_elevations[i % 32]);
    const std::size_t shot = i / 32;
    EXPECT_NEAR(beam.azimuth, 2 * kPi * static_cast<double>(shot) / hdl.pattern.azimuth_count, 1e-12);
  }
}

TEST(SensorModel, AFullTurnIsCoveredOnce)
{
  const SensorModel sensor = makeSensor("velodyne_vlp16");
  const auto columns = static_cast<std::size_t>(sensor.pattern.azimuth_count);
  std::vector<double> azimuths;
  for (std::size_t i = 0; i < columns; ++i)
    azimuths.push_back(beamAt(sensor, i * 16, 0).azimuth);
  const double step = 2 * kPi / static_cast<double>(columns);
  for (std::size_t i = 1; i < columns; ++i)
    ASSERT_NEAR(azimuths[i] - azimuths[i - 1], step, 1e-9);
  EXPECT_NEAR(azimuths.front() + 2 * kPi - azimuths.back(), step, 1e-9); // the seam is no wider and nothing is doubled
}

TEST(SensorModel, ASphereHasItsRowsAndColumns)
{
  const SensorModel sensor = parseSensor(smallSphere().dump(), "test");
  ASSERT_EQ(beamCount(sensor), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    const Beam beam = beamAt(sensor, i, 0);
    const std::size_t shot = i / 3;
    EXPECT_NEAR(beam.azimuth / kDegree, 90 * static_cast<double>(shot), 1e-9);
    EXPECT_NEAR(beam.elevation / kDegree, -30 + 45 * static_cast<double>(i % 3), 1e-9);
  }
}

TEST(SensorModel, ATurningLineSweeps)
{
  const SensorModel sensor = makeSensor("sick_lms200");
  const BeamPattern& pattern = sensor.pattern;
  // The first line starts at the right (-90 degrees); its middle looks 50 degrees down.
  EXPECT_LT((beamAt(sensor, 0, 0).direction - Eigen::Vector3d(0, -1, 0)).norm(), 1e-9);
  const Beam middle = beamAt(sensor, 180, 0);
  EXPECT_NEAR(middle.elevation / kDegree, -50, 1e-9);
  EXPECT_NEAR(middle.azimuth, 0, 1e-9);
  // The last line looks 70 degrees up and ends at the left.
  const auto lines = static_cast<std::size_t>(pattern.turn_count);
  EXPECT_NEAR(beamAt(sensor, 361 * (lines - 1) + 180, 0).elevation / kDegree, 70, 1e-9);
  EXPECT_LT((beamAt(sensor, 361 * lines - 1, 0).direction - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);
  // Neighbours in a line are half a degree apart.
  const double cosine = beamAt(sensor, 1000, 0).direction.dot(beamAt(sensor, 1001, 0).direction);
  EXPECT_NEAR(std::acos(cosine) / kDegree, 0.5, 1e-6);
}

TEST(SensorModel, TheRosetteFillsItsFieldAndDoesNotRepeat)
{
  const SensorModel sensor = makeSensor("livox_mid360");
  const std::size_t count = beamCount(sensor);
  constexpr int kColumns = 180; // cells of 2 degrees
  constexpr int kRows = 30;
  std::set<int> cells;
  double nearest_same = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Beam beam = beamAt(sensor, i, 0);
    ASSERT_GE(beam.elevation / kDegree, -7 - 1e-9);
    ASSERT_LE(beam.elevation / kDegree, 52 + 1e-9);
    const int column = std::min(kColumns - 1, static_cast<int>(beam.azimuth / kDegree / 2));
    const int row = std::min(kRows - 1, static_cast<int>((beam.elevation / kDegree + 7) / 59 * kRows));
    cells.insert(row * kColumns + column);
    if (i % 97 == 0)
      nearest_same = std::min(nearest_same, (beam.direction - beamAt(sensor, i, 1).direction).norm());
  }
  EXPECT_EQ(cells.size(), static_cast<std::size_t>(kColumns * kRows)); // no hole
  EXPECT_GT(nearest_same, 0.01);                                       // the next scan goes elsewhere
  // Two scans together come nearer to a random direction than one: the second fills gaps of the first.
  const SensorModel sparse = withBeamCount(sensor, 2000);
  double one = 0;
  double both = 0;
  for (int k = 0; k < 200; ++k) {
    const double azimuth = 2 * kPi * std::fmod(k * 0.618033988749895, 1);
    const double elevation = (-5 + 55 * (k + 0.5) / 200) * kDegree;
    const double c = std::cos(elevation);
    const Eigen::Vector3d target(c * std::cos(azimuth), c * std::sin(azimuth), std::sin(elevation));
    double first = 2;
    double second = 2;
    for (std::size_t i = 0; i < beamCount(sparse); ++i) {
      first = std::min(first, (beamAt(sparse, i, 0).direction - target).norm());
      second = std::min(second, (beamAt(sparse, i, 1).direction - target).norm());
    }
    one += first;
    both += std::min(first, second);
  }
  EXPECT_LT(both, 0.8 * one);
}

TEST(SensorModel, BeamCountsCanBeSet)
{
  for (const std::string& name : sensorNames()) {
    const SensorModel sensor = makeSensor(name);
    for (const std::size_t wanted : {1000U, 20000U, 500000U}) {
      const SensorModel scaled = withBeamCount(sensor, wanted);
      // Rings are kept: whole columns of them.
      const double column = static_cast<double>(sensor.pattern.ring_elevations.size());
      EXPECT_NEAR(static_cast<double>(beamCount(scaled)),
                  static_cast<double>(wanted),
                  std::max(0.02 * static_cast<double>(wanted), column / 2))
          << name;
      EXPECT_NO_THROW(validate(scaled));
    }
    EXPECT_EQ(beamCount(withBeamCount(sensor, beamCount(sensor))), beamCount(sensor)) << name;
    EXPECT_GE(beamCount(withBeamCount(sensor, 1)), 1U);
    EXPECT_THAT(errorOf([&] { withBeamCount(sensor, 0); }), HasSubstr("number of beams is 0"));
    EXPECT_THAT(errorOf([&] { withBeamCount(sensor, 1ULL << 40U); }), HasSubstr("number of beams"));
  }
  // Both directions alike.
  const SensorModel quarter = withBeamCount(makeSensor("leica_p20"), beamCount(makeSensor("leica_p20")) / 4);
  EXPECT_NEAR(quarter.pattern.azimuth_count, 5027 / 2.0, 2);
  EXPECT_NEAR(quarter.pattern.elevation_count, 2025 / 2.0, 2);
}

TEST(SensorModel, TextReadsBackToTheSameSensor)
{
  for (const std::string& name : sensorNames()) {
    const SensorModel sensor = makeSensor(name);
    const std::string text = formatSensor(sensor);
    const SensorModel again = parseSensor(text, "again");
    EXPECT_EQ(formatSensor(again), text) << name;
    EXPECT_EQ(again.sources, sensor.sources);
    EXPECT_EQ(again.pattern.ring_elevations, sensor.pattern.ring_elevations);
    EXPECT_EQ(again.range.beam_divergence, sensor.range.beam_divergence);
    EXPECT_EQ(again.range.angular_jitter, sensor.range.angular_jitter);
    EXPECT_EQ(again.mount_height, sensor.mount_height);
    ASSERT_EQ(beamCount(again), beamCount(sensor));
    for (std::size_t i = 0; i < beamCount(sensor); i += 1009) {
      ASSERT_EQ(beamAt(again, i, 3).direction, beamAt(sensor, i, 3).direction) << name;
      ASSERT_EQ(beamAt(again, i, 3).time, beamAt(sensor, i, 3).time) << name;
    }
  }
}

TEST(SensorModel, FilesAreRead)
{
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "pcl_ssfr_sensor.json").string();
  std::ofstream(path) << smallSphere().dump();
  EXPECT_EQ(makeSensor(path).range.max_range, 20);
  std::ofstream(path) << "{";
  EXPECT_THAT(errorOf([&] { makeSensor(path); }), HasSubstr(path + ": is not JSON"));
  std::filesystem::remove(path);
  EXPECT_EQ(errorOf([&] { makeSensor(path); }), path + ": no such file");
}

TEST(SensorModel, FieldsLeftOutHaveDefaults)
{
  const SensorModel sensor = parseSensor(smallSphere().dump(), "test");
  EXPECT_EQ(sensor.range.bias, 0);
  EXPECT_EQ(sensor.range.drop_rate, 0);
  EXPECT_EQ(sensor.scan_time, 0);
  EXPECT_EQ(sensor.mount_height, SensorModel().mount_height);
}

TEST(SensorModel, BadTextIsNamed)
{
  for (const char* text : {"", "[]", "7", "{", "{\"name\": NaN}", "\xff\xfe"})
    EXPECT_THAT(parseError(text), AllOf(HasSubstr("my.json: "), Not(HasSubstr("\n")))) << text;
  EXPECT_THAT(errorWith("/max_range", 3), AllOf(HasSubstr("my.json: field 'max_range' is not known"), HasSubstr("3")));
  EXPECT_THAT(errorWith("/range/sigma", 3), HasSubstr("field range.'sigma' is not known"));
  EXPECT_THAT(errorWith("/pattern/line_count", 3), HasSubstr("field pattern.'line_count' is not known"));
  EXPECT_THAT(errorWith("/pattern/kind", "spiral"), AllOf(HasSubstr("pattern.kind"), HasSubstr("\"spiral\"")));
  EXPECT_THAT(errorWith("/pattern/kind", "rings"), HasSubstr("ring_elevations_deg is missing"));
  EXPECT_THAT(errorWith("/pattern", 5), HasSubstr("pattern is 5"));
  EXPECT_THAT(errorWith("/pattern/azimuth_count", 0), HasSubstr("pattern.azimuth_count is 0"));
  EXPECT_THAT(errorWith("/pattern/azimuth_count", -4), HasSubstr("pattern.azimuth_count is -4"));
  EXPECT_THAT(errorWith("/pattern/azimuth_count", 2.5), HasSubstr("pattern.azimuth_count is 2.5"));
  EXPECT_THAT(errorWith("/pattern/azimuth_count", 1e12), HasSubstr("pattern.azimuth_count is"));
  EXPECT_THAT(errorWith("/pattern/azimuth_count", "4"), HasSubstr("pattern.azimuth_count is \"4\""));
  EXPECT_THAT(errorWith("/pattern/azimuth_max_deg", 400), HasSubstr("pattern.azimuth_max_deg is 400"));
  EXPECT_THAT(errorWith("/pattern/azimuth_max_deg", -10), HasSubstr("pattern.azimuth_max_deg is -10"));
  EXPECT_THAT(errorWith("/pattern/elevation_max_deg", 95), HasSubstr("pattern.elevation_max_deg is 95"));
  EXPECT_THAT(errorWith("/pattern/elevation_min_deg", 70), HasSubstr("pattern.elevation_max_deg is 60"));
  EXPECT_THAT(errorWith("/range/sigma_m", -0.1), HasSubstr("range.sigma_m is -0.1"));
  EXPECT_THAT(errorWith("/range/sigma_m", "0.1"), HasSubstr("range.sigma_m is \"0.1\""));
  EXPECT_THAT(errorWith("/range/sigma_m", nullptr), HasSubstr("range.sigma_m is null"));
  EXPECT_THAT(errorWith("/range/max_range_m", 0.2), HasSubstr("range.max_range_m is 0.2"));
  EXPECT_THAT(errorWith("/range/reference_reflectance", 0), HasSubstr("range.reference_reflectance is 0"));
  EXPECT_THAT(errorWith("/range/reference_reflectance", 1.2), HasSubstr("range.reference_reflectance is 1.2"));
  EXPECT_THAT(errorWith("/range/drop_rate", 1), HasSubstr("range.drop_rate is 1"));
  EXPECT_THAT(errorWith("/range/beam_divergence_deg", 120), HasSubstr("range.beam_divergence_deg is 120"));
  EXPECT_THAT(errorWith("/scan_time_s", -1), HasSubstr("scan_time_s is -1"));
  EXPECT_THAT(errorWith("/name", 4), HasSubstr("name is 4"));
  EXPECT_THAT(errorWith("/name", ""), HasSubstr("name is empty"));
  EXPECT_THAT(errorWith("/sources", "me"), HasSubstr("sources is \"me\""));
  nlohmann::json json = smallSphere();
  json["range"].erase("max_range_m");
  EXPECT_THAT(parseError(json.dump()), HasSubstr("field range.max_range_m is missing"));
  json.erase("range");
  EXPECT_THAT(parseError(json.dump()), HasSubstr("field range is missing"));
}

TEST(SensorModel, BadStructsAreNamed)
{
  const auto broken = [](const std::string& name, const std::function<void(SensorModel&)>& breakIt) {
    SensorModel sensor = makeSensor(name);
    breakIt(sensor);
    return errorOf([&] { validate(sensor); });
  };
  EXPECT_THAT(broken("leica_p20", [](SensorModel& s) { s.range.sigma = kNaN; }), HasSubstr("range.sigma_m is nan"));
  EXPECT_THAT(broken("leica_p20", [](SensorModel& s) { s.range.bias = INFINITY; }), HasSubstr("range.bias_m is inf"));
  EXPECT_THAT(broken("leica_p20", [](SensorModel& s) { s.pattern.azimuth_min = kNaN; }), HasSubstr("azimuth_min_deg"));
  EXPECT_THAT(broken("leica_p20", [](SensorModel& s) { s.pattern.elevation_count = 0; }),
              HasSubstr("pattern.elevation_count is 0"));
  EXPECT_THAT(broken("leica_p20", [](SensorModel& s) { s.pattern.azimuth_count = 2000000000; }),
              HasSubstr("number of beams"));
  EXPECT_THAT(broken("velodyne_vlp16", [](SensorModel& s) { s.pattern.ring_elevations.clear(); }),
              HasSubstr("ring_elevations_deg is empty"));
  EXPECT_THAT(broken("velodyne_vlp16", [](SensorModel& s) { s.pattern.ring_elevations[3] = 2; }),
              HasSubstr("ring_elevations_deg[3]"));
  EXPECT_THAT(broken("sick_lms200",
                     [](SensorModel& s) {
                       s.pattern.turn_axis = {0, 0, 3};
                     }),
              HasSubstr("pattern.turn_axis is (0, 0, 3)"));
  EXPECT_THAT(broken("sick_lms200", [](SensorModel& s) { s.pattern.plane_axes.col(1).setZero(); }),
              HasSubstr("plane_sideways"));
  EXPECT_THAT(broken("sick_lms200", [](SensorModel& s) { s.pattern.line_max = s.pattern.line_min; }),
              HasSubstr("pattern.line_max_deg is -90"));
}

} // namespace
} // namespace pcl_ssfr::simulation::test_sensor_model
