// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/dataset_simulation.h>

#include "common/angles.h"

#include <pcl_ssfr/version.h>

#include <apps/common/degrees.h>
#include <apps/common/random_stream.h>
#include <apps/io/io_error.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scan_simulation.h>
#include <apps/simulation/simulation_error.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kSuccessRotation = 2;                  // of the description [deg]
constexpr double kSuccessTranslation = 0.3;             // [m]
constexpr std::uint64_t kFrameStream = 0x6672616d65ULL; // of the random frames, apart from all other streams

bool
isFile(const std::string& name)
{
  return std::filesystem::path(name).has_extension() || name.find('/') != std::string::npos;
}

/// The name of a scene or sensor file without its folders and extension, fit for a file name.
std::string
shortName(const std::string& name)
{
  std::string stem = isFile(name) ? std::filesystem::path(name).stem().string() : name;
  for (char& c : stem)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-')
      c = '_';
  return stem;
}

/// What \p load returns; what is wrong with a file of the user is an error of input.
template <typename Load>
auto
loadNamed(const std::string& name, Load load)
{
  try {
    return load();
  }
  catch (const SimulationError& error) {
    if (isFile(name))
      throw io::IoError(error.what());
    throw;
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Poses

/// The point so far along a polyline; its end when it is shorter.
Eigen::Vector3d
pointAlong(const std::vector<Eigen::Vector3d>& path, double distance)
{
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double length = (path[i] - path[i - 1]).norm();
    if (distance <= length && length > 0)
      return path[i - 1] + (path[i] - path[i - 1]) * (distance / length);
    distance -= length;
  }
  return path.back();
}

Eigen::Isometry3d
poseAlong(const Scene& scene, const SensorModel& sensor, const PathMotion& motion)
{
  const Eigen::Vector3d axis(std::sin(motion.tilt), 0, std::cos(motion.tilt));
  Eigen::Isometry3d pose(Eigen::AngleAxisd(motion.turn, axis));
  pose.translation() =
      pointAlong(scene.path, motion.distance) + Eigen::Vector3d(0, 0, sensor.mount_height + motion.rise);
  return pose;
}

/// Headings that follow those of the poses by at most \p limit a scan; positions and tilts stay.
void
limitTurns(std::vector<Eigen::Isometry3d>& poses, double limit)
{
  const auto about_z = [](double angle) { return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()); };
  double heading = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d R = poses[i].linear();
    const double yaw = std::atan2(R(1, 0), R(0, 0));
    heading = i == 0 ? yaw : heading + std::clamp(std::remainder(yaw - heading, 2 * kPi), -limit, limit);
    poses[i].linear() = about_z(heading - yaw) * R;
  }
}

std::vector<Eigen::Isometry3d>
placeScans(const DatasetPlan& plan,
           const Scene& scene,
           const std::vector<SensorModel>& sensors,
           const RayCaster& surfaces)
{
  std::vector<Eigen::Isometry3d> poses;
  for (const PathMotion& motion : plan.motions)
    poses.push_back(poseAlong(scene, sensors.front(), motion));
  if (!poses.empty())
    return poses;
  // The scans before the first one are walked through as well, so that parts of one walk fit together.
  TrajectoryOptions options = plan.trajectory;
  options.scans = plan.start + plan.trajectory.scans;
  options.seed = plan.seed;
  options.random_rotation = false;
  poses = makeTrajectory(scene, surfaces, sensors.front(), options);
  for (std::size_t k = 1; k < sensors.size(); ++k) {
    const std::vector<Eigen::Isometry3d> others = makeTrajectory(scene, surfaces, sensors[k], options);
    for (std::size_t i = k; i < poses.size(); i += sensors.size())
      poses[i] = others[i];
  }
  if (plan.turn_limit > 0)
    limitTurns(poses, plan.turn_limit);
  return {poses.begin() + plan.start, poses.begin() + plan.start + plan.trajectory.scans};
}

// ---------------------------------------------------------------------------------------------------------------------
// Scans

ScanOptions
scanOptions(const DatasetPlan& plan, std::size_t number, unsigned threads)
{
  ScanOptions options;
  options.seed = plan.seed;
  options.scan = number;
  options.noise = plan.noise;
  options.velocity = plan.velocity * Eigen::Vector3d::UnitX();
  options.angular_velocity = plan.turn_rate * Eigen::Vector3d::UnitZ();
  options.threads = threads;
  return options;
}

bool
anythingMoves(const DatasetPlan& plan)
{
  return plan.movables.people > 0 || plan.movables.doors_move || plan.movables.moved_furniture > 0;
}

bool
hasTraffic(const Scene& scene)
{
  return std::any_of(
      scene.loose_items.begin(), scene.loose_items.end(), [](const LooseItem& item) { return item.drives; });
}

/// The scene when nothing moves; doors that are always shut are.
SurfaceModel
stillSurfaces(const Scene& scene, const DatasetPlan& plan)
{
  MovableOptions still;
  still.shut_doors = plan.movables.shut_doors;
  return surfacesAt(scene, still, plan.seed, 0);
}

/// The surfaces of every scan; built once when nothing moves.
class Stage {
public:
  Stage(const Scene& scene, const DatasetPlan& plan) : scene_(scene), plan_(plan) {}

  /// For a scan from \p T_world_sensor with the motion of \p plan during \p scan_time: nobody stands in its way.
  const RayCaster&
  at(std::size_t number, const Eigen::Isometry3d& T_world_sensor, double scan_time)
  {
    if (caster_ && !anythingMoves(plan_) && !hasTraffic(scene_))
      return *caster_;
    const Eigen::Vector3d way = plan_.velocity * scan_time * Eigen::Vector3d::UnitX();
    caster_.emplace(surfacesAt(scene_,
                               plan_.movables,
                               plan_.seed,
                               number,
                               {T_world_sensor.translation(), T_world_sensor * (way / 2), T_world_sensor * way}));
    return *caster_;
  }

private:
  const Scene& scene_;
  const DatasetPlan& plan_;
  std::optional<RayCaster> caster_;
};

/// The sensor with the number of beams of which about \p points return: counted on thinned scans from some poses.
SensorModel
withPoints(const DatasetPlan& plan,
           const Scene& scene,
           const SensorModel& sensor,
           const std::vector<Eigen::Isometry3d>& poses,
           unsigned threads)
{
  constexpr std::size_t kThinnedBeams = 20000;
  constexpr std::size_t kMostPoses = 16;
  const SensorModel thinned = withBeamCount(sensor, std::min(kThinnedBeams, beamCount(sensor)));
  Stage stage(scene, plan);
  std::size_t returns = 0;
  std::size_t fired = 0;
  const std::size_t counted = std::min(kMostPoses, poses.size());
  for (std::size_t i = 0; i < counted; ++i) {
    const std::size_t scan = i * poses.size() / counted;
    const std::size_t number = scan + static_cast<std::size_t>(plan.start);
    const SimulatedScan result = simulateScan(
        stage.at(number, poses[scan], thinned.scan_time), thinned, poses[scan], scanOptions(plan, number, threads));
    returns += result.points.size();
    fired += result.beams;
  }
  if (returns == 0)
    throw SimulationError("points: nothing returns to " + sensor.name + " in " + scene.name);
  const double wanted = static_cast<double>(plan.points) * static_cast<double>(fired) / static_cast<double>(returns);
  // Grids have whole rows and columns: ask for a little more or less where that comes nearer.
  SensorModel best = withBeamCount(sensor, static_cast<std::size_t>(std::lround(wanted)));
  const auto miss = [wanted](const SensorModel& model) {
    return std::abs(static_cast<double>(beamCount(model)) - wanted);
  };
  for (int percent = -5; percent <= 5; ++percent) {
    const SensorModel other =
        withBeamCount(sensor, static_cast<std::size_t>(std::lround(wanted * (1 + 0.01 * percent))));
    if (miss(other) < miss(best))
      best = other;
  }
  return best;
}

/// Express a scan in a frame that is rotated by \p R against the sensor's: p' = R^T p.
void
turnInto(const Eigen::Matrix3d& R, std::vector<Eigen::Vector3f>& points)
{
  for (Eigen::Vector3f& point : points)
    point = (R.transpose() * point.cast<double>()).cast<float>();
}

// ---------------------------------------------------------------------------------------------------------------------
// What is written

std::string
scanName(std::size_t number)
{
  std::array<char, 40> name{};
  std::snprintf(name.data(), name.size(), "scan%03zu.pcd", number);
  return name.data();
}

/// The short names of the plan's sensors.
std::string
sensorsName(const DatasetPlan& plan, const std::string& between)
{
  std::string text;
  for (const std::string& name : sensorsOf(plan.sensor))
    text += (text.empty() ? "" : between) + shortName(name);
  return text;
}

std::string
describe(const DatasetPlan& plan)
{
  std::string text =
      "simulated: " + shortName(plan.scene) + ", " + sensorsName(plan, ", ") + ", seed " + std::to_string(plan.seed);
  if (plan.scene_options.storeys > 0)
    text += ", " + std::to_string(plan.scene_options.storeys) + " storeys";
  if (plan.scene_options.alike)
    text += ", exactly alike";
  if (plan.movables.shut_doors > 0)
    text += ", doors shut";
  if (!plan.noise)
    text += ", no noise";
  if (plan.velocity != 0 || plan.turn_rate != 0)
    text += ", distorted by motion";
  if (anythingMoves(plan))
    text += ", things move between scans";
  if (plan.random_rotation)
    text += ", every scan in a randomly rotated frame";
  return text;
}

Json
describePlan(const PreparedPlan& prepared)
{
  const DatasetPlan& plan = prepared.plan;
  Json json;
  json["program"] = "ssfr_simulate " PCL_SSFR_VERSION;
  json["scene"] = shortName(plan.scene);
  if (plan.scene_options.storeys > 0)
    json["storeys"] = plan.scene_options.storeys;
  if (plan.scene_options.alike)
    json["alike"] = true;
  json["seed"] = plan.seed;
  json["scans"] = prepared.T_world_sensor.size();
  json["start"] = plan.start;
  json["noise"] = plan.noise;
  json["random_rotation"] = plan.random_rotation;
  json["velocity_m_s"] = plan.velocity;
  json["turn_rate_deg_s"] = plan.turn_rate * kDegreesPerRadian;
  json["people"] = plan.movables.people;
  json["doors_move"] = plan.movables.doors_move;
  if (plan.movables.shut_doors > 0)
    json["shut_doors"] = plan.movables.shut_doors;
  json["moved_furniture"] = plan.movables.moved_furniture;
  if (plan.motions.empty()) {
    json["step_m"] = plan.trajectory.step;
    json["wanted_overlap"] = plan.trajectory.overlap;
    json["turn_deg"] = plan.trajectory.turn * kDegreesPerRadian;
    json["turn_limit_deg"] = plan.turn_limit * kDegreesPerRadian;
    json["tilt_deg"] = plan.trajectory.tilt * kDegreesPerRadian;
  }
  if (prepared.sensors.size() == 1)
    json["sensor_model"] = Json::parse(formatSensor(prepared.sensors.front()));
  else
    for (const SensorModel& sensor : prepared.sensors)
      json["sensor_models"].push_back(Json::parse(formatSensor(sensor)));
  return json;
}

std::string
descriptionOf(const PreparedPlan& prepared, const DatasetSummary& summary)
{
  Json json;
  json["name"] = prepared.plan.name;
  std::string sensors;
  for (const SensorModel& sensor : prepared.sensors)
    sensors += (sensors.empty() ? "" : ",") + sensor.name;
  json["sensor"] = sensors;
  json["viewpoint"] = "sensor";
  json["success"] = {{"rotation_deg", kSuccessRotation}, {"translation_m", kSuccessTranslation}};
  json["note"] = prepared.plan.note;
  json["beams"] = summary.beams;
  json["mean_points"] = summary.mean_points;
  json["simulation"] = describePlan(prepared);
  return json.dump(1) + "\n";
}

bool
isListed(const DatasetPlan& plan, std::size_t source, std::size_t target)
{
  if (plan.pairs == PairRule::OntoFirst)
    return target == 0;
  return source - target <= static_cast<std::size_t>(plan.pair_reach);
}

/// The pairs with their overlap in the scene as it is when nothing moves.
std::vector<DatasetPair>
makePairs(const PreparedPlan& prepared, const std::vector<Eigen::Isometry3d>& T_world_scan)
{
  const RayCaster still(stillSurfaces(prepared.scene, prepared.plan));
  std::vector<DatasetPair> pairs;
  for (std::size_t source = 1; source < T_world_scan.size(); ++source)
    for (std::size_t target = 0; target < source; ++target) {
      if (!isListed(prepared.plan, source, target))
        continue;
      DatasetPair pair;
      pair.source = source;
      pair.target = target;
      pair.T_target_source = T_world_scan[target].inverse() * T_world_scan[source];
      pair.overlap = visibleOverlap(still,
                                    prepared.sensorOf(source),
                                    prepared.sensorOf(target),
                                    prepared.T_world_sensor[source],
                                    prepared.T_world_sensor[target]);
      pairs.push_back(pair);
    }
  return pairs;
}

} // namespace

std::vector<std::string>
sensorsOf(const std::string& names)
{
  if (std::filesystem::exists(names))
    return {names};
  std::vector<std::string> all;
  std::istringstream text(names);
  for (std::string name; std::getline(text, name, ',');)
    all.push_back(name);
  return all;
}

SensorModel
loadSensor(const std::string& name)
{
  return loadNamed(name, [&] { return makeSensor(name); });
}

PreparedPlan
prepare(const DatasetPlan& plan, unsigned threads)
{
  PreparedPlan prepared;
  prepared.plan = plan;
  if (isFile(plan.scene) && (plan.scene_options.storeys > 0 || plan.scene_options.alike))
    throw SimulationError("--storeys and --alike are for scenes by name, not for " + plan.scene);
  prepared.scene = loadNamed(plan.scene, [&] {
    return isFile(plan.scene) ? makeMeshScene(plan.scene) : makeScene(plan.scene, plan.seed, plan.scene_options);
  });
  if (plan.sensor.empty())
    prepared.plan.sensor = prepared.scene.recommended_sensor;
  if (prepared.plan.sensor.empty())
    throw SimulationError("--sensor is missing: " + plan.scene + " recommends none");
  for (const std::string& name : sensorsOf(prepared.plan.sensor))
    prepared.sensors.push_back(loadSensor(name));
  if (prepared.plan.name.empty())
    prepared.plan.name = shortName(plan.scene) + "_" + sensorsName(prepared.plan, "_");
  if (prepared.plan.note.empty())
    prepared.plan.note = describe(prepared.plan);
  if (plan.at_stations) {
    const auto stations = static_cast<int>(prepared.scene.stations.size());
    if (stations <= plan.start)
      throw SimulationError("--stations: " + plan.scene + " has " + std::to_string(stations) +
                            " stations, and the first scan is number " + std::to_string(plan.start));
    prepared.plan.trajectory.scans = stations - plan.start;
    prepared.plan.trajectory.step = 0;
    prepared.plan.trajectory.overlap = 0;
  }
  if (plan.beams > 0)
    for (SensorModel& sensor : prepared.sensors)
      sensor = withBeamCount(sensor, plan.beams);
  const RayCaster still(stillSurfaces(prepared.scene, plan));
  prepared.T_world_sensor = placeScans(prepared.plan, prepared.scene, prepared.sensors, still);
  if (plan.points > 0)
    for (SensorModel& sensor : prepared.sensors)
      sensor = withPoints(prepared.plan, prepared.scene, sensor, prepared.T_world_sensor, threads);
  return prepared;
}

DatasetSummary
simulateDataset(const PreparedPlan& prepared, DatasetWriter& writer, Progress& progress, unsigned threads)
{
  const DatasetPlan& plan = prepared.plan;
  DatasetSummary summary;
  summary.scans = prepared.T_world_sensor.size();
  std::vector<std::string> names;
  std::vector<Eigen::Isometry3d> T_world_scan = prepared.T_world_sensor;
  Stage stage(prepared.scene, plan);
  for (std::size_t i = 0; i < summary.scans; ++i) {
    const std::size_t number = i + static_cast<std::size_t>(plan.start);
    const SensorModel& sensor = prepared.sensorOf(i);
    ScanOptions options = scanOptions(plan, number, threads);
    options.progress = [&](double share) { progress.update(i, summary.scans, share); };
    SimulatedScan scan =
        simulateScan(stage.at(number, T_world_scan[i], sensor.scan_time), sensor, T_world_scan[i], options);
    if (scan.points.empty())
      throw SimulationError("scan " + std::to_string(number) + ": nothing returns to " + sensor.name + " in " +
                            prepared.scene.name + ", see mount_height_m and max_range_m of the sensor");
    if (plan.random_rotation) {
      const Eigen::Matrix3d R = RandomStream(plan.seed, kFrameStream, number).rotation();
      turnInto(R, scan.points);
      T_world_scan[i].linear() = T_world_scan[i].linear() * R;
    }
    names.push_back(scanName(number));
    writer.writeScan(names.back(), scan.points, scan.intensity);
    const std::size_t count = scan.points.size();
    summary.beams = scan.beams;
    summary.least_points = i == 0 ? count : std::min(summary.least_points, count);
    summary.most_points = std::max(summary.most_points, count);
    summary.mean_points += static_cast<double>(count) / static_cast<double>(summary.scans);
    progress.update(i, summary.scans, 1);
  }
  summary.pairs = makePairs(prepared, T_world_scan);
  writer.writeTruth(names, T_world_scan, summary.pairs);
  writer.writeDescription(descriptionOf(prepared, summary));
  summary.bytes = writer.bytesWritten();
  progress.finish();
  return summary;
}

} // namespace pcl_ssfr::simulation
