// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/trajectory.h>

#include "common/angles.h"

#include <apps/common/random_stream.h>
#include <apps/simulation/simulation_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

namespace pcl_ssfr::simulation {

namespace {

using Poses = std::vector<Eigen::Isometry3d>;

constexpr double kGolden = 0.6180339887498949; // its multiples spread evenly over [0, 1)

constexpr double kHeadingWindow = 0.4; // the heading is that of the path so far before and behind [m]

// Search for the step that gives a wanted overlap.
constexpr double kOverlapTolerance = 0.02; // aimed at
constexpr double kOverlapAccepted = 0.05;  // an answer farther off is an error
constexpr double kSmallestStep = 0.05;     // [m]
constexpr int kGridSteps = 14;             // tried first, in a geometric row up to the length of the path
constexpr int kBisections = 12;
constexpr std::size_t kMostPairs = 24; // whose overlap is averaged, evenly taken
constexpr std::size_t kPairRays = 600; // beams of each

// Streams of random numbers of the poses.
constexpr std::uint64_t kTiltStream = 1;
constexpr std::uint64_t kRotationStream = 2;

void
requireValid(const TrajectoryOptions& options)
{
  if (options.scans < 1)
    fail("scans", options.scans, "1 or more");
  if (!(options.step >= 0) || !std::isfinite(options.step))
    fail("step", options.step, "0 or more metres");
  if (!(options.overlap >= 0 && options.overlap < 1))
    fail("overlap", options.overlap, "a share in (0, 1), or 0 when the step is given");
  if (options.overlap > 0 && options.step > 0)
    fail("step", options.step, "0 when an overlap is wanted: the overlap decides the step");
  if (!(options.turn >= 0 && options.turn <= kPi))
    fail("turn", options.turn, "an angle in [0, pi]");
  if (!(options.tilt >= 0 && options.tilt <= kPi))
    fail("tilt", options.tilt, "an angle in [0, pi]");
}

/// The path by its length.
class Walk {
public:
  explicit Walk(const Scene& scene) : path_(scene.path)
  {
    if (path_.empty())
      throw SimulationError("scene '" + scene.name + "' has no path for the sensor");
    along_.push_back(0);
    for (std::size_t i = 1; i < path_.size(); ++i)
      along_.push_back(along_.back() + (path_[i] - path_[i - 1]).norm());
    if (!std::isfinite(along_.back()))
      throw SimulationError("the path of scene '" + scene.name + "' has a point that is not finite");
  }

  double
  length() const
  {
    return along_.back();
  }

  /// Where one is after \p distance, turning at both ends; in [0, length()].
  double
  fold(double distance) const
  {
    if (length() <= 0)
      return 0;
    const double phase = std::fmod(distance, 2 * length());
    return phase <= length() ? phase : 2 * length() - phase;
  }

  Eigen::Vector3d
  at(double s) const
  {
    const double clamped = std::clamp(s, 0.0, length());
    const auto next = std::lower_bound(along_.begin(), along_.end(), clamped);
    const auto i = static_cast<std::size_t>(next - along_.begin());
    if (i == 0)
      return path_.front();
    const double piece = along_[i] - along_[i - 1];
    return path_[i - 1] + (path_[i] - path_[i - 1]) * ((clamped - along_[i - 1]) / piece);
  }

  /// Direction of the path on the ground: of the chord about the place, at a turning point of what lies ahead.
  double
  heading(double s) const
  {
    for (const double behind : {kHeadingWindow, 0.0}) {
      const Eigen::Vector2d chord = (at(s + kHeadingWindow) - at(s - behind)).head<2>();
      if (chord.norm() > kHeadingWindow / 4)
        return std::atan2(chord.y(), chord.x());
    }
    const Eigen::Vector2d back = (at(s) - at(s - kHeadingWindow)).head<2>();
    return back.norm() > 0 ? std::atan2(back.y(), back.x()) : 0;
  }

private:
  const std::vector<Eigen::Vector3d>& path_;
  std::vector<double> along_; ///< length of the path up to each point [m]
};

/// How far along the walk scan \p i is taken: at the stations, then between them at even shares [m].
double
stationPlace(const std::vector<double>& stations, std::size_t i)
{
  if (i < stations.size())
    return stations[i];
  const std::size_t gaps = std::max<std::size_t>(1, stations.size() - 1);
  const std::size_t k = (i - stations.size()) % gaps;
  // 1/2, 1/4, 3/4, 1/8, ...: the bits of the round, mirrored.
  double share = 0;
  double bit = 0.5;
  for (std::size_t round = 1 + (i - stations.size()) / gaps; round > 0; round /= 2) {
    share += static_cast<double>(round % 2) * bit;
    bit /= 2;
  }
  return stations[k] + share * (stations[std::min(k + 1, stations.size() - 1)] - stations[k]);
}

template <typename Place>
Poses
posesAt(const Walk& walk, const SensorModel& sensor, const TrajectoryOptions& options, const Place& place)
{
  Poses poses;
  for (int i = 0; i < options.scans; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    const double s = place(i);
    RandomStream random(options.seed, number, kTiltStream);
    // Two of them differ by no more than the turn.
    const double turn = random.uniform(-options.turn / 2, options.turn / 2);
    const double roll = random.uniform(-options.tilt, options.tilt);
    const double pitch = random.uniform(-options.tilt, options.tilt);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        (Eigen::AngleAxisd(walk.heading(s) + turn, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    if (options.random_rotation)
      T.linear() = (T.linear() * RandomStream(options.seed, number, kRotationStream).rotation()).eval();
    T.translation() = walk.at(s) + Eigen::Vector3d(0, 0, sensor.mount_height);
    poses.push_back(T);
  }
  return poses;
}

/// One scan after each step.
Poses
posesAt(const Walk& walk, const SensorModel& sensor, const TrajectoryOptions& options, double step)
{
  return posesAt(walk, sensor, options, [&](int i) { return walk.fold(step * i); });
}

/// Which directions a sensor looks in.
class FieldOfView {
public:
  explicit FieldOfView(const SensorModel& sensor) : pattern_(sensor.pattern)
  {
    if (pattern_.kind == PatternKind::Rings) {
      std::vector<double> rings = pattern_.ring_elevations;
      std::sort(rings.begin(), rings.end());
      // Between the rings counts as seen, and half a gap beyond the outermost.
      const double gap =
          rings.size() > 1 ? (rings.back() - rings.front()) / static_cast<double>(rings.size() - 1) : kLoneRing;
      lowest_ = rings.front() - gap / 2;
      highest_ = rings.back() + gap / 2;
    }
    if (pattern_.kind == PatternKind::TurningLine)
      fillGrid(sensor);
  }

  /// \p direction in the sensor frame, any length.
  bool
  covers(const Eigen::Vector3d& direction) const
  {
    const double elevation = std::atan2(direction.z(), direction.head<2>().norm());
    const double azimuth = std::atan2(direction.y(), direction.x());
    switch (pattern_.kind) {
    case PatternKind::TurningLine:
      return cells_[cellOf(azimuth, elevation)];
    case PatternKind::Rings:
      return elevation >= lowest_ && elevation <= highest_ && coversAzimuth(azimuth);
    case PatternKind::Sphere:
    case PatternKind::Rosette:
      break;
    }
    return elevation >= pattern_.elevation_min && elevation <= pattern_.elevation_max && coversAzimuth(azimuth);
  }

private:
  static constexpr double kLoneRing = 0.02;         // width of a single ring [rad]
  static constexpr double kCell = kPi / 60;         // of the grid of directions [rad]
  static constexpr std::size_t kRows = 60;          // of elevation
  static constexpr std::size_t kColumns = 120;      // of azimuth, at every elevation
  static constexpr std::size_t kMostBeams = 200000; // looked at

  bool
  coversAzimuth(double azimuth) const
  {
    const double span = pattern_.azimuth_max - pattern_.azimuth_min;
    double beyond = std::fmod(azimuth - pattern_.azimuth_min, 2 * kPi);
    if (beyond < 0)
      beyond += 2 * kPi;
    return span >= 2 * kPi - kCell / 2 || beyond <= span;
  }

  static std::size_t
  cellOf(double azimuth, double elevation)
  {
    const double row = std::floor((elevation + kPi / 2) / kCell);
    const double column = std::floor((azimuth + kPi) / kCell);
    return static_cast<std::size_t>(std::clamp(row, 0.0, kRows - 1.0)) * kColumns +
           static_cast<std::size_t>(std::clamp(column, 0.0, kColumns - 1.0));
  }

  /// Marks the cells beams pass through; one near the poles stands for its whole width in angle.
  void
  fillGrid(const SensorModel& sensor)
  {
    cells_.assign(kRows * kColumns, false);
    const std::size_t count = beamCount(sensor);
    const std::size_t taken = std::min(count, kMostBeams);
    const double stride = static_cast<double>(count) / static_cast<double>(taken);
    for (std::size_t i = 0; i < taken; ++i) {
      const auto index = static_cast<std::size_t>(static_cast<double>(i) * stride);
      const Eigen::Vector3d direction = beamAt(sensor, index, 0).direction;
      const double elevation = std::atan2(direction.z(), direction.head<2>().norm());
      const double azimuth = std::atan2(direction.y(), direction.x());
      const double half = kCell / 2 / std::max(std::cos(elevation), kCell / (2 * kPi));
      for (double a = azimuth - half; a <= azimuth + half; a += kCell / 2)
        cells_[cellOf(std::remainder(a, 2 * kPi), elevation)] = true;
    }
  }

  const BeamPattern& pattern_;
  double lowest_ = 0;
  double highest_ = 0;
  std::vector<bool> cells_; ///< TurningLine only
};

double
overlapOf(const RayCaster& scene,
          const SensorModel& sensor,
          const RangeModel& target_range,
          const FieldOfView& target_view,
          const Eigen::Isometry3d& T_world_source,
          const Eigen::Isometry3d& T_world_target,
          std::size_t rays)
{
  const std::size_t beams = beamCount(sensor);
  const RangeModel& range = sensor.range;
  const Eigen::Isometry3d T_target_world = T_world_target.inverse();
  const Eigen::Vector3d& target = T_world_target.translation();
  std::size_t seen = 0;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < std::min(rays, beams); ++i) {
    // All of them, or golden multiples: no rhythm with the rows of a pattern.
    double share = (static_cast<double>(i) + 0.5) * kGolden;
    share -= std::floor(share);
    const std::size_t index =
        rays >= beams ? i : std::min(beams - 1, static_cast<std::size_t>(share * static_cast<double>(beams)));
    const Eigen::Vector3d direction = T_world_source.linear() * beamAt(sensor, index, 0).direction;
    const auto hit = scene.cast(T_world_source.translation(), direction, range.max_range);
    if (!hit || hit->distance < range.min_range)
      continue;
    ++seen;
    const Eigen::Vector3d point = T_world_source.translation() + hit->distance * direction;
    const Eigen::Vector3d back = target - point;
    const double distance = back.norm();
    // A surface is seen from its own side only: both sides of a thin one are different places.
    const bool same_side = distance == 0 || hit->normal.dot(back) > 0;
    if (distance >= target_range.min_range && distance <= target_range.max_range && same_side &&
        target_view.covers(T_target_world * point) && scene.isVisible(point, target))
      ++shared;
  }
  return seen > 0 ? static_cast<double>(shared) / static_cast<double>(seen) : 0;
}

/// Poses whose consecutive scans overlap as wanted.
class OverlapSearch {
public:
  OverlapSearch(const Walk& walk,
                const RayCaster& surfaces,
                const SensorModel& sensor,
                const TrajectoryOptions& options)
      : walk_(walk), surfaces_(surfaces), sensor_(sensor), options_(options), view_(sensor)
  {}

  Poses
  run()
  {
    // A row of steps; between two neighbours on either side of the wanted overlap, bisection.
    std::array<double, kGridSteps> steps{};
    std::array<double, kGridSteps> overlaps{};
    const double longest = std::max(walk_.length(), 2 * kSmallestStep);
    for (int i = 0; i < kGridSteps; ++i) {
      const auto k = static_cast<std::size_t>(i);
      steps[k] = kSmallestStep * std::pow(longest / kSmallestStep, static_cast<double>(i) / (kGridSteps - 1));
      overlaps[k] = measure(steps[k]);
    }
    for (std::size_t i = 0; i + 1 < steps.size() && nearest_ > kOverlapTolerance; ++i)
      if ((overlaps[i] - options_.overlap) * (overlaps[i + 1] - options_.overlap) < 0)
        bisect(steps[i], steps[i + 1], overlaps[i] > options_.overlap);
    if (nearest_ > kOverlapAccepted) {
      std::ostringstream need;
      need.precision(3);
      need << "a share that the path allows: steps from " << kSmallestStep << " to " << longest << " m give " << lowest_
           << " to " << highest_;
      fail("overlap", options_.overlap, need.str());
    }
    return posesAt(walk_, sensor_, options_, best_step_);
  }

private:
  double
  measure(double step)
  {
    const Poses poses = posesAt(walk_, sensor_, options_, step);
    const std::size_t pairs = poses.size() - 1;
    const std::size_t taken = std::min(pairs, kMostPairs);
    double sum = 0;
    for (std::size_t i = 0; i < taken; ++i) {
      const std::size_t k = i * pairs / taken;
      sum += overlapOf(surfaces_, sensor_, sensor_.range, view_, poses[k + 1], poses[k], kPairRays);
    }
    const double overlap = sum / static_cast<double>(taken);
    const double error = std::abs(overlap - options_.overlap);
    if (error < nearest_) {
      nearest_ = error;
      best_step_ = step;
    }
    lowest_ = std::min(lowest_, overlap);
    highest_ = std::max(highest_, overlap);
    return overlap;
  }

  void
  bisect(double low, double high, bool low_is_above)
  {
    for (int i = 0; i < kBisections && nearest_ > kOverlapTolerance / 4; ++i) {
      const double middle = std::sqrt(low * high);
      if ((measure(middle) > options_.overlap) == low_is_above)
        low = middle;
      else
        high = middle;
    }
  }

  const Walk& walk_;
  const RayCaster& surfaces_;
  const SensorModel& sensor_;
  const TrajectoryOptions& options_;
  FieldOfView view_;
  double nearest_ = std::numeric_limits<double>::infinity(); ///< error of the best step
  double best_step_ = 0;
  double lowest_ = 1;
  double highest_ = 0;
};

} // namespace

std::vector<Eigen::Isometry3d>
makeTrajectory(const Scene& scene,
               const RayCaster& surfaces,
               const SensorModel& sensor,
               const TrajectoryOptions& options)
{
  requireValid(options);
  const Walk walk(scene);
  if (options.scans > 1 && !(walk.length() > 0))
    throw SimulationError("the path of scene '" + scene.name + "' is a single point: only one scan can be taken");
  if (options.overlap > 0 && options.scans > 1)
    return OverlapSearch(walk, surfaces, sensor, options).run();
  if (options.step == 0 && !scene.stations.empty())
    return posesAt(
        walk, sensor, options, [&](int i) { return stationPlace(scene.stations, static_cast<std::size_t>(i)); });
  const double step = options.step > 0 ? options.step : scene.natural_step;
  return posesAt(walk, sensor, options, step);
}

double
visibleOverlap(const RayCaster& scene,
               const SensorModel& source,
               const SensorModel& target,
               const Eigen::Isometry3d& T_world_source,
               const Eigen::Isometry3d& T_world_target,
               std::size_t rays)
{
  if (rays == 0)
    fail("rays", rays, "1 or more");
  return overlapOf(scene, source, target.range, FieldOfView(target), T_world_source, T_world_target, rays);
}

double
visibleOverlap(const RayCaster& scene,
               const SensorModel& sensor,
               const Eigen::Isometry3d& T_world_source,
               const Eigen::Isometry3d& T_world_target,
               std::size_t rays)
{
  return visibleOverlap(scene, sensor, sensor, T_world_source, T_world_target, rays);
}

} // namespace pcl_ssfr::simulation
