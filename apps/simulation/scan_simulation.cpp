// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/scan_simulation.h>

#include <apps/common/random_stream.h>
#include <apps/simulation/simulation_error.h>

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

constexpr std::size_t kChunkBeams = 4096; // beams a thread takes at once
constexpr std::size_t kChunksAtOnce = 64; // chunks between two reports of progress
constexpr double kRigidTolerance = 1e-6;  // of the entries of a rotation
constexpr double kSmallAngle = 1e-8;      // [rad]; below, a rotation is one of first order
constexpr double kLeastSignal = 0.8;      // share of the needed signal below which nothing comes back
constexpr double kMixedSigmas = 3;        // a neighbouring surface counts as another one from so many sigma on,
constexpr double kMixedDistance = 1e-3;   // and from this distance on [m]
constexpr double kTwoPi = 6.283185307179586;

/// What one beam brought.
enum class Outcome { Return, OutOfRange, Lost };

struct Echo {
  Outcome outcome = Outcome::OutOfRange;
  double range = 0;
  double intensity = 0;
  bool mixed = false;
};

/// A surface in the light of a beam.
struct Lit {
  double range = 0;
  double intensity = 0; ///< reflectance times cosine of incidence
};

struct Chunk {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> intensity;
  std::vector<std::uint32_t> beam;
  std::size_t out_of_range = 0;
  std::size_t lost = 0;
  std::size_t mixed = 0;

  void
  clear()
  {
    points.clear();
    intensity.clear();
    beam.clear();
    out_of_range = lost = mixed = 0;
  }
};

/// The share of a motion that is over at \p time: exp(time * (velocity, angular_velocity)).
Eigen::Isometry3d
motionAt(const Eigen::Vector3d& velocity, const Eigen::Vector3d& angular_velocity, double time)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d way = time * velocity;
  const Eigen::Vector3d turn = time * angular_velocity;
  const double angle = turn.norm();
  if (angle < kSmallAngle) {
    T.translation() = way + turn.cross(way) / 2;
    if (angle > 0)
      T.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    return T;
  }
  const Eigen::Vector3d axis = turn / angle;
  T.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  T.translation() = way + (1 - std::cos(angle)) / angle * axis.cross(way) +
                    (1 - std::sin(angle) / angle) * axis.cross(axis.cross(way));
  return T;
}

/// Two unit vectors across \p direction: along its azimuth and along its elevation.
std::pair<Eigen::Vector3d, Eigen::Vector3d>
across(const Eigen::Vector3d& direction)
{
  const double horizontal = std::hypot(direction.x(), direction.y());
  const Eigen::Vector3d side = horizontal > 0
                                   ? Eigen::Vector3d(-direction.y() / horizontal, direction.x() / horizontal, 0)
                                   : Eigen::Vector3d(Eigen::Vector3d::UnitY());
  return {side, direction.cross(side)};
}

/// Fires beams; the formulas are in docs/SIMULATOR.md.
class Gun {
public:
  Gun(const RayCaster& scene, const RangeModel& model)
      : scene_(scene), model_(model), needed_(model.reference_reflectance / (model.max_range * model.max_range))
  {}

  /// The exact first surface.
  Echo
  measureExactly(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const
  {
    Echo echo;
    const auto hit = scene_.cast(origin, direction, model_.max_range);
    if (!hit || hit->distance < model_.min_range)
      return echo;
    echo.outcome = Outcome::Return;
    echo.range = hit->distance;
    echo.intensity = lit(*hit, direction).intensity;
    return echo;
  }

  /// A measurement with everything that goes wrong in one. \p to_world turns sensor directions into the world.
  Echo
  measure(const Eigen::Vector3d& origin,
          const Eigen::Matrix3d& to_world,
          const Eigen::Vector3d& nominal,
          RandomStream& random) const
  {
    Echo echo;
    Eigen::Vector3d direction = nominal;
    if (model_.angular_jitter > 0) {
      const auto [side, up] = across(nominal);
      const double aside = model_.angular_jitter * random.gaussian();
      const double above = model_.angular_jitter * random.gaussian();
      direction = (nominal + aside * side + above * up).normalized();
    }
    direction = to_world * direction;
    const auto hit = scene_.cast(origin, direction, model_.max_range);
    if (!hit || hit->distance < model_.min_range)
      return echo;

    double signal = 0;
    const Lit first = lit(*hit, direction);
    if (model_.beam_divergence > 0 || model_.beam_diameter > 0)
      signal = mix(origin, direction, *hit, first, random, echo);
    else {
      echo.range = first.range;
      echo.intensity = first.intensity;
      signal = strength(first);
    }
    echo.outcome = received(signal, random) ? Outcome::Return : Outcome::Lost;
    if (echo.outcome == Outcome::Lost)
      return echo;
    echo.range = reported(echo.range, random);
    if (!(echo.range > 0))
      echo.outcome = Outcome::Lost;
    return echo;
  }

private:
  double
  sigmaAt(double range) const
  {
    return model_.sigma + model_.sigma_per_metre * range;
  }

  Lit
  lit(const RayHit& hit, const Eigen::Vector3d& direction) const
  {
    const double cosine = std::min(1.0, std::abs(hit.normal.dot(direction)));
    return {hit.distance, scene_.material(hit.material).reflectance * cosine};
  }

  /// Light that comes back from a surface that fills the beam: rho cos(theta) / r^2.
  static double
  strength(const Lit& surface)
  {
    return surface.intensity / (surface.range * surface.range);
  }

  /// True for a signal as strong as the data sheet's, false below kLeastSignal of it, by chance in between; and lost
  /// at random by the drop rate.
  bool
  received(double signal, RandomStream& random) const
  {
    const double share = signal / needed_;
    double chance = std::clamp((share - kLeastSignal) / (1 - kLeastSignal), 0.0, 1.0);
    chance *= 1 - model_.drop_rate;
    return chance >= 1 || (chance > 0 && random.uniform() < chance);
  }

  double
  reported(double range, RandomStream& random) const
  {
    range += model_.bias + sigmaAt(range) * random.gaussian();
    return model_.quantum > 0 ? std::round(range / model_.quantum) * model_.quantum : range;
  }

  /** The beam at two opposite points of its edge, in a random direction. Where another surface lies there, it covers a
   * random share of the beam. Two surfaces within a pulse length give one range between them, else the stronger one
   * rules. Returns the signal.
   */
  double
  mix(const Eigen::Vector3d& origin,
      const Eigen::Vector3d& direction,
      const RayHit& hit,
      const Lit& first,
      RandomStream& random,
      Echo& echo) const
  {
    echo.range = first.range;
    echo.intensity = first.intensity;
    const auto [side, up] = across(direction);
    const double angle = kTwoPi * random.uniform();
    const Eigen::Vector3d offset = std::cos(angle) * side + std::sin(angle) * up;
    const double spread = std::tan(model_.beam_divergence / 2);
    const double step = std::max(kMixedDistance, kMixedSigmas * sigmaAt(first.range));

    int others = 0;
    std::optional<Lit> second; // the nearer one, when there are two
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d from = origin + sign * model_.beam_diameter / 2 * offset;
      const Eigen::Vector3d along = (direction + sign * spread * offset).normalized();
      // Where this ray would meet the plane of the first surface.
      const double cosine = hit.normal.dot(along);
      const double expected = cosine < 0 ? hit.normal.dot(origin + hit.distance * direction - from) / cosine : -1.0;
      const auto neighbor = scene_.cast(from, along, model_.max_range);
      if (neighbor && expected > 0 && std::abs(neighbor->distance - expected) <= step)
        continue;
      ++others;
      if (neighbor && neighbor->distance >= model_.min_range && (!second || neighbor->distance < second->range))
        second = lit(*neighbor, along);
    }
    if (others == 0)
      return strength(first);

    // An edge covers less than half of the beam when the middle of the beam misses it.
    const double share = random.uniform(0, others == 1 ? 0.5 : 1.0);
    const double of_first = (1 - share) * strength(first);
    if (!second)
      return of_first;
    const double of_second = share * strength(*second);
    const double both = of_first + of_second;
    if (std::abs(second->range - first.range) < model_.pulse_length) {
      echo.mixed = true;
      echo.range = (of_first * first.range + of_second * second->range) / both;
      echo.intensity = (of_first * first.intensity + of_second * second->intensity) / both;
      return both;
    }
    if (of_second <= of_first)
      return of_first;
    echo.range = second->range;
    echo.intensity = second->intensity;
    return of_second;
  }

  const RayCaster& scene_;
  const RangeModel& model_;
  double needed_;
};

std::string
toText(const Eigen::Vector3d& v)
{
  std::ostringstream text;
  text << '(' << v.x() << ", " << v.y() << ", " << v.z() << ')';
  return text.str();
}

void
requireFinite(const std::string& name, const Eigen::Vector3d& v)
{
  if (!v.allFinite())
    throw SimulationError(name + " is " + toText(v) + ", needs finite numbers");
}

void
requireRigid(const Eigen::Isometry3d& T)
{
  requireFinite("position of the sensor", T.translation());
  const Eigen::Matrix3d R = T.linear();
  if (!((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRigidTolerance) ||
      R.determinant() < 0)
    throw SimulationError("rotation of the sensor has the columns " + toText(R.col(0)) + ", " + toText(R.col(1)) +
                          ", " + toText(R.col(2)) + ", needs unit vectors at right angles, right-handed");
}

} // namespace

SimulatedScan
simulateScan(const RayCaster& scene,
             const SensorModel& sensor,
             const Eigen::Isometry3d& T_world_sensor,
             const ScanOptions& options)
{
  validate(sensor);
  requireRigid(T_world_sensor);
  requireFinite("velocity", options.velocity);
  requireFinite("angular velocity", options.angular_velocity);

  const bool moves = !options.velocity.isZero(0) || !options.angular_velocity.isZero(0);
  const Gun gun(scene, sensor.range);
  const auto fire = [&](std::size_t index, Chunk& out) {
    const Beam beam = beamAt(sensor, index, options.scan);
    Eigen::Isometry3d T = T_world_sensor;
    if (moves)
      T = T * motionAt(options.velocity, options.angular_velocity, beam.time);
    Echo echo;
    if (options.noise) {
      RandomStream random(options.seed, options.scan, index);
      echo = gun.measure(T.translation(), T.linear(), beam.direction, random);
    }
    else
      echo = gun.measureExactly(T.translation(), T.linear() * beam.direction);
    switch (echo.outcome) {
    case Outcome::OutOfRange:
      ++out.out_of_range;
      break;
    case Outcome::Lost:
      ++out.lost;
      break;
    case Outcome::Return:
      out.points.emplace_back((echo.range * beam.direction).cast<float>());
      out.intensity.push_back(static_cast<float>(echo.intensity));
      out.beam.push_back(static_cast<std::uint32_t>(index));
      out.mixed += echo.mixed ? 1 : 0;
      break;
    }
  };

  SimulatedScan scan;
  scan.beams = beamCount(sensor);
  std::vector<Chunk> chunks(std::min(kChunksAtOnce, scan.beams / kChunkBeams + 1));
  for (Chunk& chunk : chunks) { // nothing is allocated while threads run
    chunk.points.reserve(kChunkBeams);
    chunk.intensity.reserve(kChunkBeams);
    chunk.beam.reserve(kChunkBeams);
  }
  [[maybe_unused]] const int threads = options.threads > 0 ? static_cast<int>(options.threads) : omp_get_max_threads();
  const auto count = static_cast<int>(chunks.size());
  for (std::size_t first = 0; first < scan.beams; first += chunks.size() * kChunkBeams) {
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (int c = 0; c < count; ++c) {
      Chunk& chunk = chunks[static_cast<std::size_t>(c)];
      chunk.clear();
      const std::size_t begin = first + static_cast<std::size_t>(c) * kChunkBeams;
      const std::size_t end = std::min(begin + kChunkBeams, scan.beams);
      for (std::size_t index = begin; index < end; ++index)
        fire(index, chunk);
    }
    for (const Chunk& chunk : chunks) {
      scan.points.insert(scan.points.end(), chunk.points.begin(), chunk.points.end());
      scan.intensity.insert(scan.intensity.end(), chunk.intensity.begin(), chunk.intensity.end());
      scan.beam.insert(scan.beam.end(), chunk.beam.begin(), chunk.beam.end());
      scan.out_of_range += chunk.out_of_range;
      scan.lost += chunk.lost;
      scan.mixed += chunk.mixed;
    }
    if (options.progress)
      options.progress(static_cast<double>(std::min(first + chunks.size() * kChunkBeams, scan.beams)) /
                       static_cast<double>(scan.beams));
  }
  return scan;
}

} // namespace pcl_ssfr::simulation
